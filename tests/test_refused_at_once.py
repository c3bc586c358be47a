"""What a call cannot mean is refused in one line, before anything is read, simulated or written."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import stickslip as ss
from stickslip.cli.commands import main
from stickslip.errors import InputError

BLOCK = ss.BlockOnBelt(mass=0.5, stiffness=500)
LAW = ss.CoulombFriction(static=2.0, kinetic=1.2)
DRILL = ss.BodiesRig(
    body={"table": ss.Body(inertia=2.0), "bit": ss.Body(inertia=0.4)},
    link=[
        ss.Link(between=("table", "drive"), stiffness=10.0, damping=1.0),
        ss.Link(between=("bit", "table"), stiffness=5.0, damping=0.1),
    ],
    contact=[ss.Contact(body="bit")],
)
T = np.arange(0.0, 2.0, 0.01)
X = np.abs((2 * T) % 1 - 0.5)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"role": "trian"}, "role = 'trian': must be 'train' or 'validate'"),
        (
            {"channels": {"t": "time", "x1": "Laser"}},
            "channels.t: must be a Channel, not str; like Channel('time', 'mm')",
        ),
        ({"channels": ["t", "x1"]}, "channels: must be a dict, not list; give a Channel by name"),
    ],
)
def test_a_recording_is_not_read_as_something_else(given: dict[str, object], said: str) -> None:
    with pytest.raises(InputError) as error:
        ss.load_recording({"t": T, "x1": X}, BLOCK, belt_speed=0.01, **given)  # type: ignore[arg-type]
    assert str(error.value) == said


@pytest.mark.parametrize("names", [[0, 1], [("t", "s"), ("x1", "m")], ["t", None]])
def test_columns_without_a_text_for_a_name_are_refused(names: list[object]) -> None:
    frame = pd.DataFrame(dict(enumerate((T, X))))
    frame.columns = pd.Index(names, tupleize_cols=False)
    with pytest.raises(InputError, match=r"columns are asked for by text; rename them"):
        ss.load_recording(frame, BLOCK, belt_speed=0.01)  # type: ignore[arg-type]


@pytest.mark.parametrize("load", [ss.load_case, ss.load_model, lambda one: ss.load_recording(one, BLOCK)])
@pytest.mark.parametrize("name", ["a" * 5000, "a\0b"])
def test_a_name_that_no_file_can_have_is_one_line(load, name: str) -> None:
    with pytest.raises(InputError) as error:
        load(name)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 400


def test_a_law_by_its_name_is_no_law() -> None:
    run = ss.load_recording({"t": T, "x1": X}, BLOCK, belt_speed=0.01)
    with pytest.raises(InputError, match=r"friction: must be a FrictionLaw or dict, not str; like Coulomb"):
        ss.identify(run, rig=BLOCK, friction="coulomb")  # type: ignore[arg-type]


def test_a_gear_to_the_ground_does_nothing() -> None:
    with pytest.raises(InputError, match="a gear to it does nothing"):
        ss.BodiesRig(
            body={"b": ss.Body(mass=1.0)},
            link=[ss.Link(between=("b", "ground"), stiffness=2.0, gear=3.0)],
            contact=[ss.Contact(body="b", against="belt")],
        )


def test_a_drive_that_turns_has_no_speed_in_metres() -> None:
    model = ss.Model(DRILL, friction=LAW)
    with pytest.raises(InputError, match="measures no speed of what moves in rad/s; give one like '30 rpm'"):
        ss.simulate(model, drive_speed="3 m/s", t_end=1.0)
    turning = ss.simulate(model, drive_speed="30 rpm", t_end=1.0)
    assert turning.state[-1] == pytest.approx(ss.simulate(model, drive_speed=np.pi, t_end=1.0).state[-1])


def test_a_speed_of_the_drive_is_swept() -> None:
    model, speeds = ss.Model(DRILL, friction=LAW), np.array([0.5, 1.0])
    swept = ss.sweep(model, {"drive_speed": speeds}, t_end=20.0, observe=["stick_fraction"])
    for i, one in enumerate(speeds):
        alone = ss.sweep(model, {"drive_speed": speeds[i : i + 1]}, t_end=20.0, observe=["stick_fraction"])
        run = ss.simulate(model, drive_speed=one, t_end=20.0, t_eval=np.linspace(0, 20, 20001))
        assert float(swept["stick_fraction"][i]) == float(alone["stick_fraction"][0])
        assert float(swept["stick_fraction"][i]) == pytest.approx(
            float(np.mean(run.mode[:, 0] == 0)), abs=1e-3
        )


def test_a_file_of_speeds_is_not_written_over(tmp_path: Path) -> None:
    ss.Model(BLOCK, friction=LAW).save(tmp_path / "model.toml")
    speed = tmp_path / "speed.csv"
    speed.write_text("t,belt\n0,0.01\n1,0.02\n", encoding="utf-8")
    before = speed.read_text(encoding="utf-8")
    asked = ["simulate", tmp_path / "model.toml", "--belt-speed", speed, "--t-end", "1", "--out", speed]
    result = CliRunner().invoke(main, [str(one) for one in asked])
    assert result.exit_code == 2
    assert "it would overwrite --belt-speed" in result.stderr
    assert speed.read_text(encoding="utf-8") == before


@pytest.mark.parametrize(
    "asked", [["discover", "x", "--seed", "9" * 9000], ["z" * 9000], ["--" + "z" * 9000]]
)
def test_a_refusal_quotes_little(asked: list[str]) -> None:
    result = CliRunner().invoke(main, asked)
    assert result.exit_code == 2
    assert len(result.stderr) < 500
    assert result.stderr.count("\n") == 1
