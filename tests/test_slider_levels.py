"""The law of a block on a belt with a damper: forces from the ends of slips, against what the core simulates."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import stickslip as ss
from slider_cases import KINETIC, MASS, STATIC, STIFFNESS, case_of, rig_of
from stickslip.declared.effect import Effect, effect
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.discovery.laboratory.block_errors import ahead
from stickslip.discovery.laboratory.block_views import state_read
from stickslip.fitted.block_events.levels import carried, sliding
from stickslip.fitted.block_events.predict import state_behind
from stickslip.fitted.block_events.table import measure, prepare
from stickslip.simulated.simulate import simulate

RATIOS = [0.0, 0.005, 0.02, 0.05, 0.1]  # damping over critical damping


@pytest.mark.sampled(2)
@pytest.mark.parametrize("ratio", RATIOS)
def test_the_law_is_right_with_a_declared_damper(ratio: float, tmp_path: Path) -> None:
    case = case_of(rig_of(ratio), tmp_path)
    found = ss.discover(case)
    assert found.effects == ()  # the declared damper is not found once more
    for name, truth in (("static", STATIC), ("kinetic", KINETIC)):
        one = found.law[name]
        assert one.low is not None
        assert one.high is not None
        assert one.value == pytest.approx(truth, rel=1e-3)
        assert one.low < truth < one.high
    speed = 0.02
    swings = [
        simulate(model, belt_speed=speed, initial=(0, 0), t_end=8.0, t_eval=np.arange(4, 8, 1e-3)).state[:, 0]
        for model in (
            found.before,
            Model(rig_of(ratio), friction=CoulombFriction(static=STATIC, kinetic=KINETIC)),
        )
    ]
    assert np.ptp(swings[0]) == pytest.approx(np.ptp(swings[1]), rel=2e-3)
    assert swings[0].max() == pytest.approx(swings[1].max(), rel=1e-3)
    one = ahead(found.before, measure(prepare(case.validate[0])))
    assert one.nrmse < 0.05
    assert one.timing < 0.01


@pytest.mark.study
def test_a_damper_not_declared_is_found_and_the_law_beside_it_is_right(tmp_path: Path) -> None:
    rig = rig_of(0.1)
    case = replace(case_of(rig, tmp_path), rig=replace(rig, damping=0.0))
    runs = tuple(replace(run, rig=case.rig) for run in case.runs)
    found = ss.discover(replace(case, runs=runs))
    assert [one.name for one in found.effects] == ["block_viscous_damping"]
    assert found.effects[0].parameters["c"].value == pytest.approx(rig.damping, rel=0.01)
    assert found.law["kinetic"].value == pytest.approx(KINETIC, rel=2e-3)
    assert found.law["static"].value == pytest.approx(STATIC, rel=1e-3)
    # without the damper the law must make up for it
    assert found.law_before["kinetic"].value > 1.05 * KINETIC
    assert found.model.friction.static_limits[0] == pytest.approx(found.law["static"].value)


def ends(model: Model, speed: float) -> tuple[float, float]:
    """Deflections at a breakaway and at the capture behind it."""
    run = simulate(model, belt_speed=speed, initial=(0, speed), t_end=4.0, t_eval=np.array([4.0]), rtol=1e-11)
    at = np.flatnonzero(run.transitions.t > 1.0)[:3]
    x = run.transitions.state[at, 0]
    return float(x.max()), float(x.min())


@pytest.mark.parametrize(
    ("effects", "exact"),
    [
        ([], 1e-6),
        ([effect("block_viscous_damping", c=2.0)], 1e-6),
        ([effect("rig_stiffness", e=0.1)], 1e-6),
        ([effect("rig_mass", e=-0.2), effect("block_viscous_damping", c=2.0)], 1e-6),
        ([effect("spring_cubic_k1", k=2e6)], 2e-3),  # of a third of the force: the damper sees a sine
        ([effect("block_quadratic_damping", c=5.0)], 4e-3),
    ],
)
def test_the_ends_of_a_slip_give_back_its_levels(effects: list[Effect], exact: float) -> None:
    speed, friction = 0.03, CoulombFriction(static=STATIC, kinetic=KINETIC)
    model = Model(rig_of(0.01), friction=friction, effects=tuple(effects))
    top, bottom = ends(model, speed)
    known = {one.name: one.parameters for one in effects}
    mass = MASS * (1 + known.get("rig_mass", {}).get("e", 0.0))
    log_w2 = np.log(STIFFNESS * (1 + known.get("rig_stiffness", {}).get("e", 0.0)) / mass)
    assert carried(model, np.array([top]), speed)[0] == pytest.approx(STATIC, rel=1e-6)
    level = sliding(model, np.array([top]), np.array([bottom]), speed, float(log_w2))[0]
    assert level == pytest.approx(KINETIC, rel=exact)


def test_the_motion_behind_a_curved_and_drifting_reading() -> None:
    rig = ss.BlockOnBelt(mass=1.0, stiffness=100.0, damping=0.5)
    effects = [
        ss.effect("sensor_gain", e=0.1),
        ss.effect("sensor_nonlinearity", q=-2.0),
        ss.effect("sensor_drift", r=0.01),
    ]
    model = ss.Model(rig, friction=ss.CoulombFriction(static=6.0, kinetic=3.0), effects=effects)
    t = np.linspace(0, 3, 301)
    x, v = 0.05 * np.sin(2 * t), 0.1 * np.cos(2 * t)
    motion = 1.1 * x - 2 * x**2 + 0.01 * t, 1.1 * v - 4 * x * v + 0.01, np.zeros(len(t), dtype=np.int8)
    one = SimpleNamespace(run=SimpleNamespace(force_channel=False, t=t))
    np.testing.assert_allclose(state_read(one, model, motion), np.column_stack([x, v]), atol=1e-12)


def test_the_state_behind_a_lag_in_mid_slip() -> None:
    m, tau = np.polynomial.Polynomial([0.03, -0.2, -3.0]), 0.02  # of the time to now
    np.testing.assert_allclose(state_behind(m, 0.0, tau), (0.03 - 0.2 * tau, -0.2 - 6.0 * tau), atol=1e-12)
