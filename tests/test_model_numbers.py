"""Every published or closed-form number of the model, held by `simulate`; and why the paper is read as it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

pytest.importorskip("stickslip._core")
import known_numbers as known
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.simulated.simulate import simulate

TIGHT = {"rtol": 1e-13, "atol": 1e-13}


def turning_point(model, v_b, start, low, high):
    """x1 where x2 vanishes between the times `low` and `high`."""

    def state(t):
        run = simulate(model, belt_speed=v_b, initial=start, t_end=t, t_eval=[t], **TIGHT)
        return run.state[-1]

    t = brentq(lambda t: state(t)[1], low, high, xtol=1e-13)
    return state(t)[0]


# --- closed forms and published numbers ---------------------------------------------------------------------


@known.coulomb_blocks
def test_coulomb_block_on_belt(static, kinetic, v_b, slip, stick, high, low, direction):
    model = Model(BlockOnBelt(), friction=CoulombFriction(static=static, kinetic=kinetic))
    start = (0.0, direction * v_b)
    run = simulate(model, belt_speed=direction * v_b, initial=start, t_end=100, **TIGHT)
    change = run.transitions
    assert change.t[0] == pytest.approx(static / v_b, abs=1e-11)
    assert np.diff(change.t)[::2] == pytest.approx(slip, abs=1e-11)
    assert np.diff(change.t)[1::2] == pytest.approx(stick, abs=1e-11)
    assert direction * change.state[1::2, 0] == pytest.approx(2 * kinetic - static, abs=1e-11)
    assert change.after.tolist() == [-direction if k % 2 == 0 else 0 for k in range(len(change))]
    # from the release the block swings about the kinetic force, starting with the belt's speed
    excess = math.atan2(v_b, static - kinetic)
    begin = change.t[0]
    ends = [
        turning_point(
            model, direction * v_b, start, begin + excess + shift - 0.3, begin + excess + shift + 0.3
        )
        for shift in (0.0, math.pi)
    ]
    assert direction * np.array(ends) == pytest.approx([high, low], abs=1e-11)


def test_leine_period_return_and_extreme():
    model = known.leine()
    run = simulate(model, belt_speed=0.2, initial=(0.0, 0.2), t_end=90, **TIGHT)
    starts = run.transitions.t[run.transitions.after == -1]
    assert starts.size == 8
    assert np.diff(starts) == pytest.approx(known.LEINE_PERIOD, abs=1e-10)
    assert run.transitions.state[1::2, 0] == pytest.approx(known.LEINE_CAPTURE, abs=1e-10)
    assert turning_point(model, 0.2, (0.0, 0.2), 5.5, 7.5) == pytest.approx(known.LEINE_HIGHEST, abs=1e-10)


@known.den_hartog_rigs
def test_den_hartog_amplitude(r, friction, amplitude):
    def half_period(unknowns):
        x, phase = unknowns
        model = known.den_hartog(r, friction, phase)
        run = simulate(model, belt_speed=0.0, initial=(x, 0.0), t_end=math.pi / r, **TIGHT)
        return run.state[-1] + np.array([x, 0.0])

    found = root(half_period, (1.05 * amplitude, math.copysign(math.pi / 2, 1 - r)), tol=1e-12)
    assert np.abs(found.fun).max() < 1e-10
    assert found.x[0] == pytest.approx(amplitude, abs=1e-8)


def test_forced_popp_stelter():
    model = known.popp_stelter()
    run = simulate(
        model,
        belt_speed=1.0,
        initial=(0.0, 0.0),
        t_end=75 * known.POPP_STELTER_PERIOD,
        rtol=1e-12,
        atol=1e-12,
    )
    assert run.transitions.t[:6] == pytest.approx(known.POPP_STELTER_TIMES, abs=1e-8)
    assert run.transitions.after[:6].tolist() == known.POPP_STELTER_MODES
    assert run.state[-1, 0] == pytest.approx(known.POPP_STELTER_STROBE, abs=1e-8)
    assert run.mode[-1] == 0


def test_energy_identity_without_friction():
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.linspace(0, 30, 121)
    half = (edges[1] - edges[0]) / 2
    times = (edges[:-1, None] + half * (nodes + 1)).ravel()
    run = simulate(
        known.frictionless(),
        belt_speed=0.1,
        initial=(0.4, -0.2, 0.3, 0.1),
        t_end=30,
        t_eval=[0, *times, 30],
        **TIGHT,
    )
    x2, y2 = run.state[1:-1, 1], run.state[1:-1, 3]
    lost = half * float(np.tile(weights, 120) @ (0.1 * (x2 + y2) ** 2 + 0.1 * y2**2))
    assert known.energy(run.state[0]) - known.energy(run.state[-1]) == pytest.approx(lost, abs=1e-12)


@pytest.mark.parametrize("v_b", [0.1, -0.1, 0.25])
def test_friction_takes_energy_all_along_every_slip(v_b):
    law, model = PaperFriction(), known.paper_model()
    times = np.linspace(0, 100, 4001)
    run = simulate(model, belt_speed=v_b, initial=known.START, t_end=100, t_eval=times, **TIGHT)
    slip = run.mode != 0
    v_w = run.state[slip, 1] - v_b
    assert np.count_nonzero(slip) > 500
    assert (run.mode[slip] * v_w >= -1e-12).all()  # the mode is the sign of v_w
    assert (-law.force(v_w) * v_w <= 0).all()
    # and what the motion shows: T from the balance of (2.1), acceleration by central differences inside a slip
    h = 1e-4
    centre = times[1:-1][(slip[:-2] & slip[1:-1] & slip[2:])][::20]
    fine = simulate(
        model, belt_speed=v_b, initial=known.START, t_end=100,
        t_eval=np.column_stack([centre - h, centre, centre + h]).ravel(), **TIGHT,
    ).state.reshape(-1, 3, 4)  # fmt: skip
    acceleration = (fine[:, 2, 1] - fine[:, 0, 1]) / (2 * h)
    x1, x2, y1, y2 = fine[:, 1].T
    shown = -16 * (acceleration + x1) - 0.1 * (x2 + y2) - y1
    assert (shown * (x2 - v_b) > 0).all()
    assert np.median(np.abs(shown - law.force(x2 - v_b))) < 1e-6


def test_long_run_of_the_reference_rig():
    run = simulate(
        known.paper_model(), belt_speed=0.1, initial=known.START, t_end=1000, rtol=1e-12, atol=1e-12
    )
    told = known.TRUTH_P1["transitions"]
    assert len(run.transitions) == len(told) == 191
    assert run.transitions.t == pytest.approx([row[0] for row in told], abs=1e-9)
    assert run.transitions.before.tolist() == [-(row[1] != 0) for row in told]
    assert run.transitions.after.tolist() == [-(row[2] != 0) for row in told]
    assert run.state[-1] == pytest.approx(known.TRUTH_P1["final"], abs=1e-9)


@known.hard_members
def test_hard_members_of_the_grid_at_a_loose_tolerance(member):
    model, v_b = known.of_the_grid(member)
    run = simulate(model, belt_speed=v_b, initial=known.START, t_end=200, rtol=1e-8, atol=1e-8)
    assert np.count_nonzero(run.transitions.before == 0) == known.TRUTH_P2["slips_all"][member]
    if member in known.TRUTH_P2["index"]:
        told = known.TRUTH_P2["final"][known.TRUTH_P2["index"].index(member)]
        assert run.state[-1] == pytest.approx(told, abs=1e-6)


# --- the readings of the paper's equations ------------------------------------------------------------------


def test_coupling_as_printed_creates_energy():
    # the two rows are then not the gradient of anything, and two bodies in tune flutter
    tuned = {"alpha2": 4.0, "beta3": 4.0, "eta1": 0.0, "eta12": 0.0}
    times = np.linspace(0, 100, 201)
    size = {}
    for coupling in ("reciprocal", "as_printed"):
        model = known.frictionless(**tuned, coupling=coupling)
        run = simulate(model, belt_speed=0.0, initial=(0.01, 0, 0, 0), t_end=100, t_eval=times, **TIGHT)
        size[coupling] = np.abs(run.state).max(axis=1)
    assert size["reciprocal"].max() < 0.03
    assert size["as_printed"][-20:].max() > 0.5
    # omega^2 = 1 -+ i/8: exp(t/16). The greatest of the last 20 against that of 40 earlier
    growth = math.log(size["as_printed"][-40:].max() / size["as_printed"][80:120].max()) / 40
    assert growth == pytest.approx(1 / 16, rel=0.05)


def test_reciprocal_coupling_keeps_energy():
    model = known.frictionless(eta1=0.0, eta12=0.0)
    run = simulate(model, belt_speed=0.0, initial=(0.3, 0.1, -0.2, 0.1), t_end=200, **TIGHT)
    assert known.energy(run.state[-1]) == pytest.approx(known.energy(run.state[0]), abs=1e-11)


def block_energy_after(friction, t_end=20.0):
    """Energy of a unit block, spring and resting floor under x'' = -x + friction(x'), from x = 3 at rest."""
    found = solve_ivp(lambda _, z: [z[1], -z[0] + friction(z[1])], (0, t_end), (3.0, 1e-3), max_step=0.02)
    return float(found.y[:, -1] @ found.y[:, -1]) / 2


def test_friction_with_the_printed_sign_drives_the_block():
    law = CoulombFriction(static=0.2, kinetic=0.2)
    assert block_energy_after(lambda v: float(law.force(v))) > 4.5 + 10  # the block feels +T: it gains
    run = simulate(Model(BlockOnBelt(), friction=law), belt_speed=0.0, initial=(3.0, 0.0), t_end=20, **TIGHT)
    assert run.state[-1] @ run.state[-1] / 2 < 0.5


def test_sign_in_4_3_counts_once():
    law, v = PaperFriction(), np.linspace(-0.5, 0.5, 1001)
    assert (law.force(v) * v >= 0).all()
    assert law.magnitude(v).min() > 0
    # printed: T_- of Table 1 is negative already, times sgn v_w it pushes along the slip
    printed = -law.magnitude(-0.1) * np.sign(-0.1)
    assert printed * -0.1 < 0


def printed_minus(u):
    """Magnitude of T_- with the exponent as printed, |v_w| - v_w,min = u + 0.28."""
    return 5.94 - 3.2345 * np.exp(-(u + 0.28) / 0.0342) - 2.8736 * np.exp(-(u + 0.28) / 0.3053)


def test_exponent_of_4_2_as_printed_strengthens_and_nothing_would_stick():
    u = np.linspace(0, 0.25, 251)
    assert (np.diff(printed_minus(u)) > 0).all()
    assert (np.diff(PaperFriction().magnitude(-u)) < 0).all()

    def slip(_, z):
        x1, x2, y1, y2 = z
        acceleration = -x1 - (0.1 * (x2 + y2) + y1 - printed_minus(0.1 - x2)) / 16
        return [x2, acceleration, y2, (-4 * y1 - 0.2 * y2 - x1 - 0.1 * x2) / 8]

    def arrives(_, z):
        return z[1] - 0.1

    arrives.direction = 1
    begin = 5.94 / 16
    printed = solve_ivp(slip, (0, 400), (begin, 0.1 - 1e-9, 0, 0), events=arrives, max_step=0.05, rtol=1e-8)
    assert abs(printed.y[1, -1]) < 1e-3  # steady slip
    assert all(t < 200 for t in printed.t_events[0])
    run = simulate(known.paper_model(), belt_speed=0.1, initial=known.START, t_end=400)
    assert (
        np.count_nonzero(run.transitions.after[run.transitions.t > 200] == 0) > 15
    )  # it sticks again and again


def test_branches_hold_their_minimum_beyond_the_fitted_range():
    law = PaperFriction()
    left = np.array([0.2604, 0.2605, 0.2783, 0.5, 2.0])
    assert law.magnitude(-left[1:]) == pytest.approx(1.42, abs=0)
    assert law.magnitude(-left[0]) > 1.42
    assert law.magnitude(np.array([0.27, 0.4, 3.0])) == pytest.approx(0.86, abs=1e-15)

    def unclamped(u):
        return 5.94 - 3.2345 * math.exp((u - 0.28) / 0.0342) - 2.8736 * math.exp((u - 0.28) / 0.3053)

    assert brentq(unclamped, 0.2, 0.3) == pytest.approx(
        0.2783, abs=5e-5
    )  # from here on it would pump known.energy
    assert brentq(lambda u: unclamped(u) - 1.42, 0.2, 0.3) == pytest.approx(law.kinks[0], abs=1e-14)
    assert law.kinks[0] == pytest.approx(known.TRUTH_P1["uc"], abs=1e-14)
    # a fast slip in the clamped range: the rig is pushed back by exactly 1.42
    run = simulate(
        known.paper_model(), belt_speed=0.5, initial=(0, -0.5, 0, 0), t_end=1e-4, t_eval=[0, 1e-4], **TIGHT
    )
    acceleration = (run.state[1, 1] - run.state[0, 1]) / 1e-4
    assert 16 * acceleration - 0.1 * 0.5 == pytest.approx(1.42, abs=1e-2)


def test_slip_begins_with_a_real_drop_of_the_force():
    law, model = PaperFriction(), known.paper_model()
    assert law.static_limits[0] == 5.94
    assert law.magnitude(-1e-12) == pytest.approx(4.7906, abs=1e-4)
    first = simulate(model, belt_speed=0.1, initial=known.START, t_end=4, **TIGHT).transitions.t[0]
    h = 1e-5
    run = simulate(model, belt_speed=0.1, initial=known.START, t_end=4, t_eval=[first, first + h], **TIGHT)
    jump = (run.state[1, 1] - run.state[0, 1]) / h
    assert jump == pytest.approx(-(5.94 - law.magnitude(-1e-12)) / 16, rel=1e-3)


@pytest.mark.parametrize(("v_b", "limit", "sign"), [(0.1, 5.94, -1), (-0.1, 3.63, 1)])
def test_static_force_is_a_set_with_a_limit_for_each_way(v_b, limit, sign):
    run = simulate(known.paper_model(), belt_speed=v_b, initial=(0, v_b, 0, 0), t_end=30, **TIGHT)
    first = run.transitions
    x1, _, y1, y2 = first.state[0]
    assert abs(16 * x1 + 0.1 * (v_b + y2) + y1) == pytest.approx(limit, abs=1e-11)
    assert (first.before[0], first.after[0]) == (0, sign)
