"""Branches of limit cycles, against direct sweeps with simulate and bifurcations in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import stickslip as ss
from stickslip.shown.plot.branch import plot_branch
from stickslip.simulated.orbits.continuation import continuation
from stickslip.simulated.orbits.limit_cycle import limit_cycle
from test_cycles import DAMPED, LEINE, RIG, popp_stelter


def settled(model, v_b, start, t_end=400.0):
    """The last period of what a plain simulation settles to: times, states and modes from one release on."""
    run = ss.simulate(
        model, belt_speed=v_b, initial=start, t_end=t_end, contact="slip-", rtol=1e-12, atol=1e-12
    )
    tr = run.transitions
    releases = np.flatnonzero(tr.after == -1)[-2:]
    return tr.t[releases[0] : releases[1] + 1], tr.state[releases[0] :], tr.after[releases[0] : releases[1]]


def stuck(model, v_b, start):
    """Time stuck in a period of a plain simulation."""
    t, _, modes = settled(model, v_b, start)
    return float(np.diff(t)[modes == 0].sum())


@pytest.fixture(scope="module")
def leine():
    return continuation(LEINE, 0.2, span=(0.05, 5.0))


def test_leines_oscillator_against_a_direct_sweep(leine):
    assert leine.values[[0, -1]] == pytest.approx([0.05, 5.0], rel=1e-14)
    assert leine.stable.all()
    for k in range(0, len(leine), 12):
        v_b = leine.values[k]
        t, _, modes = settled(LEINE, v_b, (1.0, v_b), t_end=1200.0)
        assert leine.period[k] == pytest.approx(t[-1] - t[0], abs=1e-9)
        assert leine.stick_time[k] == pytest.approx(np.diff(t)[modes == 0].sum(), abs=1e-7)


def test_leines_oscillator_through_crossing_and_the_loss_of_stick(leine):
    assert [one.kind for one in leine.special] == ["crossing", "loss_of_stick"]
    crossing, loss = (one.value for one in leine.special)

    # the block comes back to the belt at x1 = -1, where the belt cannot hold it any more
    def returned(v, k):
        run = ss.simulate(
            LEINE, belt_speed=v, initial=(1.0, v), t_end=8.0, contact="slip-", rtol=1e-13, atol=1e-13
        )
        return run.transitions.state[k, 0]

    back = brentq(lambda v: returned(v, 0) + 1.0, 0.5, 0.7, xtol=1e-13)
    assert crossing == pytest.approx(back, abs=1e-9)
    below, above = (settled(LEINE, v, (1.0, v))[2].tolist() for v in (crossing - 1e-6, crossing + 1e-6))
    assert (below, above) == ([-1, 0], [-1, 1, 0])
    # having overtaken the belt it comes back at x1 = 1, where it is released at once
    vanished = brentq(lambda v: returned(v, 1) - 1.0, 4.2, 4.6, xtol=1e-13)
    assert loss == pytest.approx(vanished, abs=1e-9)
    assert 0 not in settled(LEINE, loss + 1e-6, (1.0, loss + 1e-6))[2]


@pytest.fixture(scope="module")
def damped():
    return continuation(DAMPED, 2.0, span=(0.5, 3.5), guess=(3.0, 0.0))


def test_the_branch_turns_round_where_stick_is_lost(damped):
    corner, hopf = damped.special
    assert corner.kind == "loss_of_stick"
    assert corner.turns_round
    assert damped.stable[: corner.index].all()
    assert not damped.stable[corner.index :].any()
    assert np.all(damped.stick_time[corner.index :] == 0)
    # directly: time stuck falls as the root of the distance; its square is extrapolated to zero
    near = corner.value - np.array([4e-6, 2e-6])
    squares = np.array([stuck(DAMPED, v, (1 - 0.1 * v, v)) ** 2 for v in near])
    gone = near[1] + squares[1] * (near[1] - near[0]) / (squares[0] - squares[1])
    assert corner.value == pytest.approx(gone, abs=1e-8)
    beyond = ss.simulate(
        DAMPED,
        belt_speed=corner.value + 1e-3,
        initial=(1 - 0.1 * corner.value, corner.value + 1e-3),
        t_end=3000,
    )
    assert beyond.transitions.t.max(initial=0.0) < 2900  # no cycle is left: it slides in the end
    # sliding loses stability where c = 3 / (1 + 3 v)^2, and the unstable cycle is born there
    assert hopf.kind == "hopf"
    assert hopf.value == pytest.approx((np.sqrt(30) - 1) / 3, abs=1e-9)
    assert damped.values[-1] == pytest.approx(hopf.value, abs=1e-2)


F, DROP, DECAY, M, K, C = 5.0, 3.0, 20.0, 1.2, 2400.0, 2.0  # of a block in SI
HOPF = (np.sqrt(DROP * DECAY / C) - 1) / DECAY  # its damping is the slope of the friction there
TIME, SPEED = np.sqrt(M / K), 1 / np.sqrt(K * M)  # units in which mass, stiffness and 1 N are 1


def hyperbolic(scale: float, decay: float, constant: float) -> ss.HyperbolicFriction:
    return ss.HyperbolicFriction(scale=scale, decay=decay, constant=constant)


def in_si() -> ss.Model:
    rig = ss.BlockOnBelt(mass=f"{M} kg", stiffness=f"{K} N/m", damping=f"{C} N s/m")
    return ss.Model(rig, friction=ss.HyperbolicFriction(scale="3 N", decay=DECAY, constant="5 N"))


def in_its_own_units() -> ss.Model:
    return ss.Model(ss.BlockOnBelt(damping=C * SPEED), friction=hyperbolic(DROP, DECAY * SPEED, F))


def by_its_parts() -> ss.Model:
    rig = ss.BodiesRig(
        body={"b": ss.Body(mass=M)},
        link=[ss.Link(between=("b", "ground"), stiffness=K, damping=C)],
        contact=[ss.Contact(body="b", against="belt")],
    )
    return ss.Model(rig, friction=hyperbolic(DROP, DECAY, F))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("step", [0.02, 0.5])
@pytest.mark.parametrize("model", [in_si, in_its_own_units, by_its_parts])
def test_every_point_of_a_branch_is_a_cycle_and_none_is_steady_sliding(model, step):
    speed, force = (SPEED, 1.0) if model is in_its_own_units else (1.0, 1 / K)
    branch = continuation(model(), 0.1 / speed, span=(0.01 / speed, 1.0 / speed), step=step)
    assert branch.ends == ("span", "hopf")
    corner, hopf = branch.special
    assert (corner.kind, hopf.kind) == ("loss_of_stick", "hopf")
    assert hopf.value * speed == pytest.approx(HOPF, rel=1e-10)
    # sliding at v deflects the spring by F + DROP / (1 + DECAY v), and turns in 2 pi sqrt(m / k) at its Hopf point
    v = branch.values * speed
    amplitude = branch.state[:, 0] / force - (F + DROP / (1 + DECAY * v))
    falling = amplitude[corner.index :]
    assert (np.diff(falling) < 0).all()
    assert (falling[1:] >= 0.499 * falling[:-1]).all()  # and so it is nowhere 0
    assert (v[corner.index :] > HOPF).all()
    near = falling < 0.3 * falling[0]  # a parabola: speeds beyond the Hopf point go as the square
    assert np.ptp(np.log((v[corner.index :] - HOPF) / falling**2)[near]) < 0.2
    for z, at, period, shift in zip(branch.state, branch.values, branch.period, amplitude, strict=True):
        end = ss.simulate(
            model(),
            belt_speed=at,
            initial=z,
            t_end=period,
            t_eval=[period / 2, period],
            rtol=1e-11,
            atol=1e-12,
        ).state
        assert np.abs(end[1] - z).max() < 1e-6 * abs(shift) * force / (1.0 if force == 1 else TIME)
        assert z[0] - end[0, 0] > 0.5 * shift * force  # half a period later it is on the other side
    assert hopf.sliding.state[0] / force == pytest.approx(F + DROP / (1 + DECAY * HOPF), rel=1e-10)
    assert hopf.period == pytest.approx(2 * np.pi * (1.0 if model is in_its_own_units else TIME), rel=1e-9)


def test_a_branch_is_the_same_in_any_units():
    si = continuation(in_si(), 0.1, span=(0.01, 1.0), step=0.1)
    own = continuation(in_its_own_units(), 0.1 / SPEED, span=(0.01 / SPEED, 1.0 / SPEED), step=0.1)
    parts = continuation(by_its_parts(), 0.1, span=(0.01, 1.0), step=0.1)
    assert len(si) == len(own) == len(parts)
    for other, speed, length, time in ((own, SPEED, 1 / K, TIME), (parts, 1.0, 1.0, 1.0)):
        np.testing.assert_allclose(other.values * speed, si.values, rtol=1e-5)
        np.testing.assert_allclose(other.period * time, si.period, rtol=1e-5)
        np.testing.assert_allclose(other.state[:, 0] * length, si.state[:, 0], rtol=1e-5)
        np.testing.assert_array_equal(other.stable, si.stable)


def test_the_figure_of_a_branch_goes_on_to_its_hopf_point():
    branch = continuation(in_si(), 0.1, span=(0.01, 1.0), step=0.1)
    hopf = branch.special[-1]
    for quantity, height in (("x1_max", hopf.sliding.state[0]), ("period", hopf.period), ("stick_time", 0.0)):
        (ax,) = plot_branch(branch, quantity).axes
        (mark,) = (line for line in ax.lines if line.get_label() == "Hopf, of sliding")
        (unstable,) = (line for line in ax.lines if line.get_label() == "unstable")
        assert mark.get_xydata()[0] == pytest.approx([hopf.value, height])
        np.testing.assert_array_equal(unstable.get_xydata()[-1], mark.get_xydata()[0])
        assert unstable.get_xdata().min() == hopf.value


def test_a_branch_that_ends_in_a_jump_says_so():
    # Coulomb with a drop: with damping the slip falls short of the belt, from a stick still of finite length
    model = ss.Model(ss.BlockOnBelt(damping=0.05), friction=ss.CoulombFriction(static=1, kinetic=0.5))
    branch = continuation(model, 0.2, span=(0.05, 4.0))
    (end,) = branch.special
    assert (end.kind, end.ends) == ("loss_of_stick", True)
    assert branch.stick_time[-1] > 0.1
    returns, misses = 0.5, 1.5
    while misses - returns > 1e-10:
        v = 0.5 * (returns + misses)
        run = ss.simulate(model, belt_speed=v, initial=(1 - 0.05 * v, v), t_end=7.0, contact="slip-")
        returns, misses = (v, misses) if len(run.transitions) else (returns, v)
    assert end.value == pytest.approx(returns, abs=1e-7)


@pytest.fixture(scope="module")
def rig():
    return continuation(RIG, 0.1, span=(0.05, 0.3))


def test_fold_of_the_reference_rig(rig):
    fold = next(one for one in rig.special if one.kind == "fold")
    assert np.abs(fold.cycle.multipliers - 1).min() < 1e-4
    assert rig.values.max() <= fold.value
    assert rig.values[-1] < fold.value - 0.05  # back on the other sheet
    beyond = limit_cycle(RIG, fold.value + 0.005)  # a simulation goes elsewhere
    assert abs(beyond.period - fold.cycle.period) > 0.1


def test_stability_of_the_reference_rig_against_plain_simulations(rig):
    for k in range(5, len(rig), 25):
        start, period = rig.state[k], rig.period[k]
        size = np.abs(rig.multipliers[k]).max()
        if abs(np.log(size)) < 0.02:
            continue
        turns = int(np.ceil(np.log(1e3) / abs(np.log(size))))
        times = np.array([0.0, 1.0, turns, turns + 1]) * period
        run = ss.simulate(
            RIG, belt_speed=rig.values[k], initial=start * (1 + 1e-5), t_end=times[-1], t_eval=times
        )
        change = np.abs(np.diff(run.state, axis=0)).max(axis=1)  # over a period, at first and later
        assert (change[2] < 0.1 * change[0]) == rig.stable[k]


def test_neimark_sacker_points_of_the_reference_rig(rig):
    points = [one for one in rig.special if one.kind == "neimark_sacker"]
    assert len(points) == 2
    for one in points:
        assert np.abs(one.cycle.multipliers[:2]) == pytest.approx([1.0, 1.0], abs=1e-8)
        assert abs(one.cycle.multipliers[0].imag) > 0.1


def test_flips_are_where_a_multiplier_is_minus_one():
    low = RIG.replace(eta1=0.01, eta12=0.02)
    branch = continuation(low, 0.1, span=(0.05, 0.12))
    flips = [one for one in branch.special if one.kind == "flip"]
    assert len(flips) == 2
    for one in flips:
        assert np.abs(one.cycle.multipliers + 1).min() < 1e-6
    inside = (branch.values > flips[0].value) & (branch.values < flips[1].value)
    assert np.ptp(branch.stable[inside].astype(int)) == 0
    assert branch.stable[inside][0] != branch.stable[branch.values < flips[0].value - 1e-6][-1]


def test_neimark_sacker_of_a_weakly_shaken_slider_is_near_the_hopf_point_of_sliding():
    model = DAMPED.with_effects([ss.effect("harmonic_forcing", a=1e-3, w=1.7, phi=0)])
    branch = continuation(model, 1.6, span=(1.45, 1.6))
    (point,) = branch.special
    assert point.kind == "neimark_sacker"
    assert np.abs(point.cycle.multipliers) == pytest.approx([1.0, 1.0], abs=1e-8)
    assert point.value == pytest.approx((np.sqrt(30) - 1) / 3, abs=1e-4)


def test_the_forcing_frequency_can_be_the_parameter():
    branch = continuation(popp_stelter(), 1.0, parameter="effect.w", span=(1.0, 1.2))
    assert branch.parameter == "harmonic_forcing.w"
    assert branch.period == pytest.approx(2 * np.pi / branch.values, rel=1e-11)
    k = int(np.argmin(np.abs(branch.values - 1.12)))
    assert branch.state[k] == pytest.approx(
        limit_cycle(popp_stelter(w=branch.values[k]), 1.0).state, abs=1e-9
    )


def test_a_branch_becomes_a_dataset(leine):
    table = leine.to_xarray()
    assert table.sizes["point"] == len(leine)
    assert float(table["period"][0]) == leine.period[0]
    assert [text.split()[0] for text in table.attrs["special"]] == ["crossing", "loss_of_stick"]


@pytest.mark.parametrize(
    ("speed", "keywords", "message"),
    [
        (0.2, {"span": (0.5, 0.1)}, "span = .*must increase"),
        (0.2, {"span": (0.3, 0.5)}, "belt_speed: the branch starts at 0.2, outside 0.3 to 0.5"),
        (0.2, {"span": (0.1, 0.5), "parameter": "decey"}, "did you mean 'decay'"),
        (0.2, {"span": (0.1, 0.5), "parameter": "initial.x1"}, "unknown parameter of a branch"),
        (None, {"span": (1.0, 5.0), "parameter": "decay"}, "belt_speed: missing"),
        (0.2, {"span": (0.1, float("nan"))}, r"span\[1\] = nan"),
        (0.2, {"span": (0.1, 0.5), "step": 0.0}, "step = 0.0: must be above 0"),
        (0.2, {"span": (0.1, 0.5), "max_points": 0}, "max_points = 0: must be at least 1"),
        (0.2, {"span": (0.1, 0.5), "tol": 0.0}, "tol = 0.0: must be above 0"),
        (0.2, {"span": (0.1, 0.5), "parameter": 3}, "parameter = 3: must be the name"),
    ],
)
def test_bad_input_is_answered_in_one_line(speed, keywords, message):
    with pytest.raises(ss.StickslipError, match=message):
        continuation(LEINE, speed, **keywords)


def test_the_figure_shows_every_point_and_both_stabilities(damped):
    figure = plot_branch(damped, "period")
    (ax,) = figure.axes
    lines = [line for line in ax.lines if line.get_linestyle() != "None"]
    assert {line.get_label() for line in lines} == {"stable", "unstable"}
    marks = [line for line in ax.lines if line.get_linestyle() == "None"]
    assert [float(line.get_xdata()[0]) for line in marks] == [one.value for one in damped.special]
    with pytest.raises(ss.InputError, match="did you mean 'period'"):
        plot_branch(damped, "periode")


@pytest.mark.study
def test_a_closed_branch_is_traced_once():
    """The cycles of a forced slider that go round in the force's amplitude."""
    model = ss.Model(
        ss.BlockOnBelt(damping=0.1),
        friction=ss.HyperbolicFriction(scale=1, decay=3),
        effects=[ss.effect("harmonic_forcing", a=0.5, w=1.3, phi=0.0)],
    )
    branch = ss.continuation(model, 1.0, parameter="harmonic_forcing.a", span=(0.2, 0.8))
    assert branch.ends == ("closed", "closed")
    np.testing.assert_array_equal(branch.state[0], branch.state[-1])
    around = np.diff(branch.values)
    assert (around > 0).any()
    assert (around < 0).any()
    folds = [one.value for one in branch.special if one.kind == "fold"]
    assert len(folds) == len(set(np.round(folds, 6)))  # each once
    figure = plot_branch(branch)
    assert "once a period" in figure.axes[0].get_ylabel()


def test_how_a_branch_ends_is_said(leine, damped):
    assert leine.ends[1] in ("hopf", "special", "span", "no_convergence")
    assert damped.ends[1] == "hopf"
    few = continuation(LEINE, 0.2, span=(0.1, 0.3), max_points=3)
    assert few.ends == ("max_points", "max_points")


@pytest.mark.study
def test_a_forced_branch_goes_on_where_the_strobe_leaves_a_stick():
    """Every point closes by a simulation of its own, also where the instant it is looked at comes to lie in slip."""
    speed = 0.658
    model = ss.Model(
        ss.BlockOnBelt(damping=0.07),
        friction=ss.HyperbolicFriction(scale=1, decay=2.74),
        effects=[ss.effect("harmonic_forcing", a=0.2, w=1.3)],
    )
    branch = ss.continuation(model, speed, span=(0.4, 1.0))
    on_belt = np.isclose(branch.state[:, 1], branch.values, atol=1e-9)
    assert 5 < on_belt.sum() < len(branch) - 5
    assert branch.ends == ("closed", "closed")
    for v, z, period in zip(branch.values, branch.state, branch.period, strict=True):
        end = ss.simulate(model, belt_speed=v, initial=z, t_end=period, t_eval=[period]).state[0]
        assert np.abs(end - z).max() < 1e-7
    assert max(one.cycle.residual for one in branch.special) < 1e-8


@pytest.mark.parametrize(("model", "other"), [(LEINE, RIG), (RIG, LEINE)])
def test_a_cycle_of_another_rig_is_no_guess(model, other):
    guess = limit_cycle(other, 0.1)
    words = (
        f"guess: is a cycle of {', '.join(guess.states)}; the model's states are {model.rig.state_names[0]}, "
    )
    with pytest.raises(ss.InputError, match=words):
        continuation(model, span=(0.05, 0.15), guess=guess)
