"""Cycles, branches, steady sliding and exponents of rigs of any kind: against named rigs, closed forms, differences."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from rig_cycles import LEINE, by_differences, drill, lugre, three_blocks, two_blocks
from stickslip.simulated.orbits.flow_of import flow_of

Floats = NDArray[np.float64]
RIG, PAPER = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), ss.PaperFriction()


def rebuilt(law: ss.FrictionLaw) -> ss.Model:
    """The rig of (2.1) by its matrices: states x, y, v_x, v_y."""
    rig = ss.MatricesRig(
        M=[[16, 0], [0, 8]], C=[[0.1, 0.1], [0.1, 0.2]], K=[[16, 1], [1, 4]], contact=[1, 0], names=["x", "y"], unit="1"
    )  # fmt: skip
    return ss.Model(rig, friction=law)


def block(law: ss.FrictionLaw, damping: float = 0.0, effects: tuple[ss.Effect, ...] = ()) -> ss.Model:
    """The block on a belt by its parts."""
    rig = ss.BodiesRig(
        body={"b": ss.Body(mass=1)},
        link=[ss.Link(between=("b", "ground"), stiffness=1, damping=damping)],
        contact=[ss.Contact(body="b", against="belt")],
    )
    return ss.Model(rig, friction=law, effects=effects)


ORDER = [0, 2, 1, 3]  # of x, y, v_x, v_y: x1, x2, y1, y2


# -- the named rigs again ------------------------------------------------------------------------------------------


def test_the_cycle_of_the_reference_rig_by_its_matrices_is_that_of_the_named_one() -> None:
    named, ours = ss.limit_cycle(ss.Model(RIG, friction=PAPER), 0.1), ss.limit_cycle(rebuilt(PAPER), 0.1)
    assert ours.states == ("x", "y", "v_x", "v_y")
    assert ours.period == pytest.approx(named.period, rel=1e-12)
    assert ours.state[ORDER] == pytest.approx(named.state, abs=1e-11)
    assert ours.multipliers == pytest.approx(named.multipliers, abs=1e-9)
    assert ours.multipliers[2] == 0
    np.testing.assert_allclose(ours.monodromy[np.ix_(ORDER, ORDER)], named.monodromy, atol=1e-8)
    assert ours.transitions.t == pytest.approx(named.transitions.t, abs=1e-10)
    assert ours.transitions.after.ravel().tolist() == named.transitions.after.tolist()


def test_the_derivatives_of_a_cycle_are_those_of_the_named_one() -> None:
    names = ("T_s_minus", "t2", "belt_speed")
    named = ss.cycle_sensitivity(ss.limit_cycle(ss.Model(RIG, friction=PAPER), 0.1), names)
    ours = ss.cycle_sensitivity(ss.limit_cycle(rebuilt(PAPER), 0.1), names)
    assert ours.period == pytest.approx(named.period, rel=1e-8)
    np.testing.assert_allclose(ours.state[ORDER], named.state, rtol=1e-7, atol=1e-9)


@pytest.mark.study
def test_a_branch_by_its_parts_is_that_of_the_named_rig() -> None:
    asked = {"parameter": "belt_speed", "span": (1.4, 3.5), "guess": (3.0, 0.0)}
    named = ss.continuation(ss.Model(ss.BlockOnBelt(damping=0.1), friction=LEINE), 2.0, **asked)  # type: ignore[arg-type]
    ours = ss.continuation(block(LEINE, 0.1), 2.0, **asked)  # type: ignore[arg-type]
    assert (
        [one.kind for one in ours.special] == [one.kind for one in named.special] == ["loss_of_stick", "hopf"]
    )
    for one, other in zip(ours.special, named.special, strict=True):
        assert one.value == pytest.approx(other.value, abs=1e-8)
        assert one.cycle.period == pytest.approx(other.cycle.period, abs=1e-6)
    assert ours.special[1].value == pytest.approx((np.sqrt(30) - 1) / 3, abs=1e-12)
    assert ours.ends == named.ends
    assert ours.special[0].turns_round
    lower = np.interp([1.5, 2.0, 2.5], ours.values[ours.stick_time > 0], ours.period[ours.stick_time > 0])
    other = np.interp([1.5, 2.0, 2.5], named.values[named.stick_time > 0], named.period[named.stick_time > 0])
    np.testing.assert_allclose(lower, other, atol=1e-4)


def test_the_exponents_are_those_of_the_named_rig() -> None:
    asked = {"belt_speed": 0.1, "t_end": 800.0, "transient": 200.0}
    named = ss.lyapunov(ss.Model(RIG, friction=PAPER), **asked)  # type: ignore[arg-type]
    ours = ss.lyapunov(rebuilt(PAPER), **asked)  # type: ignore[arg-type]
    # of the pair each is a time average, which hangs on where the vectors began; their sum does not
    sums = [np.append(one.exponents[0], one.exponents[1:3].sum()) for one in (ours, named)]
    np.testing.assert_allclose(sums[0], sums[1], atol=1e-9)
    np.testing.assert_allclose(ours.exponents[:3], named.exponents[:3], atol=1e-3)
    assert ours.exponents[3] == named.exponents[3] == -np.inf
    assert ours.state[ORDER] == pytest.approx(named.state, abs=1e-8)


def test_a_forced_rig_is_looked_at_inside_a_stick() -> None:
    law = ss.HyperbolicFriction(scale=3, decay=1.42, constant=1, quadratic=0.1)
    forcing = ss.effect("harmonic_forcing", a=3.6, w=1.067, phi=np.pi / 2)
    named = ss.limit_cycle(ss.Model(ss.BlockOnBelt(), friction=law, effects=[forcing]), 1.0)
    ours = ss.limit_cycle(block(law, effects=(forcing,)), 1.0)
    assert ours.contact == named.contact == "stick"
    assert ours.state == pytest.approx(named.state, abs=1e-11)
    assert ours.period == pytest.approx(2 * np.pi / 1.067, rel=1e-14)
    assert ours.multipliers == pytest.approx(named.multipliers, abs=1e-9)
    moved, want = (ss.cycle_sensitivity(one, ("belt_speed",)) for one in (ours, named))
    np.testing.assert_allclose(moved.state, want.state, atol=1e-8)
    assert moved.state[1, 0] == pytest.approx(1.0)  # what sticks moves with the belt


def test_a_belt_whose_speed_is_a_formula_is_the_ripple_of_a_named_rig() -> None:
    ripple = ss.effect("belt_speed_ripple", a=0.3, w=0.8, phi=0.3)
    plain = ss.Model(ss.BlockOnBelt(damping=0.05), friction=LEINE)
    named = ss.limit_cycle(plain.with_effects([ripple]), 0.5)
    ours = ss.limit_cycle(plain, "0.5*(1 + 0.3*sin(0.8*t + 0.3))")
    assert ours.contact == named.contact == "stick"
    assert ours.period == pytest.approx(2 * np.pi / 0.8, rel=1e-12)
    assert ours.state == pytest.approx(named.state, abs=1e-10)
    assert ours.multipliers == pytest.approx(named.multipliers, abs=1e-8)
    again = ours.trajectory(3)
    assert again.state[-1] == pytest.approx(again.state[0], abs=1e-10)
    branches = [
        ss.continuation(model, speed, parameter="damping", span=(0.02, 0.1), step=0.1)
        for model, speed in ((ours.model, ours.belt_speed), (named.model, 0.5))
    ]
    for branch in branches:
        assert branch.ends == ("span", "span")
        assert branch.forced
    np.testing.assert_allclose(*(one.multipliers[[0, -1], 0] for one in branches), atol=1e-8)


def test_a_drive_that_turns_to_and_fro_moves_the_slider_in_a_cycle() -> None:
    """Seen from the drive; the mean of its speed carries the slider along."""
    cycle = ss.limit_cycle(pulled(), drive_speed="0.5 + 0.2*sin(0.8*t)")
    run = cycle.trajectory(9)
    assert run.state[-1] - run.state[0] == pytest.approx([0.5 * cycle.period, 0], abs=1e-9)
    assert cycle.period == pytest.approx(2 * np.pi / 0.8 * cycle.turns, rel=1e-12)
    found = by_differences(cycle, {"drive_speed": "0.5 + 0.2*sin(0.8*t)"}, 1e-5)
    np.testing.assert_allclose(cycle.monodromy, found, atol=1e-7)


# -- a drive, and what nothing holds -------------------------------------------------------------------------------


def pulled(stiffness: float = 1.0) -> ss.Model:
    rig = ss.BodiesRig(
        body={"b": ss.Body(mass=1)},
        link=[ss.Link(between=("b", "drive"), stiffness=stiffness, damping=0.1)],
        contact=[ss.Contact(body="b")],
    )
    return ss.Model(rig, friction=LEINE)


def test_a_slider_pulled_through_a_spring_is_the_block_on_a_belt_seen_from_the_drive() -> None:
    on_belt = ss.Model(ss.BlockOnBelt(damping=0.1), friction=LEINE)
    want = ss.limit_cycle(on_belt, -0.3)
    ours = ss.limit_cycle(pulled(), drive_speed=0.3)
    assert ours.period == pytest.approx(want.period, rel=1e-12)
    assert ours.state == pytest.approx(np.add(want.state, [0, 0.3]), abs=1e-11)
    assert ours.multipliers == pytest.approx(want.multipliers, abs=1e-9)
    run = ours.trajectory(5)
    assert run.state[-1] - run.state[0] == pytest.approx([0.3 * ours.period, 0], abs=1e-10)
    moved = ss.cycle_sensitivity(ours, ("drive_speed", "link_1.stiffness"))
    theirs = ss.cycle_sensitivity(want, ("belt_speed", "stiffness"))
    assert moved.period == pytest.approx(theirs.period * [-1, 1], rel=1e-7)
    np.testing.assert_allclose(moved.state, theirs.state * [-1, 1] + [[0, 0], [1, 0]], atol=1e-7)
    sliding, theirs_too = ss.steady_sliding(pulled(), drive_speed=2.0), ss.steady_sliding(on_belt, -2.0)
    assert sliding.state == pytest.approx(np.add(theirs_too.state, [0, 2.0]), abs=1e-12)
    assert sliding.eigenvalues == pytest.approx(theirs_too.eigenvalues, abs=1e-9)


def test_friction_that_repeats_along_the_ground_forces_a_slider_that_is_pulled_over_it() -> None:
    rough = ss.effect("formula", where="b", factor="1 + A*sin(q*position)", A=0.6, q=0.4)
    belt = ss.effect("formula", where="contact", factor="1 - A*sin(q*travel)", A=0.6, q=0.4)
    ours = ss.limit_cycle(pulled().with_effects([rough]), drive_speed=2.0)
    want = ss.limit_cycle(ss.Model(ss.BlockOnBelt(damping=0.1), friction=LEINE, effects=[belt]), -2.0)
    assert ours.period == pytest.approx(want.period, rel=1e-12)
    assert ours.period == pytest.approx(2 * np.pi / 0.4 / 2.0, rel=1e-12)
    assert ours.state == pytest.approx(np.add(want.state, [0, 2.0]), abs=1e-10)
    assert ours.multipliers == pytest.approx(want.multipliers, abs=1e-8)
    assert np.ptp(ours.trajectory().state[:, 1]) > 0.05
    asked = {"initial": ours.state, "t_end": 100 * ours.period, "interval": 0.3 * ours.period}
    found = ss.lyapunov(ours.model, drive_speed=2.0, **asked)  # type: ignore[arg-type]
    assert found.exponents == pytest.approx(np.log(np.abs(ours.multipliers)) / ours.period, abs=2e-3)
    end = float(found.t[-1])
    run = ss.simulate(
        ours.model, drive_speed=2.0, initial=ours.state, t_end=end, t_eval=[end], rtol=1e-12, atol=1e-12
    )
    assert found.state == pytest.approx(run.state[0] - [2.0 * end, 0], abs=1e-7)


def test_a_branch_in_the_drive_s_speed_is_that_in_the_belt_s() -> None:
    branch = ss.continuation(
        pulled(), parameter="drive_speed", span=(1.4, 2.0), guess=(-2.0, 2.0), drive_speed=1.6
    )
    assert branch.ends[0] == branch.ends[1] == "span"
    assert branch.stable.all()
    other = ss.limit_cycle(ss.Model(ss.BlockOnBelt(damping=0.1), friction=LEINE), -2.0, (-3.0, 0.0))
    assert branch.period[-1] == pytest.approx(other.period, rel=1e-9)


# -- laws with states ----------------------------------------------------------------------------------------------

a, b, N, D_c, V, m = 0.008, 0.012, 100.0, 0.01, 0.01, 1.0
CRITICAL = (b - a) * N / D_c * (1 + m * V**2 / (a * N * D_c))


def slider(stiffness: float, state_law: str) -> ss.Model:
    rock = ss.RateAndStateFriction(mu0=0.6, a=a, b=b, D_c=D_c, V_0=V, normal=N, state_law=state_law)  # type: ignore[arg-type]
    return ss.Model(ss.BlockOnBelt(mass=m, stiffness=stiffness), friction=rock)


@pytest.mark.parametrize("state_law", ["aging", "slip"])
def test_steady_sliding_under_rate_and_state_loses_its_stability_at_the_critical_stiffness(
    state_law: str,
) -> None:
    at = ss.steady_sliding(slider(CRITICAL, state_law), V)
    assert at.state == pytest.approx([0.6 * N / CRITICAL, 0, D_c / V], abs=1e-12)
    assert at.eigenvalues[:2].real == pytest.approx([0, 0], abs=1e-13)
    # the cubic of Rice and Ruina (1983): m l^3 + (m V/D_c + a N/V) l^2 + (k - (b - a) N/D_c) l + k V/D_c
    for share in (0.9, 1.1):
        k = share * CRITICAL
        cubic = [m, m * V / D_c + a * N / V, k - (b - a) * N / D_c, k * V / D_c]
        found = ss.steady_sliding(slider(k, state_law), V)
        assert np.sort_complex(found.eigenvalues) == pytest.approx(np.sort_complex(np.roots(cubic)), rel=1e-9)
        assert found.stable == (share > 1)


def test_a_branch_ends_at_the_hopf_point_of_the_rate_and_state_slider() -> None:
    model = slider(0.99 * CRITICAL, "slip")
    cycle = ss.limit_cycle(model, V, guess=(60 / 0.99 / CRITICAL + 5e-3, 0.0), settle=3000)
    assert cycle.stable
    span = (0.985 * CRITICAL, 1.01 * CRITICAL)
    branch = ss.continuation(model, V, parameter="stiffness", span=span, guess=cycle, step=0.05)
    assert branch.ends == ("span", "hopf")
    assert branch.special[-1].kind == "hopf"
    assert branch.special[-1].value == pytest.approx(CRITICAL, rel=1e-8)
    # the cycles that the core closes shrink to it, and turn as fast as sliding does there
    ends = np.sqrt(CRITICAL * V / D_c / (m * V / D_c + a * N / V))
    assert branch.values[-1] == pytest.approx(CRITICAL, rel=2e-3)
    assert 2 * np.pi / branch.period[-1] == pytest.approx(ends, rel=5e-3)


@pytest.mark.parametrize(
    ("case", "step"), [(lugre, 1e-6), (two_blocks, 1e-5), (three_blocks, 1e-5), (drill, 1e-5)]
)
def test_the_monodromy_is_that_of_disturbed_runs(
    case: Callable[[], tuple[ss.Model, Mapping[str, float]]], step: float
) -> None:
    model, speeds = case()
    cycle = ss.limit_cycle(model, **speeds)  # type: ignore[arg-type]
    assert cycle.residual < 1e-11
    found = by_differences(cycle, speeds, step)
    scale = np.abs(found).max()
    np.testing.assert_allclose(cycle.monodromy, found, atol=2e-6 * scale)
    assert np.abs(cycle.monodromy).max() > 0.5


def test_the_rate_at_the_end_of_an_arc_is_that_of_runs() -> None:
    """Coupled inertias, a contact that rubs on both, a belt that speeds up and slows down."""
    rig = ss.MatricesRig(
        M=[[1, 0.2], [0.2, 2]], C=[[0.1, 0], [0, 0.1]], K=[[1, 0.1], [0.1, 1]], contact=[1, 0.5], names=["x", "y"],
        unit="1",
    )  # fmt: skip
    speed = "0.3 + 0.1*sin(0.7*t)"
    flow = flow_of(ss.Model(rig, friction=LEINE), speed)
    z, seen = np.array([0.1, 0.2, 0.0, 0.0]), set()
    for end in np.arange(1.0, 21.0):
        arc = flow.arc(z, float(end))
        seen.add(int(arc.run.mode[-1, 0]))
        run = ss.simulate(
            flow.model, belt_speed=speed, initial=z, t_end=end + 1e-4, t_eval=end + 1e-4 * np.array([-1, 1]),
            rtol=1e-13, atol=1e-13,
        )  # fmt: skip
        if np.abs(run.transitions.t - end).min() > 1e-4:
            np.testing.assert_allclose(arc.rate, np.diff(run.state, axis=0)[0] / 2e-4, atol=1e-7)
    assert seen == {-1, 0}


def test_exponents_on_a_cycle_of_two_blocks_are_those_of_its_multipliers() -> None:
    model, speeds = two_blocks()
    cycle = ss.limit_cycle(model, **speeds)  # type: ignore[arg-type]
    assert cycle.contact == ("auto", "stick")
    found = ss.lyapunov(model, **speeds, initial=cycle.state, t_end=100 * cycle.period, interval=cycle.period)  # type: ignore[arg-type]
    rates = np.log(np.abs(cycle.multipliers[:2])) / cycle.period
    assert found.exponents[:3] == pytest.approx([0, *rates], abs=2e-3)
    assert found.exponents[3] == -np.inf


def test_a_branch_of_two_blocks_goes_on_where_one_no_longer_sticks_at_the_cut() -> None:
    model, speeds = two_blocks()
    branch = ss.continuation(model, **speeds, span=(0.18, 0.25), step=0.1)  # type: ignore[arg-type]
    assert branch.ends == ("span", "span")
    assert not branch.special
    for k in (0, -1):
        alone = ss.limit_cycle(model, float(branch.values[k]))
        assert (alone.contact == "auto") == (k == -1)
        assert branch.period[k] == pytest.approx(alone.period, rel=1e-9)
        np.testing.assert_allclose(np.poly(branch.multipliers[k]), np.poly(alone.multipliers), atol=1e-8)
        tr, ends = alone.transitions, alone.transitions.t + alone.period
        lasting = np.diff(np.append(tr.t, ends[0]))
        assert branch.stick_time[k] == pytest.approx(float(lasting @ (tr.after == 0).sum(axis=1)), rel=1e-8)


@pytest.mark.study
def test_exponents_of_steady_sliding_on_bristles() -> None:
    """One direction is some fifty times faster than the block."""
    law = ss.LuGreFriction(sigma0=100, sigma1=10, sigma2=0.4, F_c=1, F_s=1.5, v_s=0.1)
    model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=2), friction=law)
    still = ss.steady_sliding(model, 0.8)
    found = ss.lyapunov(model, belt_speed=0.8, initial=still.state + [1e-3, 0, 0], t_end=400, transient=10)  # noqa: RUF005
    np.testing.assert_allclose(found.exponents, still.eigenvalues.real, rtol=1e-4, atol=2e-3)


# -- what cannot be done -------------------------------------------------------------------------------------------

STEPS = ss.Speed.steps([0, 5], [0.1, 0.2])
SLOWLY = ss.FormulaFriction(kinetic="F*(1 + 0.01*t)", static="F*(1 + 0.01*t)", F=1.0)
AGING = ss.FormulaFriction(kinetic="F/(1 + 3*u)", static="F + 0.1*log(1 + dwell)", F=1.0)
WASHBOARD = ss.effect("formula", where="b", force="A*sin(9*deflection)", A=0.1)
DRIVEN = ss.Model(ss.DrivenSlider(mass=1), friction=ss.CoulombFriction())
FREE = ss.Model(
    ss.BodiesRig(body={"b": ss.Body(mass=1)}, contact=[ss.Contact(body="b", against="belt")]), friction=LEINE
)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: ss.limit_cycle(block(LEINE)), "belt_speed: missing: a contact rubs on the belt"),
        (lambda: ss.limit_cycle(pulled(), 0.1, drive_speed=0.1), "belt_speed: no contact rubs on a belt"),
        (lambda: ss.limit_cycle(block(LEINE), STEPS), "changes in steps; no motion repeats"),
        (lambda: ss.limit_cycle(block(LEINE), "0.1 + 0.01*t"), "belt_speed: changes with time without a period"),
        (lambda: ss.limit_cycle(block(LEINE), "0.3 + 0.1*sin(t) + 0.1*sin(2**0.5*t)"), "quasi-periodic"),
        (lambda: ss.limit_cycle(block(SLOWLY), 0.1), "changes with time without a period"),
        (
            lambda: ss.limit_cycle(pulled().with_effects([WASHBOARD]), drive_speed="0.2 + 0.1*sin(t)"),
            "reads a coordinate that the drive carries away",
        ),
        (lambda: ss.limit_cycle(FREE, 0.1), "no contact moves anything that a spring holds"),
        (lambda: ss.limit_cycle(block(LEINE), 0.0), "every contact comes to stick"),
        (lambda: ss.steady_sliding(block(LEINE), 0.0), "contact 'b' does not slide in steady motion"),
        (lambda: ss.steady_sliding(block(LEINE), "0.1*sin(t)"), "depends on time: it has no equilibrium"),
        (
            lambda: ss.continuation(block(LEINE), "0.3 + 0.1*sin(t)", span=(0.1, 0.3)),
            "belt_speed = .*: is a formula of t; a parameter is a number",
        ),
        (
            lambda: ss.lyapunov(block(AGING, 0.02), belt_speed=0.1, t_end=800),
            "its law reads how long it has stuck",
        ),
        (lambda: ss.limit_cycle(DRIVEN, 0.1), "neither belt nor spring"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_refused_in_a_line(ask: Callable[[], object], message: str) -> None:
    with pytest.raises(ss.StickslipError, match=message) as caught:
        ask()
    assert "\n" not in str(caught.value)


def test_a_number_of_a_reading_moves_no_cycle() -> None:
    model = block(LEINE, effects=(ss.effect("sensor_lag", tau=0.1),))
    assert ss.limit_cycle(model, 0.2).period == pytest.approx(
        ss.limit_cycle(block(LEINE), 0.2).period, rel=1e-12
    )
    with pytest.raises(ss.StickslipError, match="acts on the reading, not on the motion"):
        ss.continuation(model, 0.2, parameter="sensor_lag.tau", span=(0.05, 0.2))
