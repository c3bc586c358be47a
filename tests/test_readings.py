"""What the paper prints, and what it must mean: one demonstration for each reading of docs/model.md."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import signals
from stickslip.declared.effect import effect
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.simulated.reference import integrate as reference
from stickslip.simulated.simulate import simulate

RIG = Rig(alpha1=16.0, alpha2=8.0, beta3=4.0, eta1=0.1, eta12=0.2)
START = (0.1, 0.1, 0.0, 0.0)
TABLE_1 = {"A1": 3.2345, "A2": 2.8736, "t1": 0.0342, "t2": 0.3053}  # of T_-


def minus_branch(numerator):
    """(4.2) as a magnitude, given the numerator of its exponents; unclamped."""
    c = TABLE_1
    return 5.94 - c["A1"] * np.exp(-numerator / c["t1"]) - c["A2"] * np.exp(-numerator / c["t2"])


def linear_rig(rig, s):
    """(2.1) without friction as z' = M z, written out here with the coupling sign s."""
    a1, a2 = rig.alpha1, rig.alpha2
    return np.array(
        [
            [0, 1, 0, 0],
            [-1, -rig.eta1 / a1, -s / a1, -rig.eta1 / a1],
            [0, 0, 0, 1],
            [-1 / a2, -rig.eta1 / a2, -rig.beta3 / a2, -rig.eta12 / a2],
        ]
    )


@pytest.mark.parametrize(("coupling", "s"), [("reciprocal", 1), ("as_printed", -1)])
def test_the_coupling_as_printed_creates_energy(coupling, s):
    """Undamped, without friction, both bodies tuned alike: only one sign conserves E; the other flutters."""
    rig = Rig(alpha1=16.0, alpha2=8.0, beta3=8.0, eta1=0.0, eta12=0.0, coupling=coupling)
    growth = np.linalg.eigvals(linear_rig(rig, s)).real.max()
    frictionless = CoulombFriction(static=0.0, kinetic=0.0)
    run = reference.simulate(
        Model(rig, friction=frictionless), belt_speed=5.0, initial=START, t_end=150.0, tol=1e-10
    )
    x1, x2, y1, y2 = run.state.T[:4]
    energy = (16 * x2**2 + 8 * y2**2 + 16 * x1**2 + 8 * y1**2) / 2 + x1 * y1
    if coupling == "reciprocal":
        assert growth == pytest.approx(0.0, abs=1e-12)
        assert energy == pytest.approx(np.full_like(energy, energy[0]), rel=1e-7)
    else:
        assert growth == pytest.approx(np.sqrt(1 / 512), rel=0.01)  # lambda^2 = -1 +- i/sqrt(128)
        assert energy[-1] > 1e4 * energy[0]


def test_friction_must_oppose_the_motion_in_the_bracket():
    """With +T on the block, T of the sign of v_w, (2.1) takes energy out of a sliding block."""
    law = PaperFriction()
    v_w = np.linspace(-0.5, 0.5, 1001)
    assert np.all(law.force(v_w) * v_w >= 0)  # the dissipated power T v_w
    model = Model(RIG, friction=law)
    run = simulate(model, belt_speed=0.0, initial=(1.0, 0.0, 0.0, 0.0), t_end=30.0)
    x1, x2, y1, y2 = run.state.T
    energy = (16 * x2**2 + 8 * y2**2 + 16 * x1**2 + 4 * y1**2) / 2 + x1 * y1
    assert np.all(np.diff(energy) <= 1e-8)
    assert energy[-1] < 0.5 * energy[0]


def test_printed_signs_of_t_minus_count_twice():
    """T_- of Table 1 is negative already; times sgn v_w = -1 it would push the block along."""
    u = np.linspace(0.0, 0.25, 26)[1:]
    T_minus = -minus_branch(0.28 - u)  # Table 1's signs: T_s = -5.94
    v_w = -u
    as_printed = T_minus * np.sign(v_w)
    assert np.all(as_printed * v_w < 0)
    assert PaperFriction().force(v_w) == pytest.approx(-as_printed)


@pytest.mark.parametrize(("belt_speed", "limit", "after"), [(0.1, 5.94, -1), (-0.1, -3.63, 1)])
def test_at_rest_friction_is_a_set_with_a_limit_for_each_direction(belt_speed, limit, after):
    """A carried block leaves at 5.94 into v_w < 0, or at 3.63 into v_w > 0, as the belt runs."""
    run = simulate(Model(RIG, friction=PaperFriction()), belt_speed=belt_speed, initial=START, t_end=100.0)
    tr = run.transitions
    leaving = (tr.before == 0) & (tr.after != 0)
    assert leaving.sum() >= 2
    x1, _, y1, y2 = tr.state[leaving].T
    q = RIG.alpha1 * x1 + RIG.eta1 * (belt_speed + y2) + y1
    assert np.all(tr.after[leaving] == after)
    assert q == pytest.approx(np.full(leaving.sum(), limit), abs=1e-8)


def test_the_exponent_as_printed_strengthens_with_speed():
    """|v_w| - v_w,min = u + 0.28 gives a law that rises with u: steady sliding is stable, nothing sticks."""
    u = np.linspace(0.0, 0.25, 251)
    assert np.all(np.diff(minus_branch(0.28 + u)) > 0)
    assert np.all(np.diff(minus_branch(0.28 - u)) < 0)
    assert PaperFriction().magnitude(-u[1:]) == pytest.approx(minus_branch(0.28 - u[1:]), abs=1e-12)
    assert minus_branch(0.0) == pytest.approx(5.94 - 3.2345 - 2.8736)  # the constants of a fit at u = 0.28


def test_beyond_the_fitted_range_the_branches_hold_their_minima():
    """Unclamped, T_- would change sign at u = 0.2783 and drive the block; T_+ at 0.354."""
    law = PaperFriction()
    assert minus_branch(0.28 - 0.2783) == pytest.approx(0.0, abs=5e-3)
    assert minus_branch(0.28 - 0.30) < -2
    assert law.magnitude(np.array([-0.27, -0.30, -2.0])) == pytest.approx(np.full(3, 1.42))
    assert law.magnitude(np.array([0.28, 0.40, 2.0])) == pytest.approx(np.full(3, 0.86))
    assert law.kinks == pytest.approx((0.2604, 0.27), abs=5e-5)


def test_the_onset_of_slip_is_a_drop():
    """(4.2) starts at 4.7906, below the static 5.94; T_+ starts at its static limit."""
    law = PaperFriction()
    assert law.magnitude(np.array([-1e-12]))[0] == pytest.approx(4.7906, abs=5e-5)
    assert law.magnitude(np.array([1e-12]))[0] == pytest.approx(3.63, abs=1e-9)
    assert law.static_limits == (5.94, 3.63)


def test_the_filter_looks_back():
    """(3.1) with n-1 differentiates; solved for n+1, as printed, it grows by 1/a a sample."""
    h, a = 0.01, 0.8
    k0 = (1 - a) / h
    ramp = 3.0 * h * np.arange(400)
    assert signals.first_order(np.full(50, 7.0), a, k0, -k0)[1:] == pytest.approx(np.zeros(49))
    assert signals.first_order(ramp, a, k0, -k0)[-1] == pytest.approx(3.0)  # unit slope
    y = [0.0]
    for n in range(1, 399):  # y_n = a y_{n+1} + k0 x_n + k1 x_{n+1}, solved for y_{n+1}
        y.append((y[-1] - k0 * ramp[n] + k0 * ramp[n + 1]) / a)
    assert abs(y[-1]) > 1e30


def test_parameters_are_what_the_list_after_the_equations_defines():
    """alpha1 = beta1 = 1 + k1/k2, beta3 = 1 + k3/k2, eta12 = eta1 + c2 omega/k2, and alpha2."""
    m, J, r, k1, k2, k3, c1, c2 = 2.0, 0.03, 0.1, 900.0, 60.0, 180.0, 0.4, 0.6
    rig = Rig.from_si(m=m, J=J, r=r, k1=k1, k2=k2, k3=k3, c1=c1, c2=c2, length=0.01)
    omega = np.sqrt((k1 + k2) / m)
    assert rig.alpha1 == pytest.approx(omega**2 * m / k2)
    assert rig.alpha1 == pytest.approx((k1 + k2) / k2)  # the paper's beta1
    assert rig.alpha2 == pytest.approx(omega**2 * J / r**2 / k2)
    assert rig.beta3 == pytest.approx((k2 + k3) / k2)
    assert rig.eta1 == pytest.approx(c1 * omega / k2)
    assert rig.eta12 == pytest.approx(rig.eta1 + c2 * omega / k2)


def test_the_unused_parameters_belong_to_the_normal_force():
    """beta2 and eta2 appear in no equation: N = N0 + k3 y + c2 y' scales the friction."""
    law = PaperFriction()
    feedback = effect("normal_force_feedback", beta2=0.8, eta2=0.0)
    plain = Model(RIG, friction=law)
    fed = Model(RIG, friction=law, effects=[feedback])
    start = (0.1, 0.1, 0.0, 0.0)
    runs = [simulate(model, belt_speed=0.1, initial=start, t_end=60.0) for model in (plain, fed)]
    x1, _, y1, y2 = runs[1].transitions.state.T
    leaving = (runs[1].transitions.before == 0) & (runs[1].transitions.after == -1)
    q = RIG.alpha1 * x1 + RIG.eta1 * (0.1 + y2) + y1
    assert leaving.sum() >= 2
    assert q[leaving] == pytest.approx(5.94 * (1 + 0.8 * y1[leaving] / 5.94), abs=1e-7)
    assert np.ptp(y1[leaving]) + abs(y1[leaving][0]) > 1e-3  # or the feedback would have done nothing
    assert runs[0].transitions.t[0] != pytest.approx(runs[1].transitions.t[0], abs=1e-6)
