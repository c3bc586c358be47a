"""Columns of MATLAB that have no names: by the words beside them, or in the order of the channels, and it is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.io

import stickslip as ss
from stickslip.measured.inspection import inspect

N = 200
T = 0.002 * np.arange(N)
F = 1.5 + 0.4 * np.sin(0.3 * np.arange(N))
X = 0.1 * np.cos(0.2 * np.arange(N))
RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
TABLE = np.c_[X, F, T]
WORDS = ["x", "F [N]", "t"]  # not in the order of the channels


def cell(rows) -> np.ndarray:
    made = np.empty((len(rows), len(rows[0])), dtype=object)
    for i, row in enumerate(rows):
        made[i, :] = row
    return made


def version5(file: Path, holds: dict) -> None:
    scipy.io.savemat(file, holds)


def version73(file: Path, holds: dict) -> None:
    """Like MATLAB: transposed, groups for structs, references into #refs# for cells."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(file, "w", userblock_size=512) as f:
        count = 0

        def put(name, value):
            nonlocal count
            if isinstance(value, dict):
                for key, one in value.items():
                    put(f"{name}/{key}", one)
                return None
            if isinstance(value, str) or np.asarray(value).dtype.kind == "U":
                codes = [[ord(c) for c in row] for row in np.atleast_1d(value)]
                f[name] = np.array(codes, dtype=np.uint16).T
                kind = "char"
            elif isinstance(value, np.ndarray) and value.dtype == object:
                inner = []
                for one in value.T.ravel():  # down the columns
                    count += 1
                    inner.append(put(f"#refs#/{count}", one))
                f.create_dataset(
                    name, data=np.array(inner, dtype=object).reshape(value.T.shape), dtype=h5py.ref_dtype
                )
                kind = "cell"
            else:
                array = np.asarray(value)
                f[name] = (array[:, None] if array.ndim == 1 else array).T
                kind = "double"
            f[name].attrs["MATLAB_class"] = np.bytes_(kind)
            return f[name].ref

        for name, value in holds.items():
            put(name, value)
    with file.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


@pytest.fixture(params=[version5, version73], ids=["version 5", "version 7.3"])
def saved(request, tmp_path):
    def save(holds: dict) -> Path:
        request.param(tmp_path / "run.mat", holds)
        return tmp_path / "run.mat"

    return save


def load(file: Path, t: str, force: str) -> ss.Recording:
    channels = {"t": ss.Channel(t, "s"), "spring_force": ss.Channel(force, "N")}
    return ss.load_recording(file, RIG, channels=channels, belt_speed="5 mm/s")


def right(run: ss.Recording) -> bool:
    return np.array_equal(run.raw["t"], T) and np.array_equal(run.raw["spring_force"], F)


TITLED = {
    "importdata's struct": {"run": {"data": TABLE, "colheaders": cell([WORDS])}},
    "a cell of words beside a matrix": {
        "names": cell([[one] for one in WORDS]),
        "data": TABLE,
        "rate": 500.0,
    },
    "rows of a char matrix": {"names": np.array(["x    ", "F [N]", "t    "]), "data": TABLE},
    "words above vectors": {"data": cell([WORDS, [X, F, T]])},
    "words before vectors": {"data": cell([["x", X], ["F [N]", F], ["t", T]])},
}


@pytest.mark.parametrize("holds", TITLED.values(), ids=TITLED)
def test_words_beside_columns_are_their_names(saved, holds):
    file = saved(holds)
    assert right(load(file, "t", "F"))
    found = inspect(file)
    force = found.column("F")
    assert force is not None
    assert force.unit == "N"
    assert found.time is not None
    assert found.time.head == "t"
    channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("F", "mm")}
    with pytest.raises(ss.InputError, match=r"the file has 'F \[N\]', but its channel is declared in 'mm'"):
        ss.load_recording(file, RIG, channels=channels, belt_speed="5 mm/s")


ORDERED = {
    "a matrix": ({"data": np.c_[T, F]}, ("data", "data")),
    "a cell": ({"data": cell([[T, F]])}, ("t", "F")),
    "a matrix, its name unknown": ({"data": np.c_[T, F]}, ("t", "F")),
    "a matrix beside others": ({"data": np.c_[T, F], "more": TABLE, "rate": 500.0}, ("data", "data")),
    "a matrix in a struct": ({"run": {"data": np.c_[T, F], "rate": 500.0}}, ("run.data", "run.data")),
}


@pytest.mark.parametrize(("holds", "names"), ORDERED.values(), ids=ORDERED)
def test_columns_without_names_are_taken_in_order_and_it_is_said(saved, holds, names):
    run = load(saved(holds), *names)
    assert right(run)
    said = [str(one) for one in run.findings if "no names" in str(one)]
    assert len(said) == 1
    assert "is t, " in said[0]
    assert said[0].endswith("is spring_force")


REFUSED = {
    "the order is another": ({"data": np.c_[F, T]}, ("data", "data"), "times must increase|swapped"),
    "more columns than channels": ({"data": TABLE}, ("data", "data"), "has 3 columns"),
    "more columns, unknown names": ({"data": TABLE}, ("t", "F"), r"missing; the file has .*data\(:,1\)"),
    "other columns with names": ({"data": np.c_[T, F], "v": T}, ("t", "F"), "missing; the file has"),
    "a vector named twice": ({"t": T, "F": F}, ("t", "t"), "each has its own column"),
    "one of two names is known": ({"data": cell([["a", "b"], [T, F]])}, ("a", "F"), "missing"),
}


@pytest.mark.parametrize(("holds", "names", "words"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_told_is_refused_in_one_line(saved, holds, names, words):
    with pytest.raises(ss.InputError, match=words) as caught:
        load(saved(holds), *names)
    assert "\n" not in str(caught.value)


def test_a_copied_line_of_channels_is_refused_for_text_too(tmp_path):
    file = tmp_path / "run.csv"
    np.savetxt(file, np.c_[T, F], delimiter=",", header="t,F", comments="")
    with pytest.raises(ss.InputError, match="each has its own column"):
        load(file, "t", "t")


def test_a_column_that_is_not_there_is_missed_among_the_words_of_the_others(saved) -> None:
    file = saved({"names": cell([["Time", "Force [N]"]]), "data": np.c_[T, F]})
    with pytest.raises(ss.InputError, match=r"'t': missing; the file has Time, Force \[N\]"):
        load(file, "t", "F")
    file = saved({"names": cell([["Time", "Force"]]), "data": np.c_[T, F], "more": np.c_[T, F]})
    with pytest.raises(ss.InputError, match=r"missing; the file has .*data.*1.*more.*2"):
        load(file, "t", "F")
