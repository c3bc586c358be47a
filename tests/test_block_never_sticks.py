"""Discovery on a block one of whose runs never sticks: the tops of its swings are no sticks."""

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from scattering import FORCE_NOISE, KINETIC, MASS, PERIOD, STATIC, STIFFNESS, block_case

BELT, TOP = 0.14, 0.85  # speed of the belt, m/s, and that of the swing over it


@pytest.mark.study
def test_a_run_that_only_swings_is_said_and_hides_nothing(tmp_path: Path) -> None:
    """It was cut where it came near the belt's speed: friction and belt took the rest, and a mass was named."""
    effect = ss.effect("spring_cubic_k1", k=2.4e6)
    path = block_case(tmp_path, (effect,), few=True, seed=5)
    t = np.arange(0.0, 20 * PERIOD, PERIOD / 150)
    model = ss.Model(
        ss.BlockOnBelt(mass=MASS, stiffness=STIFFNESS),
        friction=ss.CoulombFriction(static=STATIC, kinetic=KINETIC),
        effects=[effect],
    )
    start = (KINETIC / STIFFNESS, TOP * BELT)
    swing = ss.simulate(model, belt_speed=BELT, initial=start, t_end=t[-1], t_eval=t)
    assert (swing.mode != 0).all()
    force = STIFFNESS * swing.state[:, 0] + FORCE_NOISE * np.random.default_rng(6).standard_normal(len(t))
    np.savetxt(tmp_path / "swing.csv", np.column_stack([t, force]), delimiter=",", header="t,F", comments="")
    run = f'[[run]]\nfile = "swing.csv"\nrole = "train"\nbelt_speed = {BELT}\n'
    path.write_text(path.read_text().replace("[channels]", run + "[channels]"))
    found = ss.discover(ss.load_case(path))
    assert [one.name for one in found.effects] == ["spring_cubic_k1"]
    own = found.effects[0].parameters["k"]
    assert own.low is not None
    assert own.high is not None
    assert own.low < effect.parameters["k"] < own.high
    assert any(
        one.startswith("swing: no stick is found in it: it is fitted from slip") for one in found.messages
    )
    assert {one.name for one in found.runs} == {"run_1", "run_2", "run_3", "swing"}
