"""Where windows of a rig on a belt begin: in a stick, in a slip, on a contact that yields, on a belt that droops."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from discover_cases import LAW, RIG, make_case
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.hypothesis import Term
from stickslip.discovery.laboratory.search import told_by_sizes
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.discovery.laboratory.verdicts import searched
from stickslip.fitted.data import prepare
from stickslip.likelihoods.begun import lagged
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.event_windows import own_in
from stickslip.likelihoods.fit import begun, fitted, null
from stickslip.likelihoods.stretches import stretches
from stickslip.simulated.states import AT

FAST = (0.6, 0.8, -0.7, -0.9, 0.75)  # the block never sticks
DROOP = ss.effect("belt_load_droop", k=0.002, tau=1.2)
YIELDS = ss.effect("contact_compliance", k=350.0, c=0.5)
LAG, MEMORY = ss.effect("sensor_lag", tau=0.15), ss.effect("friction_memory", tau=0.2)


def bench(case: ss.Case, runs: int = 4) -> BeltBench:
    return bench_of(case, prepare(case.train[:runs]))


def start(windows: BeltWindows, run: int) -> np.ndarray:
    """States in which the windows of a run begin, all numbers at their first."""
    motions = windows.motions(np.array([n.start for n in windows.numbers]), windows.first())
    begun = [motions[i].state[0] for i in windows.by_run[run]]
    return np.array(begun)


def test_what_lags_behind_a_ramp_is_the_time_constant_behind() -> None:
    t = np.linspace(0.0, 20.0, 401)
    ramp = lagged(t, 0.3 * t[:, None], 1.5)[:, 0]
    np.testing.assert_allclose(ramp, 0.3 * (t - 1.5 * (1 - np.exp(-t / 1.5))), atol=1e-9)


def test_a_belt_s_droop_is_that_of_the_load_it_has_carried() -> None:
    """Taken as settled in the stick it was off by twice as much and more."""
    case = make_case((DROOP,), noise=1e-5)
    windows = bench(case).windows((Term(DROOP),))
    run = case.train[1]
    found = start(windows, 1)[:, AT["b"]]
    speed, t = run.belt_speed, np.array([run.t[windows.stretches[i].start] for i in windows.by_run[1]])
    model = ss.Model(RIG, friction=LAW, effects=[DROOP])
    y0 = (np.sign(speed) * 0.1, 0.5 * speed, float(run.y1[0]), 0.0)
    true = np.interp(t, run.t, ss.simulate(
        model, belt_speed=speed, initial=y0, t_end=run.t[-1], t_eval=run.t, rtol=1e-9, atol=1e-10
    ).hidden["b"])  # fmt: skip
    late = t > 6 * DROOP.parameters["tau"]  # how it was before the record is not known
    assert late.sum() > 2
    assert np.abs(found[late] - true[late]).max() < 0.06 * np.abs(true).max()  # a leg's force is held


@pytest.mark.parametrize(
    "term", [YIELDS, None, LAG, MEMORY, DROOP], ids=lambda one: one.name if one else "slips"
)
def test_slopes_are_differences(term: ss.Effect | None) -> None:
    case = make_case(
        () if term is None else (term,), length=60.0, speeds=(0.06, 0.13, 0.1) if term is YIELDS else FAST
    )
    windows = bench(case, 1).windows(() if term is None else (Term(term),))
    at = np.array([n.start for n in windows.numbers])
    own = windows.first()
    block = windows.blocks(at, own)[1]
    assert block is not None
    p, h = len(at), 1e-6
    columns = [*range(p), *range(p, p + windows.begins), p + windows.begins + 3, p + windows.own - 1]
    for j in columns:
        sides = []
        for sign in (1, -1):
            a, o = at.copy(), own.copy()
            if j < p:
                a[j] += sign * h
            else:
                o[1, j - p] += sign * h
            there = windows.blocks(a, o)[1]
            assert there is not None
            sides.append(there[:, :, -1])
        slope = (sides[1] - sides[0]) / (2 * h)
        off = np.abs(slope - block[:, :, j])
        assert np.median(off) <= 2e-3 * np.abs(block[:, :, j]).max() + 1e-3, (j, off.max())
        assert (off < 1e-2 * np.abs(block[:, :, j]).max() + 0.1).mean() > 0.95, j


def test_sticks_are_as_long_as_a_model_has_them() -> None:
    """Where slips end gently readings alone have sticks begin sooner, and static friction that ages older."""
    case = make_case(speeds=(0.15, -0.06, 0.1))
    one = bench(case, 2)
    later = one.timed(null(one.windows(), one.policy)).stretches
    model = ss.Model(RIG, friction=LAW)
    off, wrong = [], []
    for w, was in zip(later, one.stretches, strict=True):
        run = case.train[w.run]
        speed, start = run.belt_speed, float(run.t[w.start])
        y0 = (np.sign(speed) * 0.1, 0.5 * speed, float(run.y1[0]), 0.0)
        found = ss.simulate(model, belt_speed=speed, initial=y0, t_end=start).transitions
        began = start - float(found.t[found.after == 0][-1])
        off.append(w.dwell - began)
        wrong.append(was.dwell - began)
        assert w.dwell < w.rest
    step = float(np.diff(case.train[0].t)[0])
    assert np.median(np.abs(off)) < step
    followed = [i for i, w in enumerate(later) if w.start in {one.stop for one in later if one.run == w.run}]
    assert np.abs(off)[followed].max() < step < np.max(np.array(wrong)[followed])


def test_a_run_that_never_sticks_is_cut_at_its_slips_and_fitted() -> None:
    case = make_case(speeds=FAST, length=60.0)
    cut = stretches(prepare(case.train))
    assert cut
    assert not any(one.stuck for one in cut)
    own = bench(case)
    fit = null(own.windows(), own.policy)
    assert fit.values()["T_min_minus"] == pytest.approx(LAW.T_min_minus, rel=0.02)
    assert np.abs(fit.own[:, len(own.sensors.begins)]).max() > 0.2  # the speed of a start, beyond the belt's
    sticking = make_case(length=60.0)
    assert all(one.stuck for one in stretches(prepare(sticking.train)))


@pytest.mark.study
def test_a_contact_that_yields_is_fitted_with_bristle_and_speed_of_its_own() -> None:
    own = bench(make_case((YIELDS,), length=40.0))
    at = ss.effect("contact_compliance", k=500.0, c=1.0)
    fit = fitted(begun(own.windows((Term(at),))), own.policy)
    values = fit.values()
    assert values["contact_compliance.k"] == pytest.approx(350.0, rel=0.03)
    assert values["contact_compliance.c"] == pytest.approx(0.5, rel=0.3)
    assert max(fit.population.level, fit.population.curve) < 2e-3


@pytest.mark.parametrize(("effect", "state"), [(LAG, "m"), (MEMORY, "w")], ids=["lag", "memory"])
def test_a_window_that_begins_in_a_slip_has_the_hidden_states_of_one(effect: ss.Effect, state: str) -> None:
    """A lag was taken to be behind by as much as in a stick, and friction to remember one."""
    case = make_case((effect,), noise=1e-6, speeds=FAST, length=60.0)
    windows = bench(case).windows((Term(effect),))
    run = case.train[1]
    model = ss.Model(RIG, friction=LAW, effects=[effect])
    y0 = (np.sign(run.belt_speed) * 0.1, 0.5 * run.belt_speed, float(run.y1[0]), 0.0)
    true = ss.simulate(model, belt_speed=run.belt_speed, initial=y0, t_end=run.t[-1], t_eval=run.t)
    slips = [
        i for i in windows.by_run[1][1:] if not windows.stretches[i].stuck
    ]  # before the record is not known
    begun = [windows.stretches[i].start for i in slips]
    own, place = windows.first(), len(windows.sensors.begins)
    for i, k in zip(slips, begun, strict=True):  # all that is read, as it was
        own[i, : place + 1] = [*true.state[k, [0, 2, 3]], true.state[k, 1] - run.belt_speed]
    motions = windows.motions(np.array([n.start for n in windows.numbers]), own)
    found = np.array([motions[i].state[0, AT[state]] for i in slips])
    own[slips, place] = 0.0
    motions = windows.motions(np.array([n.start for n in windows.numbers]), own)
    stuck = np.array([motions[i].state[0, AT[state]] for i in slips])
    true_ones = true.hidden[state][begun]
    assert len(slips) > 3
    assert np.median(np.abs(found - true_ones)) < 0.2 * np.median(np.abs(stuck - true_ones))


def test_own_numbers_go_from_one_hypothesis_to_another() -> None:
    own = bench(make_case(length=40.0))
    stiff, soft = own.windows(), own.windows((Term(YIELDS),))
    numbers = np.random.default_rng(1).standard_normal((len(own.stretches), stiff.own))
    there = own_in(numbers, stiff, soft)
    assert soft.begins == stiff.begins + 2
    assert (there[:, stiff.begins : soft.begins] == 0).all()
    np.testing.assert_array_equal(own_in(there, soft, stiff), numbers)


def test_an_effect_is_worth_what_its_sizes_tell() -> None:
    cubic = ss.effect("spring_cubic_k1", k=4.0)
    for acts, told in (((cubic,), True), ((), False)):
        own = bench(make_case(acts, length=40.0))
        fit = fitted(begun(own.windows((Term(cubic),))), own.policy)
        assert (told_by_sizes(Trial((Term(cubic),), fit)) > 10.0) == told


@pytest.mark.study
def test_no_name_where_nothing_lacks_and_nothing_sticks() -> None:
    """docs/limits.md has how many of fourteen."""
    wrong = 0
    for seed in range(1, 15):
        case = make_case(length=60.0, speeds=FAST, seed=seed)
        found = searched(bench(case), case.uncertainty, lambda _: None, 0)
        wrong += found.curve is not None or bool(found.searched.chosen.names)
    assert wrong == 0
