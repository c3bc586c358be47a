"""The cases in which event location goes wrong elsewhere, each with what must come out."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("stickslip._core")
from stickslip.declared.effect import effect, tabulated
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.simulated.reference import integrate as reference
from stickslip.simulated.simulate import simulate

TIGHT = {"rtol": 1e-13, "atol": 1e-13}
COULOMB = CoulombFriction(static=1.0, kinetic=0.5)
RIG = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
locators = pytest.mark.parametrize("locator", ["henon", "bracket"])


def block(*effects, law=COULOMB):
    return Model(BlockOnBelt(), friction=law, effects=effects)


def ghost(variable, *knots):
    """A term that is zero everywhere but switches at its knots."""
    outer = (-1000.0, *knots, 1000.0)
    return tabulated("block", variable, outer, (0.0,) * len(outer))


# In slip below a faster belt the unit block swings about x = F_k = 0.5: from (0.5, -a), x2 = -a cos t.


@locators
@pytest.mark.parametrize("v_b", [1e-3, 0.02, 0.2, 1.0, 50.0])
@pytest.mark.parametrize("start", [0.0, -0.9, 0.999])
def test_linear_box(v_b, start, locator):
    # in stick the force grows linearly up to the wall
    t = (1 - start) / v_b
    run = simulate(block(), belt_speed=v_b, initial=(start, v_b), t_end=1.01 * t, locator=locator, **TIGHT)
    assert run.transitions.t[:1] == pytest.approx([t], rel=1e-13)
    assert run.transitions.state[0] == pytest.approx([1.0, v_b], rel=1e-13)


def test_identical_events():
    # a second switching function vanishes at the very instant of the release
    alone = simulate(block(), belt_speed=0.2, initial=(0, 0.2), t_end=30, **TIGHT)
    double = simulate(block(ghost("x1", 1.0)), belt_speed=0.2, initial=(0, 0.2), t_end=30, **TIGHT)
    assert double.status.ok
    assert double.transitions.t == pytest.approx(alone.transitions.t, abs=1e-11)
    assert double.transitions.after.tolist() == alone.transitions.after.tolist()
    assert double.state[-1] == pytest.approx(alone.state[-1], abs=1e-11)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-12])
def test_close_events(gap):
    # two kinks and the release within v_b * gap of time: each comes, in order
    model = block(ghost("x1", 1.0 - 2 * gap, 1.0 - gap))
    run = simulate(model, belt_speed=0.2, initial=(0, 0.2), t_end=8, **TIGHT)
    assert run.transitions.t[:1] == pytest.approx([5.0], abs=1e-11)
    assert run.transitions.after.tolist() == [-1]
    early = np.sort(run.kinks)[:2]
    assert early == pytest.approx([(1 - 2 * gap) / 0.2, (1 - gap) / 0.2], abs=1e-11)


@locators
def test_no_retrigger_where_slip_begins_with_a_drop(locator):
    run = simulate(block(), belt_speed=0.2, initial=(0, 0.2), t_end=200, locator=locator, **TIGHT)
    assert np.diff(run.transitions.t).min() > 3
    assert (run.transitions.before[1:] == run.transitions.after[:-1]).all()


@locators
@pytest.mark.parametrize("v_b", [0.2, -0.2])
def test_no_retrigger_where_slip_begins_without_acceleration(v_b, locator):
    law = HyperbolicFriction(scale=1, decay=3)
    run = simulate(block(law=law), belt_speed=v_b, initial=(0, v_b), t_end=200, locator=locator, **TIGHT)
    assert np.diff(run.transitions.t).min() > 3
    assert len(run.transitions) == 33


@pytest.mark.sampled(6)
@locators
@pytest.mark.parametrize("phi", np.linspace(0, 6, 13))
def test_no_retrigger_on_the_continuous_branch_under_forcing(phi, locator):
    # T_plus begins at its static limit: slip sets out with zero acceleration, whatever rounding says
    model = Model(RIG, friction=PaperFriction(), effects=[effect("harmonic_forcing", a=0.6, w=1.7, phi=phi)])
    run = simulate(
        model, belt_speed=-0.1, initial=(0.1, 0.05, 0.02, -0.01), t_end=60, locator=locator, **TIGHT
    )
    assert np.diff(run.transitions.t).min() > 1e-3
    told = reference.simulate(model, belt_speed=-0.1, initial=(0.1, 0.05, 0.02, -0.01), t_end=60, tol=1e-13)
    assert run.transitions.after.tolist() == told.transitions.after.tolist()


@locators
def test_direction_of_the_crossing(locator):
    # v_w = 0 is reached from both sides; at the last turning point the belt holds
    law = CoulombFriction(static=0.5, kinetic=0.5)
    run = simulate(block(law=law), belt_speed=0.0, initial=(5.25, 0), t_end=20, locator=locator, **TIGHT)
    assert run.transitions.before.tolist() == [-1, 1, -1, 1, -1]
    assert run.transitions.after.tolist() == [1, -1, 1, -1, 0]
    assert run.transitions.t == pytest.approx(np.pi * np.arange(1, 6), abs=1e-12)
    assert run.transitions.state[:, 0] == pytest.approx([-4.25, 3.25, -2.25, 1.25, -0.25], abs=1e-12)
    assert (run.transitions.state[:, 1] == 0).all()


@locators
@pytest.mark.parametrize("dt", [1e-2, 1e-5, 1e-8, 1e-11])
def test_event_in_the_first_step(dt, locator):
    run = simulate(block(), belt_speed=0.2, initial=(1 - 0.2 * dt, 0.2), t_end=1, locator=locator, **TIGHT)
    assert run.transitions.after.tolist() == [-1]
    assert run.transitions.t == pytest.approx([dt], abs=1e-14)


@pytest.mark.parametrize("speed", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("side", [-1, 1])
def test_capture_in_the_first_step(speed, side):
    # deceleration 0.5 + 0.2 side: the slip of a block all but at rest on the belt ends at once
    run = simulate(block(), belt_speed=0.0, initial=(0.2, side * speed), t_end=1, **TIGHT)
    deceleration = 0.5 + side * 0.2
    assert run.transitions.before.tolist() == [side]
    assert run.transitions.after.tolist() == [0]
    assert run.transitions.t == pytest.approx([speed / deceleration], rel=2 * speed, abs=1e-14)


@pytest.mark.parametrize("offset", [0.0, 1e-9, -1e-9, 1e-13, -1e-13])
def test_event_at_the_end_of_the_run(offset):
    end = 5.0 + offset
    run = simulate(block(), belt_speed=0.2, initial=(0, 0.2), t_end=end, **TIGHT)
    assert run.status.ok
    assert run.t[-1] == end
    assert run.state[-1] == pytest.approx([0.2 * end, 0.2], abs=1e-9)
    if abs(offset) > 1e-12:
        assert len(run.transitions) == (offset > 0)
    onward = simulate(block(), belt_speed=0.2, initial=run.state[-1], t_end=1, **TIGHT)
    assert onward.mode[-1] == -1
    whole = simulate(block(), belt_speed=0.2, initial=(0, 0.2), t_end=end + 1, **TIGHT)
    assert onward.state[-1] == pytest.approx(whole.state[-1], abs=1e-9)


def test_event_at_the_end_of_a_step():
    # the release falls on an output time, and on the end of a step of fixed length
    sampled = simulate(block(), belt_speed=0.2, initial=(0, 0.2), t_end=9, t_eval=[4, 5, 6], **TIGHT)
    stepped = simulate(block(), belt_speed=0.2, initial=(0, 0.2), t_end=9, step=0.5, **TIGHT)
    assert sampled.transitions.t == pytest.approx(stepped.transitions.t, abs=1e-12)
    assert sampled.transitions.after.tolist() == stepped.transitions.after.tolist()
    assert sampled.state[1] == pytest.approx([1.0, 0.2], abs=1e-12)
    assert stepped.state[-1] == pytest.approx(
        simulate(block(), belt_speed=0.2, initial=(0, 0.2), t_end=9, **TIGHT).state[-1], abs=1e-11
    )


@locators
@pytest.mark.parametrize("excess", [1e-2, 1e-4, 1e-6, 1e-8])
def test_grazing_from_above_is_caught(excess, locator):
    # the block's greatest speed exceeds the belt's by a little: it is captured on the way up
    v_b = 0.2
    a = v_b + excess
    run = simulate(block(), belt_speed=v_b, initial=(0.5, -a), t_end=4, locator=locator, **TIGHT)
    # x2 = -a cos t reaches v_b at t = pi - acos(v_b / a); 1 - v_b/a without cancellation
    before = math.acos(1 - excess / a)
    rise = math.sqrt(a * a - v_b * v_b)
    assert run.transitions.after.tolist() == [0]
    assert run.transitions.t == pytest.approx([math.pi - before], abs=1e-14 / rise + 1e-11)


@pytest.mark.parametrize("short", [1e-2, 1e-4, 1e-6, 1e-8])
def test_grazing_from_below_is_not_caught(short):
    a = 0.2 - short
    run = simulate(block(), belt_speed=0.2, initial=(0.5, -a), t_end=100, **TIGHT)
    assert len(run.transitions) == 0
    assert run.state[-1] == pytest.approx([0.5 - a * math.sin(100), -a * math.cos(100)], abs=1e-11)


@pytest.mark.parametrize("excess", [1e-2, 1e-4, 1e-6, 1e-9])
def test_two_in_one_step(excess):
    # over the knot and back again within a time 2 acos(1 - excess), far shorter than a step
    run = simulate(block(ghost("x2", 0.1)), belt_speed=5.0, initial=(0.5, -0.1 - excess), t_end=10, **TIGHT)
    a = 0.1 + excess
    half = math.acos(1 - excess / a)
    told = [math.pi - half, math.pi + half, 3 * math.pi - half, 3 * math.pi + half]
    assert len(run.transitions) == 0
    assert run.kinks == pytest.approx(told, abs=1e-7 if excess < 1e-8 else 1e-10)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("member", ["1->+1->0 short", "near graze"])
def test_short_excursions_of_the_rig(member):
    v_b, alpha1 = {"1->+1->0 short": (23, 17), "near graze": (52, 54)}[member]
    speed, inertia = float(np.linspace(0.02, 0.3, 64)[v_b]), float(np.linspace(8, 40, 64)[alpha1])
    rig = Rig(alpha1=inertia, alpha2=inertia / 2, beta3=4, eta1=0.1, eta12=0.2)
    model = Model(rig, friction=PaperFriction())
    start = (0.1, 0.1, 0.0, 0.0)
    told = reference.simulate(model, belt_speed=speed, initial=start, t_end=200)
    for tolerance in (1e-6, 1e-8, 1e-12):
        run = simulate(model, belt_speed=speed, initial=start, t_end=200, rtol=tolerance, atol=tolerance)
        assert run.transitions.after.tolist() == told.transitions.after.tolist()


def test_tangency_with_a_knot():
    # the summit touches the knot to rounding: two kinks or none, the motion is the same
    run = simulate(block(ghost("x2", 0.1)), belt_speed=5.0, initial=(0.5, -0.1), t_end=100, **TIGHT)
    assert run.status.ok
    assert len(run.transitions) == 0
    assert run.state[-1] == pytest.approx([0.5 - 0.1 * math.sin(100), -0.1 * math.cos(100)], abs=1e-12)


@locators
def test_tangency_with_the_belt(locator):
    # the block touches the belt's speed to rounding: carried on or swinging on, nothing else
    run = simulate(block(), belt_speed=0.2, initial=(0.5, -0.2), t_end=5, locator=locator, **TIGHT)
    assert run.status.ok
    assert len(run.transitions) in (0, 1)
    carried = run.transitions.after.tolist() == [0]
    free = [0.5 - 0.2 * math.sin(5), -0.2 * math.cos(5)]
    told = [0.5 + 0.2 * (5 - math.pi), 0.2] if carried else free
    assert run.state[-1] == pytest.approx(told, abs=1e-6)


@pytest.mark.parametrize("v_b", [0.0, 0.1, -0.1])
@pytest.mark.parametrize("x1", [-2.0, -1.00001, -0.99999, 0.0, 0.99999, 1.00001, 2.0])
def test_start_on_the_surface(x1, v_b):
    run = simulate(block(), belt_speed=v_b, initial=(x1, v_b), t_end=1e-6, **TIGHT)
    assert run.mode[0] == (0 if abs(x1) < 1 else -int(np.sign(x1)))
    assert len(run.transitions) == 0


def test_locators_agree():
    model = Model(RIG, friction=PaperFriction())
    runs = [
        simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=300, locator=name, **TIGHT)
        for name in ("henon", "bracket")
    ]
    assert runs[0].transitions.after.tolist() == runs[1].transitions.after.tolist()
    assert runs[0].transitions.t == pytest.approx(runs[1].transitions.t, abs=1e-10)
    assert runs[0].state[-1] == pytest.approx(runs[1].state[-1], abs=1e-11)
