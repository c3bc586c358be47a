"""Limit cycles and their Floquet multipliers, against return maps by differences and numbers known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import stickslip as ss
from stickslip.simulated.orbits.cycle_sensitivity import cycle_sensitivity
from stickslip.simulated.orbits.limit_cycle import limit_cycle
from stickslip.simulated.orbits.steady_sliding import NoLimitCycleError, steady_sliding
from stickslip.simulated.reference import integrate as reference

RIG = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
LEINE = ss.Model(ss.BlockOnBelt(), friction=ss.HyperbolicFriction(scale=1, decay=3))
DAMPED = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))


def popp_stelter(a=3.6, w=1.067):
    law = ss.HyperbolicFriction(scale=3, decay=1.42, constant=1, quadratic=0.1)
    forcing = ss.effect("harmonic_forcing", a=a, w=w, phi=np.pi / 2)
    return ss.Model(ss.BlockOnBelt(), friction=law, effects=[forcing])


def test_period_of_leines_oscillator():
    cycle = limit_cycle(LEINE, 0.2)
    assert cycle.period == pytest.approx(12.00103129483057865, abs=1e-10)
    assert cycle.state == pytest.approx([1.13394467644165684, 0.0], abs=1e-11)
    releases = cycle.transitions.state[cycle.transitions.before == 0]
    assert releases == pytest.approx(np.array([[1.0, 0.2]]), abs=1e-12)
    assert cycle.multipliers.tolist() == [0]  # stick forgets everything: the cycle is reached in finite time
    assert cycle.stable
    assert cycle.sticks


@pytest.mark.parametrize("length", [1e-9, 1e-4, 1e6])
def test_a_rig_of_any_size_has_the_cycle_of_its_scaled_twin(length):
    """Nanometres were below every tolerance: "the motion settles to steady sliding"."""
    law = ss.HyperbolicFriction(scale=length, decay=3 / length)
    cycle = limit_cycle(ss.Model(ss.BlockOnBelt(), friction=law), 0.2 * length)
    assert cycle.period == pytest.approx(12.00103129483057865, abs=1e-9)
    assert cycle.state[0] == pytest.approx(1.13394467644165684 * length, rel=1e-10)
    assert cycle.sticks
    sliding = steady_sliding(ss.Model(ss.BlockOnBelt(), friction=law), 0.5 * length)
    assert sliding.state[0] == pytest.approx(length / 2.5, rel=1e-9)


def test_a_tiny_two_degree_rig_has_the_cycle_of_its_scaled_twin():
    large, length, law = limit_cycle(RIG, 0.1), 1e-9, RIG.friction
    numbers = {f.name: getattr(law, f.name) for f in dataclasses.fields(law)}
    small = ss.PaperFriction(**{name: length * value for name, value in numbers.items() if value is not None})
    cycle = limit_cycle(ss.Model(RIG.rig, friction=small), 0.1 * length)
    assert cycle.period == pytest.approx(large.period, rel=1e-9)
    assert cycle.state / length == pytest.approx(large.state, abs=1e-8)
    assert cycle.multipliers[:2] == pytest.approx(large.multipliers[:2], abs=1e-6)


def released(y):
    """The next release's (y1, y2) after a release with (y1, y2) = y: the return map on another section."""
    rig, law, v_b = RIG.rig, RIG.friction, 0.1
    x1 = (law.T_s_minus - rig.eta1 * (v_b + y[1]) - y[0]) / rig.alpha1
    run = ss.simulate(
        RIG, belt_speed=v_b, initial=(x1, v_b, *y), t_end=15.0, contact="slip-", rtol=1e-13, atol=1e-13
    )
    return run.transitions.state[run.transitions.before == 0][0, 2:]


def test_multipliers_of_the_reference_rig_against_a_return_map_by_differences():
    cycle = limit_cycle(RIG, 0.1)
    assert cycle.residual < 1e-11
    fixed = cycle.transitions.state[cycle.transitions.before == 0][0, 2:]
    assert released(fixed) == pytest.approx(fixed, abs=1e-11)
    h, columns = 1e-4, []
    for e in np.eye(2):
        near, far = (released(fixed + k * h * e) - released(fixed - k * h * e) for k in (1, 2))
        columns.append((8 * near - far) / (12 * h))
    expected = np.linalg.eigvals(np.array(columns).T)
    assert np.sort_complex(cycle.multipliers[:2]) == pytest.approx(np.sort_complex(expected), abs=1e-8)
    assert cycle.multipliers[2] == 0
    assert cycle.stable


def test_the_reference_closes_the_cycle():
    cycle = limit_cycle(RIG, 0.1)
    told = reference.simulate(RIG, belt_speed=0.1, initial=cycle.state, t_end=cycle.period, tol=1e-13)
    assert told.state[-1] == pytest.approx(cycle.state, abs=1e-9)
    assert told.transitions.t == pytest.approx(cycle.transitions.t, abs=1e-9)


def test_forced_oscillator_is_looked_at_inside_a_stick():
    cycle = limit_cycle(popp_stelter(), 1.0)
    assert cycle.contact == "stick"
    assert cycle.state[0] == pytest.approx(-0.2806365463, abs=1e-10)
    assert cycle.period == pytest.approx(2 * np.pi / 1.067, rel=1e-14)

    def strobe(x):
        run = ss.simulate(
            popp_stelter(), belt_speed=1.0, initial=(x, 1.0), t_end=cycle.period, t_eval=[cycle.period],
            rtol=1e-13, atol=1e-13, contact="stick",
        )  # fmt: skip
        return run.state[0, 0]

    h = 1e-5
    slope = (strobe(cycle.state[0] + h) - strobe(cycle.state[0] - h)) / (2 * h)
    assert cycle.multipliers.real == pytest.approx([slope, 0.0], abs=1e-7)


def test_a_cycle_of_two_forcing_periods_is_counted_as_such():
    model = popp_stelter(0.5, 1.7)
    cycle = limit_cycle(model, 1.0)
    run = cycle.trajectory(cycle.turns + 1)
    assert cycle.turns > 1
    assert run.state[-1] == pytest.approx(run.state[0], abs=1e-10)
    assert all(abs(run.state[k, 0] - run.state[0, 0]) > 1e-4 for k in range(1, cycle.turns))
    assert cycle.stable


def test_an_unstable_cycle_without_stick_separates_sliding_from_stick_slip():
    # damped block: sliding is stable and so is stick-slip; between them lies a cycle no simulation settles to
    v_b = 2.2
    cycle = limit_cycle(DAMPED, v_b, guess=(2.2, 0.0), period=2 * np.pi)
    assert len(cycle.transitions) == 0
    assert not cycle.stable
    assert cycle.multipliers[0].real > 1
    sliding = steady_sliding(DAMPED, v_b)
    assert sliding.stable
    for factor, sticks in ((0.99, False), (1.01, True)):
        start = sliding.state + factor * (cycle.state - sliding.state)
        run = ss.simulate(DAMPED, belt_speed=v_b, initial=start, t_end=2000)
        assert bool(len(run.transitions)) == sticks


def test_steady_sliding_is_told_with_its_eigenvalues():
    with pytest.raises(
        NoLimitCycleError, match=r"settles to steady sliding at x1 = 0\.1, which is stable"
    ) as caught:
        limit_cycle(DAMPED, 3.0)
    rest = caught.value.equilibrium
    assert rest is not None
    # l^2 + (c - 3/(1+3v)^2) l + 1 = 0
    expected = np.roots([1, 0.1 - 3 / (1 + 9) ** 2, 1])
    assert np.sort_complex(rest.eigenvalues) == pytest.approx(np.sort_complex(expected), abs=1e-9)


def test_hidden_states_take_part():
    model = RIG.with_effects([ss.effect("friction_memory", tau=0.1)])
    cycle = limit_cycle(model, 0.1)
    assert cycle.states == ("x1", "x2", "y1", "y2", "w")
    assert cycle.residual < 1e-11
    assert cycle.multipliers[-2:].tolist() == [0, 0]  # stick forgets the speed and the memory
    assert np.all(np.abs(cycle.multipliers[:2]) > 0.1)


def test_a_cycle_nearby_is_guess_enough():
    near = limit_cycle(RIG, 0.1)
    cycle = limit_cycle(RIG, 0.105, near)
    assert cycle.period == pytest.approx(limit_cycle(RIG, 0.105).period, abs=1e-10)


@pytest.mark.parametrize(
    ("model", "speed", "keywords", "message"),
    [
        (LEINE, 0.0, {}, "it comes to rest"),
        (LEINE, float("nan"), {}, "belt_speed = nan"),
        (LEINE, 0.2, {"guess": (1.0, float("nan"))}, "guess: must be 2 finite numbers"),
        (LEINE, 0.2, {"settle": -1.0}, "settle = -1.0: must be above 0"),
        (LEINE.with_effects([ss.effect("friction_drift", r=0.01)]), 0.2, {}, "drifts with time"),
        (
            popp_stelter().with_effects(
                [*popp_stelter().effects, ss.effect("belt_speed_ripple", a=0.1, w=2**0.5, phi=0)]
            ),
            1.0,
            {},
            "quasi-periodic",
        ),
    ],
)
def test_bad_input_is_answered_in_one_line(model, speed, keywords, message):
    with pytest.raises(ss.StickslipError, match=message) as caught:
        limit_cycle(model, speed, **keywords)
    assert "\n" not in str(caught.value)


def test_sensitivity_of_the_period_in_closed_form():
    # Coulomb on a belt: period 2 (pi - atan(A/v)) + 2 A/v, A = static - kinetic
    v, a = 0.25, 0.6
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1.0, kinetic=0.4))
    moved = cycle_sensitivity(limit_cycle(model, v), ("belt_speed", "static", "kinetic"))
    assert repr(moved).startswith(
        f"<CycleSensitivity: 3 parameters, 2 states; d period by belt_speed {moved.period[0]:.6g}, static "
    )
    assert str(moved.period[1])[:4] in moved._repr_html_()
    by_a, by_v = -2 * v / (v**2 + a**2) + 2 / v, 2 * a / (v**2 + a**2) - 2 * a / v**2
    assert moved.period == pytest.approx([by_v, by_a, -by_a], rel=1e-9)
    # x1 is greatest at kinetic + sqrt(A^2 + v^2)
    r = np.hypot(a, v)
    assert moved.state[0] == pytest.approx([v / r, a / r, 1 - a / r], abs=1e-9)


def test_sensitivity_of_the_reference_rig_against_differences_of_cycles():
    cycle = limit_cycle(RIG, 0.1)
    names = ("alpha1", "eta12", "T_s_minus", "t2")
    moved = cycle_sensitivity(cycle, names)
    for k, name in enumerate(names):
        h = 1e-4 * RIG.parameters[name]
        up, down = (
            limit_cycle(RIG.replace({name: RIG.parameters[name] + s * h}), 0.1, cycle) for s in (1, -1)
        )
        assert moved.period[k] == pytest.approx((up.period - down.period) / (2 * h), rel=1e-5)
        assert moved.state[:, k] == pytest.approx((up.state - down.state) / (2 * h), rel=1e-4, abs=1e-6)


def test_sensitivity_of_a_forced_cycle_to_the_frequency():
    cycle = limit_cycle(popp_stelter(), 1.0)
    moved = cycle_sensitivity(cycle, ("effect.w", "belt_speed"))
    assert moved.period == pytest.approx([-2 * np.pi / 1.067**2, 0.0], rel=1e-9)
    h = 1e-5
    up, down = (limit_cycle(popp_stelter(w=1.067 + s * h), 1.0, cycle) for s in (1, -1))
    assert moved.state[:, 0] == pytest.approx((up.state - down.state) / (2 * h), abs=1e-5)
    assert moved.state[1, 1] == pytest.approx(1.0)  # looked at inside a stick: it moves with the belt


@pytest.mark.parametrize("speed", [0.1, -0.1])
def test_an_effect_that_switches_on_the_section_does_no_harm(speed):
    # quadratic damping has its kink at x2 = 0, where the cycle is cut
    cycle = limit_cycle(RIG.with_effects([ss.effect("block_quadratic_damping", c=2.0)]), speed)
    run = cycle.trajectory(3)
    assert len(run.t) == 3
    assert run.state[-1] == pytest.approx(run.state[0], abs=1e-10)
    assert cycle.stable
