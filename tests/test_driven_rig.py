"""The rig kind "driven_slider": what loads, what is refused and how, and which commands have no use for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy

import driven_truth as truth
import stickslip as ss
from stickslip.declared.rig import DrivenSlider
from stickslip.errors import InputError


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    t, x, u = truth.record(4.0)
    np.savetxt(
        tmp_path / "run.csv",
        np.column_stack([t, 1e3 * x, u]),
        fmt="%.12g",
        delimiter=",",
        header="t,x,u",
        comments="",
    )
    (tmp_path / "rig.toml").write_text(truth.RIG.replace("17.4", "2.4"))
    return tmp_path


def changed(folder: Path, old: str, new: str) -> Path:
    text = (folder / "rig.toml").read_text()
    assert old in text
    (folder / "rig.toml").write_text(text.replace(old, new))
    return folder


def test_a_case_in_mm_and_volts_is_read_in_si(folder: Path) -> None:
    case = ss.load_case(folder)
    assert case.rig == DrivenSlider(mass=truth.MASS)
    _, x, u = truth.record(4.0)
    run = case.train[0]
    assert run.drive is not None
    np.testing.assert_allclose(run.x1, x[: len(run)], atol=1e-12)
    np.testing.assert_allclose(run.drive, truth.GAIN * u[: len(run)], rtol=1e-9, atol=1e-9)
    assert [len(one) for one in case.runs] == [1200, 800]
    later = run.window(1.0, 2.0)
    assert later.drive is not None
    assert len(later.drive) == len(later) == 500


def test_a_matlab_file_gives_the_same_run(folder: Path) -> None:
    csv = ss.load_case(folder).train[0]
    t, x, u = truth.record(4.0)
    scipy.io.savemat(folder / "run.mat", {"t": t[:, None], "x": 1e3 * x[:, None], "u": u[:, None], "g": 4.0})
    mat = ss.load_case(changed(folder, "run.csv", "run.mat")).train[0]
    assert csv.drive is not None
    assert mat.drive is not None
    np.testing.assert_allclose(mat.drive, csv.drive, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(mat.x1, csv.x1, atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("m = 12.0", "m = -12.0", "rig.toml line 5, [rig] key 'm' = -12.0: must be above 0"),
        ("m = 12.0", "m = 12.0\nk = 5.0", "[rig] key 'k': unknown; it must be one of m, c"),
        ("m = 12.0", "", "lacks 'm'; it needs m"),
        ("driven_slider", "driven_slide", "did you mean 'driven_slider'?"),
        (", scale = 4.0", "", "needs `scale`, the drive's gain in N for 1 of its unit"),
        ('unit = "V"', 'unit = "kg"', "measures mass, but this is a force"),
        ('unit = "mm"', 'unit = "1"', "the numbers of a driven slider are all SI or all bare"),
        ("drive = {", "y1 = {", "unknown channel of this rig; it must be one of t, x1, drive"),
        ("drive = {", "belt = {", "unknown channel of this rig"),
        ('role = "train"', 'role = "train"\nbelt_speed = 0.1', "a driven slider has no belt; leave it out"),
        ('column = "u"', 'column = "v"', "missing; the file has t, x, u"),
    ],
)
def test_bad_input_is_one_clear_line(folder: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        ss.load_case(changed(folder, old, new))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_other_rigs_still_need_their_belt_speed(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("t,x1\n" + "\n".join(f"{i},{i % 3}" for i in range(20)) + "\n")
    (tmp_path / "rig.toml").write_text(
        '[rig]\nkind = "block_on_belt"\nm = 1.0\nk = 1.0\n[[run]]\nfile = "run.csv"\nrole = "train"\n'
        '[channels]\nt = { column = "t", unit = "s" }\nx1 = { column = "x1", unit = "m" }\n'
    )
    with pytest.raises(InputError, match="lacks 'belt_speed'"):
        ss.load_case(tmp_path)


@pytest.mark.parametrize(
    ("old", "new"),
    [('unit = "mm"', 'unit = "m"'), ("scale = 4.0", "scale = -4.0"), ("scale = 4.0", "scale = 0.4")],
)
def test_a_wrong_unit_gain_or_sign_is_found_and_stops_the_search(folder: Path, old: str, new: str) -> None:
    case = ss.load_case(changed(folder, old, new))
    assert any("tell of a mass of" in one for one in case.findings)
    with pytest.raises(InputError, match=r"no verdict.*where 12 is declared"):
        ss.discover(case)


def test_a_model_of_it_survives_its_file(tmp_path: Path) -> None:
    effects = [
        ss.effect("position_ripple", a=0.5, L=0.004, phi=1.0),
        ss.effect("drive_lag", tau=3e-4),
        ss.effect("rig_mass", e=0.01),
        ss.tabulated("contact", "x1", [0.0, 0.1, 0.2], [0.0, 0.2, 0.1]),
    ]
    model = ss.Model(
        DrivenSlider(mass=3.0, damping=2.0), friction=ss.CoulombFriction(static=2, kinetic=1), effects=effects
    )
    model.save(tmp_path / "model.toml")
    assert ss.load_model(tmp_path / "model.toml") == model


def test_effects_of_other_rigs_are_refused_and_the_other_way_round() -> None:
    law = ss.CoulombFriction()
    with pytest.raises(InputError, match="'belt_seam' is not one of a DrivenSlider"):
        ss.Model(DrivenSlider(mass=1.0), friction=law, effects=[ss.effect("belt_seam", a=0.1, L=1.0)])
    with pytest.raises(InputError, match="'drive_lag' is for a DrivenSlider"):
        ss.Model(ss.BlockOnBelt(), friction=law, effects=[ss.effect("drive_lag", tau=1.0)])


def test_what_needs_a_belt_says_so(folder: Path) -> None:
    case = ss.load_case(folder)
    with pytest.raises(InputError, match="belt_speed: is for a named rig; leave it out for a driven slider"):
        ss.identify(case, belt_speed="plateau")
    with pytest.raises(InputError, match="neither belt nor spring; `stickslip identify` fits its law"):
        ss.limit_cycle(case.model(), belt_speed=0.1)
    with pytest.raises(InputError, match="drive: missing: the force on the slider"):
        ss.forecast(case.model(), case.train[0], horizon=1.0)
    with pytest.raises(InputError, match="a driven slider has neither belt nor spring"):
        ss.forecast(case.model(), case.train[0], belt_speed=0.0, drive=1.0, horizon=1.0)
    with pytest.raises(InputError, match="a driven slider has no belt"):
        ss.simulate(case.model(), belt_speed=0.1, drive=1.0, initial=(0.0, 0.0), t_end=1.0)
