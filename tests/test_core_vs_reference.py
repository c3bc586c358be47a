"""Two programs without common code: core and reference must agree wherever the motion is well posed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings

from stickslip.declared.effect import tabulated
from stickslip.declared.rig import Rig
from stickslip.simulated.reference import integrate as reference
from strategies import SIZES, clearance, runs

pytest.importorskip("stickslip._core")
from stickslip.simulated.simulate import simulate

MARGIN = 2e-3
COMMON = settings(
    deadline=None,
    derandomize=True,
    phases=[Phase.explicit, Phase.generate],  # a run takes a fifth of a second: shrinking would take minutes
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large],
)


def agree(model, v_b, start, t_end=12.0):
    told = reference.simulate(
        model, belt_speed=v_b, initial=start, t_end=t_end, tol=1e-12, max_transitions=400
    )
    assume(told.status.ok)
    assume(clearance(told) > MARGIN)
    times = np.linspace(0.0, t_end, 7)
    ours = simulate(model, belt_speed=v_b, initial=start, t_end=t_end, t_eval=times, rtol=1e-12, atol=1e-12)
    assert ours.status.ok, ours.status.value
    assert ours.transitions.before.tolist() == told.transitions.before.tolist()
    assert ours.transitions.after.tolist() == told.transitions.after.tolist()
    assert ours.transitions.t == pytest.approx(told.transitions.t, abs=1e-8)
    assert ours.transitions.state == pytest.approx(told.transitions.state, abs=1e-8)
    inside = np.array([np.abs(told.transitions.t - t).min(initial=1.0) > 1e-6 for t in times])
    states = told.at(times)
    assert ours.state == pytest.approx(states[:, : ours.state.shape[1]], abs=1e-8)
    assert ours.mode[inside].tolist() == told.mode_at(times)[inside].tolist()
    for k, name in enumerate(told.system.names[told.system.d :]):
        assert ours.hidden[name] == pytest.approx(states[:, told.system.d + k], abs=1e-8)


@settings(COMMON, max_examples=18)
@given(runs(names=()))
def test_rigs_and_laws_agree(run):
    agree(*run)


@settings(COMMON, max_examples=16)
@given(runs(most=2))
def test_pairs_of_effects_agree(run):
    agree(*run)


@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", SIZES)
def test_every_effect_agrees(name):
    @settings(COMMON, max_examples=3)
    @given(runs(names=(name,), most=1))
    def each(run):
        assume(run[0].effects)
        agree(*run, t_end=6.0 if name == "contact_compliance" else 12.0)  # which is stiff

    each()


KNOTS, OTHERS = (-0.4, -0.1, 0.0, 0.15, 0.4), (-0.6, 0.05, 0.3)
TWO = {
    "a force and a factor": (
        tabulated("contact", "v_w", KNOTS, (0.1, -0.1, 0.15, 0.0, 0.1)),
        tabulated("block", "x1", OTHERS, (0.1, -0.15, 0.2)),
    ),
    "two factors": (
        tabulated("contact", "x1", KNOTS, (0.1, -0.1, 0.15, 0.0, 0.1)),
        tabulated("contact", "y1", OTHERS, (0.1, -0.05, 0.1)),
    ),
    "one in time that repeats": (
        tabulated("block", "x2", KNOTS, (0.2, 0.1, 0.0, -0.1, -0.3)),
        tabulated("angle_body", "t", (0, 1, 2, 3), (0, 0.2, -0.1, 0), period=3, phi=2.5),
    ),
}


@pytest.mark.parametrize("two", TWO.values(), ids=TWO)
def test_two_tables_agree(two):
    @settings(COMMON, max_examples=2)
    @given(runs(names=()))
    def each(run):
        model, v_b, start = run
        assume(isinstance(model.rig, Rig))
        for turn in (1, -1):
            agree(replace(model, effects=two[::turn]), v_b, start)

    each()
