"""Structs, cells and matrices of MATLAB files, of version 5 and of 7.3: a part is called as in MATLAB."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import scipy.io

import stickslip as ss
from stickslip.measured.readers.tables import column_names, open_table, read_columns

N = 200
T = 0.002 * np.arange(N)
F = 1.5 + 0.4 * np.sin(0.3 * np.arange(N))
RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)


def cells(*values) -> np.ndarray:
    made = np.empty((1, len(values)), dtype=object)
    made[0, :] = values
    return made


def version5(file: Path) -> None:
    structs = np.zeros((1, 2), dtype=[("t", object), ("F", object)])
    structs[0, 0], structs[0, 1] = (T, F), (T, -F)
    holds = {
        "run": {"t": T, "F": F, "rig": {"mass": 0.5, "name": "A"}, "empty": np.empty((0, 0))},
        "out": {"time": T[:, None], "signals": {"values": np.c_[F, 2 * F], "label": "F"}},
        "data": cells(T, F, "words", cells(3 * F)),
        "single": cells(F),
        "runs": structs,
        "matrix": np.c_[T, F],
        "plain": F,
    }
    scipy.io.savemat(file, holds)


def version73(file: Path) -> None:
    """Like MATLAB: transposed, groups for structs, references into #refs# for cells and for arrays of structs."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(file, "w", userblock_size=512) as f:

        def put(name, values, kind="double"):
            f[name] = np.atleast_2d(values).T
            f[name].attrs["MATLAB_class"] = np.bytes_(kind)
            return f[name].ref

        def refer(name, *references, kind=""):
            f.create_dataset(name, data=np.array(references, dtype=object)[:, None], dtype=h5py.ref_dtype)
            if kind:
                f[name].attrs["MATLAB_class"] = np.bytes_(kind)
            return f[name].ref

        column = lambda values: np.asarray(values)[:, None]  # noqa: E731
        put("run/t", T), put("run/F", column(F)), put("run/rig/mass", 0.5)
        put("run/empty", [0, 0])
        f["run/empty"].attrs["MATLAB_empty"] = np.uint8(1)
        put("out/time", column(T)), put("out/signals/values", np.c_[F, 2 * F])
        inner = refer("#refs#/d", put("#refs#/e", 3 * F), kind="cell")
        words = put("#refs#/c", [[119, 111]], kind="char")
        refer("data", put("#refs#/a", T), put("#refs#/b", F), words, inner, kind="cell")
        refer("single", put("#refs#/f", F), kind="cell")
        refer("runs/t", put("#refs#/g", T), put("#refs#/h", T))
        refer("runs/F", put("#refs#/i", F), put("#refs#/j", -F))
        put("matrix", np.c_[T, F]), put("plain", F)
    with file.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


PARTS = {
    "run.t": T,
    "run.F": F,
    "out.time": T,
    "out.signals.values(:,2)": 2 * F,
    "data{1}": T,
    "data{2}": F,
    "data{4}{1}": 3 * F,
    "single{1}": F,
    "runs(2).t": T,
    "runs(2).F": -F,
    "matrix(:,2)": F,
    "plain": F,
    "time": T,  # the only one of this name
}


@pytest.fixture(params=[version5, version73], ids=["version 5", "version 7.3"])
def file(request, tmp_path) -> Path:
    request.param(tmp_path / "run.mat")
    return tmp_path / "run.mat"


@pytest.mark.parametrize("name", PARTS)
def test_a_part_is_called_as_in_matlab(file, name):
    found = read_columns(file, [name, "matrix(:,1)"]).values
    np.testing.assert_array_equal(found[name], PARTS[name])
    np.testing.assert_array_equal(found["matrix(:,1)"], T)


def test_every_vector_is_listed_once(file):
    names = [one.replace("/", ".") for one in column_names(file)]
    assert len(names) == len(set(names))
    assert set(PARTS) - {"time"} <= set(names)
    assert "run.rig.mass" in names


def test_a_struct_makes_a_recording(file):
    channels = {"t": ss.Channel("run.t", "s"), "spring_force": ss.Channel("run.F", "N")}
    recording = ss.load_recording(file, RIG, channels=channels, belt_speed="5 mm/s")
    np.testing.assert_allclose(recording.x1 * 500, F)
    np.testing.assert_allclose(recording.t, T)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("run", r"column 'run': missing; the file has .*run.t"),
        ("run.f", r"missing; the file has .*did you mean 'run.F'"),
        ("data{3}", r"words; a channel is a real vector|char array"),
        ("matrix", r"missing; the file has .*matrix\(:,1\)"),
        ("F", r"missing; the file has"),  # run.F, runs(1).F and runs(2).F
        ("run.empty", r"empty double array|float64 array of shape \(0, 0\)"),
    ],
)
def test_what_is_no_column_is_refused_in_one_line(file, name, words):
    with pytest.raises(ss.InputError) as caught:
        read_columns(file, [name])
    said = str(caught.value)
    assert "\n" not in said
    assert re.search(words, said.replace(f"{file.parent}/", "").replace("/", ".")), said


def test_the_short_name_is_known_before_reading(file):
    assert open_table(file).contents.also["time"].replace("/", ".") == "out.time"
