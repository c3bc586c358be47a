"""Derivatives whose series are long where the motion's own is short: the step heeds them too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import stickslip as ss

FALLING = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
LEVEL = ss.CoulombFriction(static=1, kinetic=0.6)
PAPER = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())


def ends(model, belt_speed, start, *names, t_end=20.0, **settings):
    return ss.simulate(
        model, belt_speed=belt_speed, initial=start, t_end=t_end, t_eval=[t_end], sensitivity=names, **settings
    )  # fmt: skip


@pytest.mark.parametrize("w", [1.0, 5.0, 20.0])
@pytest.mark.parametrize("start", [(0.1, 0.0), (0.6, 0.0)])  # the second is the equilibrium
def test_what_an_effect_of_no_size_would_do(w, start):
    """A block that only slips is linear in the force: its derivative at 0 is what a force of 1e-2 does, by 1e-2."""
    forced = [
        ss.Model(
            ss.BlockOnBelt(damping=0.1), friction=LEVEL, effects=[ss.effect("harmonic_forcing", a=a, w=w, phi=0.3)]
        )
        for a in (0.0, 1e-2)
    ]  # fmt: skip
    at = ends(forced[0], 2.0, start, "harmonic_forcing.a")
    assert at.transitions.t.size == 0
    with_it = ends(forced[1], 2.0, start, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(at.sensitivity[0, :, 0], (with_it.state[0] - at.state[0]) / 1e-2, atol=2e-9)


@pytest.mark.parametrize("name", ["harmonic_forcing", "belt_speed_ripple"])
def test_what_it_would_do_through_stick_and_slip(name):
    model = PAPER.with_effects([ss.effect(name, a=0.0, w=10.0, phi=0.3)])
    start, h = (0.1, 0.1, 0.0, 0.0), 1e-5
    at = ends(model, 0.1, start, f"{name}.a")
    assert at.transitions.t.size >= 3
    to, fro = (ends(model.replace({f"{name}.a": a}), 0.1, start, rtol=1e-13, atol=1e-14) for a in (h, -h))
    near = (to.state[0] - fro.state[0]) / (2 * h)
    np.testing.assert_allclose(at.sensitivity[0, :, 0], near, atol=1e-5 * np.abs(near).max())


def test_about_an_equilibrium_they_are_the_exponential_of_its_jacobian():
    still = ss.steady_sliding(FALLING, 2.0)
    u = 2.0  # v_w = -2
    slope = -3 / (1 + 3 * u) ** 2  # of the friction with u
    jacobian = np.array([[0.0, 1.0], [-1.0, -0.1 - slope]])
    run = ends(FALLING, 2.0, still.state, "initial.x1", "initial.x2")
    np.testing.assert_allclose(run.sensitivity[0], expm(20.0 * jacobian), atol=1e-8)


@pytest.mark.parametrize("c", [0.0, 0.5])
def test_an_equilibrium_on_a_kink_is_as_smooth_as_any(c):
    """Drag c x2 |x2| changes its branch at x2 = 0, where the block rests; its slope there is 0."""
    model = FALLING.with_effects([ss.effect("block_quadratic_damping", c=c)])
    still = ss.steady_sliding(model, 2.0)
    jacobian = np.array([[0.0, 1.0], [-1.0, -0.1 + 3 / 49]])
    run = ends(model, 2.0, still.state, "initial.x1", "initial.x2")
    np.testing.assert_allclose(run.sensitivity[0], expm(20.0 * jacobian), atol=1e-6)


@pytest.mark.parametrize("tau", [0.2, 0.02])
def test_a_fast_hidden_state_contracts_as_its_equation_says(tau):
    """Exponents sum to the divergence, which is constant here; the determinant of the monodromy likewise."""
    model = FALLING.with_effects(
        [ss.effect("friction_memory", tau=tau), ss.effect("harmonic_forcing", a=0.5, w=1.3, phi=0.0)]
    )
    divergence = -0.1 - 1 / tau
    spectrum = ss.lyapunov(model, belt_speed=3.0, t_end=200.0, transient=100.0, interval=0.5)
    assert spectrum.exponents.sum() == pytest.approx(divergence, rel=1e-5)
    assert not spectrum.chaotic
    cycle = ss.limit_cycle(model, 3.0)
    assert cycle.stable  # it was found by settling to it
    assert np.sort(np.abs(cycle.multipliers))[0] < 1e-9


def test_a_tiny_size_is_no_different():
    found = [
        ends(
            PAPER.with_effects([ss.effect("harmonic_forcing", a=a, w=5.0, phi=0.3)]), 0.1, (0.1, 0.1, 0, 0),
            "harmonic_forcing.a",
        ).sensitivity[0, :, 0]
        for a in (0.0, 1e-12, 1e-9)
    ]  # fmt: skip
    for one in found[1:]:
        np.testing.assert_allclose(one, found[0], atol=1e-6 * np.abs(found[0]).max())


@pytest.mark.parametrize("v_s", [0.01, 0.002])
@pytest.mark.parametrize("v_b", [0.5, 0.3])
def test_what_is_nothing_beside_the_motion_costs_few_steps(v_s, v_b):
    """Far from a narrow peak its derivatives are 1e-300, and grow like its flank."""
    for base, start in (
        (PAPER, (0.1, 0.1, 0.0, 0.0)),
        (ss.Model(ss.BlockOnBelt(), friction=LEVEL), (1.1, 0.0)),
    ):
        model = base.with_effects([ss.effect("stribeck_peak", dT=0.1, v_s=v_s)])
        names = ("stribeck_peak.dT", "stribeck_peak.v_s")
        plain = ends(model, v_b, start, t_end=60.0)
        with_them = ends(model, v_b, start, *names, t_end=60.0, max_steps=100_000)
        assert with_them.status.ok
        assert with_them.steps < 3 * plain.steps + 50


def test_a_tolerance_may_be_absolute_alone():
    run = ends(PAPER, 0.1, (0.1, 0.1, 0.0, 0.0), "eta1", rtol=0, atol=1e-10)
    assert run.status.ok
    other = ends(PAPER, 0.1, (0.1, 0.1, 0.0, 0.0), "eta1")
    np.testing.assert_allclose(run.sensitivity, other.sensitivity, rtol=1e-6)


def test_a_peak_of_no_height_is_not_stepped_over():
    rig = ss.Rig(alpha1=18, alpha2=6, beta3=3.3, eta1=0.03, eta12=0.4)
    model = ss.Model(
        rig,
        friction=ss.CoulombFriction(static=3.0, kinetic=1.8),
        effects=[ss.effect("stribeck_peak", dT=0.0, v_s=0.01)],
    )
    start, h = (0.1, 0.2, 0.0, 0.0), 1e-6
    at = ends(model, 0.2, start, "stribeck_peak.dT", t_end=9.0)
    to, fro = (
        ends(model.replace({"stribeck_peak.dT": x}), 0.2, start, t_end=9.0, rtol=1e-13, atol=1e-14).state[0]
        for x in (h, 0.0)
    )
    np.testing.assert_allclose(at.sensitivity[0, :, 0], (to - fro) / h, atol=2e-5)
