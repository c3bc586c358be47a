"""`stickslip check`: what the runs can tell and what they cannot."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.cli.commands import main
from stickslip.declared.declaration import friction_table
from stickslip.declared.friction_law import FrictionLaw
from stickslip.fitted.can_tell import can_tell

RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
COULOMB = ss.CoulombFriction(static=2.0, kinetic=1.2)
SPEEDS = ((0.005, "train"), (-0.007, "train"), (0.01, "validate"))


def motion(law: FrictionLaw, speed: float, t: np.ndarray, *effects: ss.Effect) -> np.ndarray:
    model = ss.Model(RIG, friction=law, effects=list(effects))
    return ss.simulate(model, belt_speed=speed, initial=(0.0, speed), t_end=t[-1], t_eval=t).state[:, 0]


def case(
    folder: Path,
    law: FrictionLaw = COULOMB,
    speeds: Sequence[tuple[float, str]] = SPEEDS,
    dt: float = 0.002,
    noise: float = 1e-6,
    end: float = 12.0,
) -> ss.Case:
    lines = ["[rig]", 'kind = "block_on_belt"', "m = 0.5", "k = 500.0", "[friction]"]
    lines += [f"{key} = {value!r}".replace("'", '"') for key, value in friction_table(law).items()]
    for i, (speed, role) in enumerate(speeds):
        t = np.arange(0.0, end, dt)
        x = motion(law, speed, t) + noise * np.random.default_rng(i).standard_normal(t.size)
        np.savetxt(folder / f"r{i}.csv", np.c_[t, x], delimiter=",", header="t,x", comments="", fmt="%.10g")
        lines += ["[[run]]", f'file = "r{i}.csv"', f'role = "{role}"', f"belt_speed = {speed}"]
    lines += ["[channels]", 't = { column = "t", unit = "s" }', 'x1 = { column = "x", unit = "m" }']
    (folder / "rig.toml").write_text("\n".join(lines))
    return ss.load_case(folder)


def said(lacks: Sequence[str], words: str) -> bool:
    return any(words in one for one in lacks)


def test_runs_both_ways_at_two_speeds_lack_nothing(tmp_path: Path) -> None:
    telling = can_tell(case(tmp_path))
    assert telling.lacks == ()
    assert [(one.minus > 9, one.plus > 9) for one in telling.looks] == [
        (True, False),
        (False, True),
        (True, False),
    ]
    assert "constant_load" in telling.judged
    assert "constant_load" not in telling.hidden


def test_a_constant_load_hides_in_friction_while_all_slips_go_one_way(tmp_path: Path) -> None:
    telling = can_tell(case(tmp_path, speeds=SPEEDS[::2]))
    assert telling.hidden["constant_load"] < 1e-9
    assert said(telling.lacks, "no slip with v_w > 0")
    assert said(telling.lacks, "one belt speed")


@settings(max_examples=10, deadline=None)
@given(f=st.floats(-0.3, 0.3), speed=st.sampled_from([0.003, 0.005, 0.01]))
def test_what_is_said_to_hide_gives_the_same_readings(f: float, speed: float) -> None:
    """The algebra against the simulator: a load and a law whose levels are lower by it move the block alike."""
    t = np.arange(0.0, 6.0, 0.01)
    loaded = motion(COULOMB, speed, t, ss.effect("constant_load", f=f))
    other = motion(ss.CoulombFriction(static=2.0 + f, kinetic=1.2 + f), speed, t)
    np.testing.assert_allclose(loaded, other, atol=1e-7)


def test_a_law_that_bends_hides_damping(tmp_path: Path) -> None:
    law = ss.HyperbolicFriction(scale=1.0, decay=30.0, constant=1.0, quadratic=2.0)
    assert can_tell(case(tmp_path, law, SPEEDS[::2])).hidden["block_viscous_damping"] < 0.1
    assert "block_viscous_damping" not in can_tell(case(tmp_path)).hidden


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"dt": 0.03}, "sampling is coarse"),
        ({"end": 1.6}, "1 slip with v_w < 0 for 2 numbers of T_minus: too few"),
        ({"noise": 3e-4}, "times the noise"),
        ({"speeds": ((0.005, "train"),)}, "no run has role = 'validate'"),
        ({"end": 0.3}, "no slip between two sticks"),
    ],
)
def test_what_lacks_is_said(tmp_path: Path, change: dict[str, object], words: str) -> None:
    assert said(can_tell(case(tmp_path, **change)).lacks, words)  # type: ignore[arg-type]


def test_the_command_prints_it(tmp_path: Path) -> None:
    case(tmp_path, speeds=SPEEDS[::2])
    result = CliRunner().invoke(main, ["check", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "The runs cannot tell:" in result.output
    assert "constant_load: the numbers of the friction law take up all of its force" in result.output.replace(
        "\n", " "
    )


def test_the_rig_with_two_degrees(tmp_path: Path) -> None:
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    lines = ["[rig]", "alpha1 = 16.0", "alpha2 = 8.0", "beta3 = 4.0", "eta1 = 0.1", "eta12 = 0.2"]
    t = np.arange(0.0, 150.0, 0.05)
    for i, (speed, role) in enumerate(((0.1, "train"), (-0.15, "train"), (0.1, "validate"))):
        model = ss.Model(rig, friction=ss.PaperFriction())
        state = ss.simulate(model, belt_speed=speed, initial=(0.1, 0.1, 0, 0), t_end=t[-1], t_eval=t).state
        noisy = state[:, [0, 2]] + 1e-5 * np.random.default_rng(i).standard_normal((t.size, 2))
        np.savetxt(
            tmp_path / f"r{i}.csv", np.c_[t, noisy], delimiter=",", header="t,x1,y1", comments="", fmt="%.9g"
        )
        lines += ["[[run]]", f'file = "r{i}.csv"', f'role = "{role}"', f"belt_speed = {speed}"]
    lines += ["[channels]", *(f'{name} = {{ column = "{name}" }}' for name in ("t", "x1", "y1"))]
    (tmp_path / "rig.toml").write_text("\n".join(lines))
    telling = can_tell(ss.load_case(tmp_path))
    assert set(telling.hidden) == {"constant_load"}  # each branch of this law has levels of its own
    assert {"spring_cubic_k3", "normal_force_feedback", "static_aging"} <= set(telling.judged)


def test_a_driven_slider_is_refused_in_one_line() -> None:
    result = CliRunner().invoke(main, ["check", str(Path(__file__).parent.parent / "examples/emps")])
    assert result.exit_code == 2
    assert len(result.output.splitlines()) == 1


def test_a_direction_that_only_a_validate_run_shows_is_named(tmp_path: Path) -> None:
    telling = can_tell(case(tmp_path, speeds=((0.005, "train"), (0.01, "train"), (-0.007, "validate"))))
    assert said(
        telling.lacks, "no slip with v_w > 0: nothing is told of friction that way (T_plus); train on r2"
    )


def test_runs_without_a_slip_are_not_told_to_run_the_other_way(tmp_path: Path) -> None:
    telling = can_tell(case(tmp_path, speeds=SPEEDS[:2] + SPEEDS[2:], end=0.15))
    assert not said(telling.lacks, "no slip with")
    assert said(telling.lacks, "r0: no slip between two sticks")


def test_long_names_of_runs_are_whole_in_the_table(tmp_path: Path) -> None:
    case(tmp_path, speeds=((0.005, "train"), (0.01, "validate")))
    text = (tmp_path / "rig.toml").read_text()
    for i in (0, 1):
        name = f"a_recording_with_a_long_name_of_day_{i}.csv"
        (tmp_path / f"r{i}.csv").rename(tmp_path / name)
        text = text.replace(f"r{i}.csv", name)
    (tmp_path / "rig.toml").write_text(text)
    printed = CliRunner().invoke(main, ["check", str(tmp_path)]).output
    cells = "".join(line.split(" ")[0] for line in printed.splitlines())
    assert "a_recording_with_a_long_name_of_day_0" in cells
    assert "a_recording_with_a_long_name_of_day_1" in cells
    assert "e+0" not in printed  # a slip of some thousand times the noise
