"""Cases of rigs of bodies and matrices: channels by the names of coordinates, prescribed speeds, uncertainties."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from bodies_files import written
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError
from test_general_rigs import DRILL

T = np.arange(0.0, 1.0, 0.01)
WAVES = np.column_stack([0.01 * np.sin(9 * T), 0.002 * np.cos(7 * T)])

DRILL_CASE = (
    DRILL
    + """
[noise]
bit = 0.1
[uncertainty]
table.inertia = "1 %"
bit = 0.002
[channels]
t = { column = "time", unit = "s" }
bit = { column = "angle", unit = "deg" }
v_table = { column = "speed", unit = "rpm" }
drive = { column = "top", unit = "rpm" }
[[run]]
file = "run.csv"
role = "train"
drive_speed = 12.0
"""
)


def drill(folder: Path, change: Callable[[str], str] = str) -> Path:
    """A drill string's case, its text changed."""
    rows = np.column_stack([T, 90 * T, 12 + np.sin(T), np.full(len(T), 12.0)])
    np.savetxt(folder / "run.csv", rows, delimiter=",", header="time,angle,speed,top", comments="")
    (folder / "rig.toml").write_text(change(DRILL_CASE), encoding="utf-8")
    return folder / "rig.toml"


def test_readings_are_in_si(tmp_path: Path) -> None:
    case = ss.load_case(drill(tmp_path))
    (run,) = case.runs
    assert isinstance(case.rig, GeneralRig)
    assert run.coordinates["bit"] == pytest.approx(np.deg2rad(90 * T))
    assert run.coordinates["v_table"] == pytest.approx((12 + np.sin(T)) * 2 * np.pi / 60)
    assert run.speeds["drive_speed"].constant == pytest.approx(12 * 2 * np.pi / 60)
    assert run.noise["bit"] == pytest.approx(np.deg2rad(0.1))
    assert repr(run) == "<Recording 'run' (train): bit, v_table, drive, 100 samples; drive_speed 1.25664>"
    late = run.window(0.5, 2.0)
    assert len(late.coordinates["bit"]) == len(late.t) == 50


def test_uncertainties_are_those_declared_and_the_usual(tmp_path: Path) -> None:
    known = ss.load_case(drill(tmp_path)).uncertainty
    assert known.relative("table.inertia") == 0.01
    assert known.relative("bit.inertia") == 0.015
    assert known.relative("link_1.damping") == 0.15
    assert known.gains == {"bit": 0.002, "v_table": 0.005}


def test_a_model_keeps_its_channels(tmp_path: Path) -> None:
    model = ss.load_case(drill(tmp_path)).model()
    model.save(tmp_path / "model.toml")
    again = ss.load_model(tmp_path / "model.toml")
    assert again.channels == model.channels
    assert again.noise == {"bit": 0.1}


def test_matrices_have_uncertain_entries_once(tmp_path: Path) -> None:
    rig = ss.load_case(written(tmp_path, [("train", T, WAVES)])).rig
    assert isinstance(rig, GeneralRig)
    assert set(rig.uncertain) == {"M_11", "M_22", "K_11", "K_12", "K_22", "C_11", "C_22"}
    assert rig.tied("K_12") == ("K_12", "K_21")
    assert rig.tied("K_11") == ("K_11",)


def test_a_drive_that_is_read_says_where_it_is(tmp_path: Path) -> None:
    from stickslip.fitted.bodies_data import prepare_bodies

    rig = ss.load_case(drill(tmp_path)).rig
    assert isinstance(rig, GeneralRig)
    columns = {"t": T, "bit": np.sin(20 * T), "x_drive": 0.7 + 1.26 * T}
    run = ss.load_recording(columns, rig, drive_speed=1.26)
    assert prepare_bodies(rig, [run])[0].drawn == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("bit = { column", "bitt = { column", "unknown channel of this rig; did you mean 'bit'?"),
        ('unit = "deg"', 'unit = "mm"', "measures length, but this is an angle; give a unit like 'rad'"),
        ("drive_speed = 12.0", "", "missing: a link is pulled by the drive; give its speed"),
        ("drive_speed = 12.0", "drive_speed = '3 N'", "it must be"),
        ("drive_speed = 12.0", "drive_speed = 1\nbelt_speed = 1", "no contact rubs on a belt in this rig"),
        ("table.inertia =", "tabel.inertia =", "did you mean 'table.inertia'?"),
        (
            "role = ",
            "rig = { k = 1.0 }\nrole = ",
            "one rig is taken for all runs of a case of bodies or matrices",
        ),
        ("F_s", "F_x", "F_x"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(InputError, match=r"\S") as error:
        ss.load_case(drill(tmp_path, lambda text: text.replace(old, new)))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_speed_may_be_a_formula(tmp_path: Path) -> None:
    path = drill(
        tmp_path, lambda text: text.replace("drive_speed = 12.0", 'drive_speed = "1.2 + 0.1*sin(t)"')
    )
    run = ss.load_case(path).runs[0]
    assert float(run.speeds["drive_speed"](0.5)) == pytest.approx(1.2 + 0.1 * np.sin(0.5))


def test_a_notebook_shows_a_case_and_its_run(tmp_path: Path) -> None:
    """It ended in a KeyError."""
    case = ss.load_case(drill(tmp_path))
    assert "drive speed 1.25664" in case._repr_html_()
    assert "0.99 s" in case._repr_html_()
    assert "100 samples, 0.01 s apart; drive speed 1.25664" in case.runs[0]._repr_html_()
