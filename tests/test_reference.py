"""The yardstick measured against closed forms, published numbers and a simulator written apart from it."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, root

import known_numbers as known
from stickslip.declared.effect import effect, tabulated
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.simulated.reference import integrate as reference
from studies import few


def turning_points(run):
    """x1 where x2 vanishes."""
    out = []
    for a, b in pairwise(run.steps):
        if a.z[1] * b.z[1] < 0:
            t = brentq(lambda t: run.at(t)[0, 1], a.t, b.t, xtol=1e-15)
            out.append(run.at(t)[0, 0])
    return out


def quadrature(run, value):
    """Integral of value(z) over the run, by Gauss's rule on every step."""
    nodes, weights = np.polynomial.legendre.leggauss(10)
    total = 0.0
    for step in run.steps[:-1]:
        half = (step.end - step.t) / 2
        z = run.at(step.t + half * (nodes + 1))
        total += half * float(weights @ value(z.T))
    return total


FEW = (3382, 1929, 4001)  # of the hard members; the core is held against all of them


@pytest.mark.sampled(2)
@known.coulomb_blocks
def test_coulomb_block_on_belt_in_closed_form(static, kinetic, v_b, slip, stick, high, low, direction):
    model = Model(BlockOnBelt(), friction=CoulombFriction(static=static, kinetic=kinetic))
    run = reference.simulate(model, belt_speed=direction * v_b, initial=(0.0, direction * v_b), t_end=60)
    change = run.transitions
    assert run.status.ok
    assert change.t[0] == pytest.approx(static / v_b, abs=1e-11)
    assert np.diff(change.t)[::2] == pytest.approx(slip, abs=1e-11)
    assert np.diff(change.t)[1::2] == pytest.approx(stick, abs=1e-11)
    assert change.after.tolist() == [-direction if k % 2 == 0 else 0 for k in range(change.t.size)]
    assert direction * change.state[1::2, 0] == pytest.approx(2 * kinetic - static, abs=1e-11)
    assert direction * np.array(turning_points(run))[:2] == pytest.approx([high, low], abs=1e-11)


def test_different_limits_in_each_direction_are_taken_on_their_side():
    law = CoulombFriction(static=1.0, kinetic=0.5, static_plus=2.0, kinetic_plus=1.5)
    model = Model(BlockOnBelt(), friction=law)
    forward = reference.simulate(model, belt_speed=0.2, initial=(0.0, 0.2), t_end=30)
    backward = reference.simulate(model, belt_speed=-0.2, initial=(0.0, -0.2), t_end=30)
    assert forward.transitions.state[:2, 0] == pytest.approx([1.0, 0.0], abs=1e-11)
    assert backward.transitions.state[:2, 0] == pytest.approx([-2.0, -1.0], abs=1e-11)


def test_leine_block_on_belt():
    model = known.leine()
    run = reference.simulate(model, belt_speed=0.2, initial=(0.0, 0.2), t_end=45)
    starts = run.transitions.t[run.transitions.after == -1]
    assert np.diff(starts) == pytest.approx(known.LEINE_PERIOD, abs=1e-10)
    assert run.transitions.state[1::2, 0] == pytest.approx(known.LEINE_CAPTURE, abs=1e-10)
    assert max(turning_points(run)) == pytest.approx(known.LEINE_HIGHEST, abs=1e-10)


@known.den_hartog_rigs
def test_den_hartog_amplitude(r, friction, amplitude):
    def half_period(unknowns):
        x, phase = unknowns
        model = known.den_hartog(r, friction, phase)
        run = reference.simulate(model, belt_speed=0.0, initial=(x, 0.0), t_end=math.pi / r)
        return run.state[-1] + np.array([x, 0.0])

    # without friction the response is in phase below resonance and against it above
    guess = (amplitude * 1.05, math.pi / 2 if r < 1 else -math.pi / 2)
    found = root(half_period, guess, tol=1e-12)
    assert np.abs(found.fun).max() < 1e-10
    assert found.x[0] == pytest.approx(amplitude, abs=1e-8)
    assert found.x[0] == pytest.approx(
        math.sqrt((1 / (1 - r**2)) ** 2 - (friction * math.tan(math.pi / (2 * r)) / r) ** 2), abs=1e-8
    )


@pytest.mark.study
def test_forced_popp_stelter_transitions_and_strobe():
    model = known.popp_stelter()
    run = reference.simulate(
        model,
        belt_speed=1.0,
        initial=(0.0, 0.0),
        t_end=75 * known.POPP_STELTER_PERIOD,
        t_eval=[75 * known.POPP_STELTER_PERIOD],
    )
    assert run.transitions.t[:6] == pytest.approx(known.POPP_STELTER_TIMES, abs=1e-9)
    assert run.transitions.after[:6].tolist() == known.POPP_STELTER_MODES
    assert run.state[-1, 0] == pytest.approx(known.POPP_STELTER_STROBE, abs=1e-9)
    assert run.mode[-1] == 0


def test_energy_falls_at_the_dampers_rate_without_friction():
    model = known.frictionless()
    run = reference.simulate(model, belt_speed=0.1, initial=(0.4, -0.2, 0.3, 0.1), t_end=30, tol=1e-13)

    lost = quadrature(run, lambda z: 0.1 * (z[1] + z[3]) ** 2 + 0.1 * z[3] ** 2)
    assert known.energy(run.state[0]) - known.energy(run.state[-1]) == pytest.approx(lost, abs=1e-12)
    assert lost > 0.3


@pytest.mark.sampled(1)
@pytest.mark.parametrize("v_b", [0.1, -0.1, 0.3])
def test_friction_never_feeds_the_rig(v_b):
    model = known.paper_model()
    run = reference.simulate(model, belt_speed=v_b, initial=known.START, t_end=60)
    balance = []
    for step in run.steps[:-1]:
        acceleration = run.system.field(step.t, step.z, step.side)[1]
        x1, x2, y1, y2 = step.z
        friction = -16 * (acceleration + x1) - 0.1 * (x2 + y2) - y1
        balance.append(friction * (x2 - v_b))
        assert -5.94 - 1e-9 <= friction <= 3.63 + 1e-9
    assert min(balance) > -1e-12
    assert max(balance) > 0.1


def test_clamp_of_table_1_begins_where_the_curve_meets_its_minimum():
    run = reference.simulate(known.paper_model(), belt_speed=0.1, initial=known.START, t_end=10)
    kinks = [t for t, name in run.kinks if name == "clamp"]
    assert len(kinks) == 2
    assert 0.1 - run.at(kinks)[:, 1] == pytest.approx(known.TRUTH_P1["uc"], abs=1e-12)


def test_reference_rig_has_the_transitions_of_the_extended_precision_run():
    run = reference.simulate(known.paper_model(), belt_speed=0.1, initial=known.START, t_end=60, tol=1e-13)
    told = [row for row in known.TRUTH_P1["transitions"] if row[0] < 60]
    assert run.transitions.t == pytest.approx([row[0] for row in told], abs=1e-11)
    assert run.transitions.before.tolist() == [-(row[1] != 0) for row in told]
    assert run.transitions.after.tolist() == [-(row[2] != 0) for row in told]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "member",
    few(known.HARD_MEMBERS, FEW),
)
def test_hard_members_of_the_grid_lose_no_slip(member):
    model, v_b = known.of_the_grid(member)
    run = reference.simulate(model, belt_speed=v_b, initial=known.START, t_end=200)
    assert np.count_nonzero(run.transitions.before == 0) == known.TRUTH_P2["slips_all"][member]
    if member in known.TRUTH_P2["index"]:
        assert run.state[-1] == pytest.approx(
            known.TRUTH_P2["final"][known.TRUTH_P2["index"].index(member)], abs=1e-9
        )


def test_every_transition_lies_on_its_surface():
    run = reference.simulate(known.paper_model(), belt_speed=0.1, initial=known.START, t_end=60)
    x1, _, y1, y2 = run.transitions.state.T
    demand = 16 * x1 + 0.1 * (0.1 + y2) + y1
    assert (run.transitions.state[:, 1] == 0.1).all()
    assert demand[run.transitions.before == 0] == pytest.approx(5.94, abs=1e-12)


@pytest.mark.parametrize(
    ("initial", "belt_speed", "mode"),
    [
        ((0.1, 0.1), 0.1, 0),  # on the belt, within the limits
        ((2.0, 0.1), 0.1, -1),  # on the belt, beyond what it can hold: the spring wins
        ((-2.0, 0.1), 0.1, 1),
        ((0.5, 0.3), 0.1, 1),
        ((0.5, -0.3), 0.1, -1),
        ((0.5, 0.0), 0.0, 0),  # belt at rest: it stays for ever
        ((2.0, 0.0), 0.0, -1),
        ((0.0, -0.2), -0.2, 0),
    ],
)
def test_starts_on_and_off_the_surface(initial, belt_speed, mode):
    model = Model(BlockOnBelt(), friction=CoulombFriction(static=1, kinetic=0.5))
    run = reference.simulate(model, belt_speed=belt_speed, initial=initial, t_end=0.1, t_eval=[0.0, 1e-3])
    assert run.status.ok
    assert run.mode.tolist() == [mode, mode]
    assert run.transitions.t.size == 0


def test_crossing_without_sticking():
    # belt at rest, far out: at the turning point the spring pulls harder than the belt can hold
    model = Model(BlockOnBelt(), friction=CoulombFriction(static=0.5, kinetic=0.5))
    run = reference.simulate(model, belt_speed=0.0, initial=(5.25, 0.0), t_end=20)
    # half swings about +-0.5: turning points 5.25, -4.25, 3.25, -2.25, 1.25, -0.25 (held)
    assert run.transitions.state[:, 0] == pytest.approx([-4.25, 3.25, -2.25, 1.25, -0.25], abs=1e-11)
    assert run.transitions.t == pytest.approx(np.pi * np.arange(1, 6), abs=1e-11)
    assert run.transitions.before.tolist() == [-1, 1, -1, 1, -1]
    assert run.transitions.after.tolist() == [1, -1, 1, -1, 0]


def test_belt_ripple_carries_the_stuck_block_exactly():
    model = known.paper_model(effect("belt_speed_ripple", a=0.3, w=2.0, phi=0.5))
    times = np.linspace(0, 2, 9)
    v0 = 0.1 * (1 + 0.3 * math.sin(0.5))
    run = reference.simulate(model, belt_speed=0.1, initial=(0.1, v0, 0, 0), t_end=2, t_eval=times)
    travel = 0.1 * (times - 0.15 * (np.cos(2 * times + 0.5) - math.cos(0.5)))
    assert (run.mode == 0).all()
    assert run.state[:, 0] - 0.1 == pytest.approx(travel, abs=1e-13)


def test_aged_contact_holds_longer_by_what_the_dwell_adds():
    model = Model(
        BlockOnBelt(), friction=CoulombFriction(), effects=(effect("static_aging", dT=0.4, tau=3.0),)
    )
    run = reference.simulate(model, belt_speed=0.2, initial=(0.0, 0.2), t_end=30)
    dwell = run.transitions.t[0]
    assert 0.2 * dwell == pytest.approx(1 + 0.4 * (1 - math.exp(-dwell / 3)), abs=1e-12)
    again = run.transitions.t[2] - run.transitions.t[1]  # and the next stick counts from its own beginning
    held = run.transitions.state[1, 0] + 0.2 * again
    assert held == pytest.approx(1 + 0.4 * (1 - math.exp(-again / 3)), abs=1e-12)


def test_drooping_belt_meets_its_load_in_steady_slip():
    # heavily damped block: it comes to rest in slip, F = kinetic, so b -> -k F
    model = Model(
        BlockOnBelt(damping=2.0),
        friction=CoulombFriction(static=1.0, kinetic=1.0),
        effects=(effect("belt_load_droop", k=0.1, tau=0.5),),
    )
    run = reference.simulate(model, belt_speed=0.5, initial=(0.0, 0.5), t_end=40)
    assert run.hidden[-1, 0] == pytest.approx(-0.1, abs=1e-10)
    assert run.state[-1] == pytest.approx([1.0, 0.0], abs=1e-10)


def test_sensor_lag_of_a_steady_ride_is_speed_times_lag():
    model = known.paper_model(effect("sensor_lag", tau=0.2), effect("sensor_drift", r=0.01))
    times = np.array([0.0, 0.5, 1.0, 2.0])
    run = reference.simulate(model, belt_speed=0.1, initial=known.START, t_end=2)
    shown = reference.readings(model, run, times)[:, 0]
    lag = 0.1 * 0.2 * (1 - np.exp(-times / 0.2))
    assert shown == pytest.approx(0.1 + 0.1 * times - lag + 0.01 * times, abs=1e-13)


def test_tabulated_line_is_the_catalogue_term_it_draws():
    # a natural spline through points of a line is that line: -c x2 by name and by table
    drawn = tabulated("block", "x2", (-2.0, -0.05, 0.0, 0.1, 2.0), (1.0, 0.025, 0.0, -0.05, -1.0))
    by_table = reference.simulate(known.paper_model(drawn), belt_speed=0.1, initial=known.START, t_end=40)
    by_name = reference.simulate(
        known.paper_model(effect("block_viscous_damping", c=0.5)),
        belt_speed=0.1,
        initial=known.START,
        t_end=40,
    )
    assert {name for _, name in by_table.kinks} == {"clamp", "knot0"}
    assert by_table.transitions.t == pytest.approx(by_name.transitions.t, abs=1e-10)
    assert by_table.state[-1] == pytest.approx(by_name.state[-1], abs=1e-10)


def test_tabulated_period_repeats():
    knots = tuple(np.linspace(0, np.pi, 9))
    curve = tabulated("contact", "t", knots, (*(0.1 * np.sin(2 * np.array(knots[:-1]))), 0.0), period=np.pi)
    run = reference.simulate(known.paper_model(curve), belt_speed=0.1, initial=known.START, t_end=20)
    system, side = run.system, [s.side for s in run.steps]
    for step, sides in list(zip(run.steps, side, strict=True))[5::50]:
        told = 1 + float(curve.curve(step.t))
        assert system.normal(step.t, step.z, sides) == pytest.approx(told, abs=1e-12)
    assert side[-1].cycle == (6,)


# effect, and the numbers of the independent simulator in bench/discovery that mean the same
APART = {
    "none": ({}, {}),
    "block_viscous_damping": ({"block_viscous_damping": {"c": 0.5}}, {"block_c": 0.5}),
    "block_quadratic_damping": ({"block_quadratic_damping": {"c": 4.0}}, {"block_cq": 4.0}),
    "spring_cubic_k1": ({"spring_cubic_k1": {"k": 10.0}}, {"k1_cubic": 10.0}),
    "spring_cubic_k2": ({"spring_cubic_k2": {"k": 10.0}}, {"k2_cubic": 10.0}),
    "spring_cubic_k3": ({"spring_cubic_k3": {"k": 100.0}}, {"k3_cubic": 100.0}),
    "spring_gap_k3": ({"spring_gap_k3": {"k": 5.0, "d": 0.05}}, {"gap_k": 5.0, "gap_d": 0.05}),
    "constant_load": ({"constant_load": {"f": 0.5}}, {"load": 0.5}),
    "harmonic_forcing": (
        {"harmonic_forcing": {"a": 0.6, "w": 1.7, "phi": 0.4}},
        {"force_a": 0.6, "force_w": 1.7, "force_phi": 0.4},
    ),
    "pivot_dry_friction": ({"pivot_dry_friction": {"f": 0.08}}, {"pivot_f": 0.08}),
    "normal_force_feedback": (
        {"normal_force_feedback": {"beta2": 6.0, "eta2": 3.0}},
        {"nf_beta2": 6.0, "nf_eta2": 3.0},
    ),
    "loss_of_contact": (
        {"normal_force_feedback": {"beta2": 60.0, "eta2": 30.0}},
        {"nf_beta2": 60.0, "nf_eta2": 30.0},
    ),
    "stribeck_peak": ({"stribeck_peak": {"dT": 0.8, "v_s": 0.05}}, {"peak_dT": 0.8, "peak_vs": 0.05}),
    "static_aging": ({"static_aging": {"dT": 0.8, "tau": 2.0}}, {"aging_dT": 0.8, "aging_tau": 2.0}),
    "friction_memory": ({"friction_memory": {"tau": 0.2}}, {"memory_tau": 0.2}),
    "friction_drift": ({"friction_drift": {"r": 0.004}}, {"drift_r": 0.004}),
    "belt_seam": (
        {"belt_seam": {"a": 0.2, "L": 1.3, "phi": 0.4}},
        {"seam_a": 0.2, "seam_L": 1.3, "seam_phi": 0.4},
    ),
    "contact_compliance": (
        {"contact_compliance": {"k": 300.0, "c": 2.0}},
        {"bristle_k": 300.0, "bristle_c": 2.0},
    ),
    "belt_speed_ripple": (
        {"belt_speed_ripple": {"a": 0.2, "w": 2.1, "phi": 0.7}},
        {"ripple_a": 0.2, "ripple_w": 2.1, "ripple_phi": 0.7},
    ),
    "belt_load_droop": ({"belt_load_droop": {"k": 0.01, "tau": 0.5}}, {"droop_k": 0.01, "droop_tau": 0.5}),
    "sensors": (
        {
            "sensor_lag": {"tau": 0.07},
            "sensor_crosstalk": {"c": 0.05},
            "sensor_nonlinearity": {"q": 0.2},
            "sensor_delay": {"delay": 0.05},
            "sensor_drift": {"r": 0.002},
        },
        {"lag_tau": 0.07, "crosstalk_c": 0.05, "nonlinear_q": 0.2, "delay": 0.05, "drift_x1": 0.002},
    ),
    "moving_belt_and_normal_force": (
        {
            "belt_load_droop": {"k": 0.01, "tau": 0.5},
            "belt_speed_ripple": {"a": 0.2, "w": 2.1, "phi": 0.7},
            "normal_force_feedback": {"beta2": 6.0, "eta2": 3.0},
        },
        {"droop_k": 0.01, "droop_tau": 0.5, "ripple_a": 0.2, "ripple_w": 2.1, "ripple_phi": 0.7}
        | {"nf_beta2": 6.0, "nf_eta2": 3.0},
    ),
    "memory_pivot_and_peak": (
        {
            "friction_memory": {"tau": 0.2},
            "pivot_dry_friction": {"f": 0.08},
            "stribeck_peak": {"dT": 0.8, "v_s": 0.05},
        },
        {"memory_tau": 0.2, "pivot_f": 0.08, "peak_dT": 0.8, "peak_vs": 0.05},
    ),
}
LAW = {
    "Ts_m": 5.94, "A1": 3.2345, "A2": 2.8736, "t1": 0.0342, "t2": 0.3053, "u_m": 0.28, "Tmin_m": 1.42,
    "Ts_p": 3.63, "Tmin_p": 0.86, "u_p": 0.27, "s": 1.0,
}  # fmt: skip


@pytest.mark.sampled(10)
@pytest.mark.parametrize("name", APART)
@pytest.mark.parametrize("v_b", [0.1, -0.1])
def test_effects_agree_with_the_simulator_written_apart(name, v_b, monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "bench" / "discovery"))
    apart = pytest.importorskip("readings")
    wanted, numbers = APART[name]
    start = (0.1, 0.05, 0.02, -0.01)
    times = np.linspace(0, 24, 49)
    model = known.paper_model(*(effect(kind, **p) for kind, p in wanted.items()))
    run = reference.simulate(model, belt_speed=v_b, initial=start, t_end=24)
    assert run.status.ok
    assert run.transitions.t.size > 3

    hidden = np.zeros(len(apart.rigsim.STATE))
    hidden[:4] = start
    hidden[7] = start[0] + numbers.get("crosstalk_c", 0.0) * start[2]
    x1, y1, _, _ = apart.simulate(known.RIG | LAW | {"vb": v_b} | numbers, times, hidden, h_max=0.002)
    shown = reference.readings(model, run, times, interpolated=True)
    # the other one steps over kinks with a fixed step: second order in it there
    assert np.abs(shown - np.column_stack([x1, y1])).max() < (4e-5 if name == "contact_compliance" else 2e-6)


def test_a_run_given_up_says_why():
    run = reference.simulate(
        known.paper_model(), belt_speed=0.1, initial=known.START, t_end=60, max_transitions=3
    )
    assert not run.status.ok
    assert "after 3 switchings" in run.status.message
    assert run.t[-1] < 60
