"""Lyapunov exponents, against closed forms, Floquet multipliers and disturbed runs of the reference."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from stickslip.simulated.orbits.limit_cycle import limit_cycle
from stickslip.simulated.orbits.lyapunov import lyapunov
from stickslip.simulated.reference import integrate as reference

RIG = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
W = 1.975


def chaotic():
    """Popp and Stelter's forced block (m = k = v_b = 1), forced where its motion is chaotic."""
    law = ss.HyperbolicFriction(scale=3, decay=1.42, constant=1, quadratic=0.1)
    forcing = ss.effect("harmonic_forcing", a=1.25, w=W, phi=np.pi / 2)
    return ss.Model(ss.BlockOnBelt(), friction=law, effects=[forcing])


def feeny_and_moon():
    """The forced block of Feeny and Moon (1994): x'' + x + n(x) sgn x' = 1.9 cos 1.25 t, n = max(0, 1 + 1.5 x)."""
    load = ss.tabulated("contact", "x1", [-1 / 1.5, 10], [-1, 15])
    forcing = ss.effect("harmonic_forcing", a=1.9, w=1.25, phi=np.pi / 2)
    law = ss.CoulombFriction(static=1, kinetic=1)
    return ss.Model(ss.BlockOnBelt(), friction=law, effects=[load, forcing])


CHAOTIC = [
    pytest.param(chaotic(), 1.0, W, id="Popp and Stelter"),
    pytest.param(feeny_and_moon(), 0.0, 1.25, id="Feeny and Moon"),
]


def test_damped_sliding_in_closed_form():
    model = ss.Model(ss.BlockOnBelt(damping=0.2), friction=ss.CoulombFriction())
    found = lyapunov(model, belt_speed=10.0, initial=(0.6, 0.1), t_end=500)
    assert found.exponents == pytest.approx([-0.1, -0.1], abs=2e-3)
    assert found.exponents.sum() == pytest.approx(-0.2, abs=1e-10)
    assert not found.chaotic


def test_on_a_cycle_the_exponents_are_those_of_its_multipliers():
    cycle = limit_cycle(RIG, 0.1)
    found = lyapunov(
        RIG, belt_speed=0.1, initial=cycle.state, t_end=200 * cycle.period, interval=cycle.period
    )
    rate = np.log(np.abs(cycle.multipliers[0])) / cycle.period
    assert found.exponents[:3] == pytest.approx([0.0, rate, rate], abs=1e-3)
    assert found.exponents[1:3].sum() == pytest.approx(2 * rate, abs=1e-4)
    assert found.exponents[3] == -np.inf  # stick forgets the block's speed at once
    assert found.dimension == pytest.approx(1.0)


def disturbed(model, belt_speed, z, direction, period, size=1e-6):
    """The reference's change of state after a period, per unit of disturbance along `direction`."""
    up, down = (
        reference.simulate(
            model, belt_speed=belt_speed, initial=z + s * size * direction, t_end=period, tol=1e-12
        )
        for s in (1, -1)
    )
    return (up.state[-1] - down.state[-1]) / (2 * size)


@pytest.mark.study
@pytest.mark.parametrize(("model", "belt_speed", "w"), CHAOTIC)
def test_chaos_of_published_oscillators_against_disturbed_runs_of_the_reference(model, belt_speed, w):
    period, periods = 2 * np.pi / w, 8
    wait = 300 * period
    ours = lyapunov(model, belt_speed=belt_speed, t_end=wait + 60.5 * period, transient=wait)
    # each period anew from the core's state: two programs left alone drift apart, by e^17 in these 28 periods
    exactly = {"belt_speed": belt_speed, "rtol": 1e-11, "atol": 1e-11}
    z = ss.simulate(model, t_end=wait, t_eval=[wait], **exactly).state[0]
    direction, growth = np.array([1.0, 0.0]), []
    for k in range(20 + periods):
        moved = disturbed(model, belt_speed, z, direction, period)
        growth.append(np.log(np.linalg.norm(moved)))
        direction = moved / np.linalg.norm(moved)
        end = wait + (k + 1) * period
        z = ss.simulate(
            model, initial=z, t_start=wait + k * period, t_end=end, t_eval=[end], **exactly
        ).state[0]
    theirs = np.cumsum(growth[20:]) / (period * np.arange(1, periods + 1))
    assert ours.history[:periods, 0] == pytest.approx(theirs, abs=1e-4)
    assert ours.exponents[1] == -np.inf


@pytest.mark.parametrize(
    ("model", "belt_speed", "w", "exponent"),
    [
        pytest.param(*CHAOTIC[0].values, 0.0471, marks=pytest.mark.study),
        (*CHAOTIC[1].values, 0.1146),
    ],
)
def test_chaos_is_told_from_order(model, belt_speed, w, exponent):
    period = 2 * np.pi / w
    found = lyapunov(model, belt_speed=belt_speed, t_end=1200 * period, transient=200 * period)
    assert found.chaotic
    assert found.exponents[0] == pytest.approx(exponent, abs=0.0115)  # four standard errors
    assert found.history[-1, 0] == pytest.approx(found.exponents[0])
    assert abs(found.history[len(found.t) // 2, 0] - found.exponents[0]) < 6 * found.standard_error[0]


def test_a_cycle_is_not_chaotic():
    assert not lyapunov(RIG, belt_speed=0.1, t_end=1500, transient=500).chaotic


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"t_end": 10.0}, "t_end = 10.0: too short for an average; give at least"),
        ({"t_end": 1e4, "interval": 0.0}, "interval = 0.0: must be above 0"),
        ({"t_end": 1e4, "initial": (0.0, 1.0)}, "initial: must be 4 finite numbers"),
        ({"t_end": 1e4, "transient": float("inf")}, "transient = inf: infinite"),
    ],
)
def test_bad_input_is_answered_in_one_line(keywords, message):
    with pytest.raises(ss.InputError, match=message):
        lyapunov(RIG, belt_speed=0.1, **keywords)


@pytest.mark.study
def test_a_direction_that_only_shrinks_fast_has_its_own_exponent():
    """100 natural times faster than the block: exp(-629) over an interval, and no stick."""
    model = ss.Model(
        ss.BlockOnBelt(damping=0.3),
        friction=ss.HyperbolicFriction(scale=1, decay=3),
        effects=[ss.effect("friction_memory", tau=0.01)],
    )
    still = ss.steady_sliding(model, 2.0)
    found = lyapunov(model, belt_speed=2.0, initial=still.state[:2] + 0.01, t_end=700, transient=100)
    np.testing.assert_allclose(found.exponents, np.sort(still.eigenvalues.real)[::-1], atol=1e-3)


def test_a_direction_that_stick_wipes_out_is_gone_whatever_the_interval():
    model = ss.Model(
        ss.BlockOnBelt(damping=0.05),
        friction=ss.HyperbolicFriction(scale=1, decay=3),
        effects=[ss.effect("belt_speed_ripple", a=0.1, w=4.0, phi=0.2)],
    )
    cycle = limit_cycle(model, 0.0671)
    for interval in (None, cycle.period):
        found = lyapunov(model, belt_speed=0.0671, t_end=2000, transient=500, interval=interval)
        assert found.exponents[0] == pytest.approx(-0.062, abs=2e-3)
        assert found.exponents[1] == -np.inf
