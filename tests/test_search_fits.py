"""Which candidates of a search are fitted in full and anew, from where, and beside what they are held."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from discover_cases import spring_bench
from stickslip.discovery.laboratory import search as searching
from stickslip.discovery.laboratory import trials, verdicts
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.hypothesis import often, term
from stickslip.discovery.laboratory.null import Null
from stickslip.discovery.laboratory.screen import Candidate, Screen
from stickslip.discovery.laboratory.search import Searched, told_by_sizes
from stickslip.discovery.laboratory.trials import Trial, all_full
from stickslip.discovery.laboratory.waves import Waves, waves_at
from stickslip.discovery.workers import ALONE
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import LOST, Cost, Fit
from stickslip.likelihoods.single_windows import polished

W = 2.3


@pytest.fixture(scope="module")
def bench() -> BeltBench:
    return spring_bench()


@pytest.fixture(scope="module")
def fit(bench: BeltBench) -> Fit:
    return null(bench.windows(), bench.policy)


@pytest.mark.parametrize(
    ("gain", "model", "times"), [(-50.0, True, 0), (-50.0, False, 2), (50.0, True, 2), (50.0, False, 2)]
)
def test_only_what_is_worth_nothing_beside_a_model_of_the_windows_is_fitted_once(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, gain: float, model: bool, times: int
) -> None:
    (kind,) = [one for one in bench.kinds() if one.name == "spring_cubic_k1"]
    one = Trial((term(kind, {"k": 4.0}),), replace(fit, deviance=fit.deviance - gain))
    starts: list[Fit] = []
    monkeypatch.setattr(trials, "explained", lambda _: model)
    monkeypatch.setattr(trials, "anew", lambda _, start: starts.append(start))
    assert trials.leader_anew(bench, Trial((), fit), [one]) == [one]
    assert len(starts) == times


@pytest.mark.parametrize(
    ("ends", "times"), [((3.0, 0.0), 1), ((-3.0, 0.0), 1), ((400.0, 0.0), 2), ((-400.0, -500.0), 2)]
)
def test_where_two_fits_of_the_best_end_alike_no_third_is_asked_for(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, ends: tuple[float, float], times: int
) -> None:
    (kind,) = [one for one in bench.kinds() if one.name == "spring_cubic_k1"]
    spring = term(kind, {"k": 4.0})
    windows = bench.windows((spring,))
    at = np.array([*fit.at, *(n.start for n in windows.numbers[len(fit.at) :])])
    near = replace(fit, windows=windows, at=at, deviance=fit.deviance - 50.0)
    found: list[float] = []

    def anew(_: BeltBench, start: Fit) -> Fit:
        found.append(near.deviance + ends[len(found)])
        return replace(start, deviance=found[-1], own=near.own)

    monkeypatch.setattr(trials, "anew", anew)
    monkeypatch.setattr(trials, "remembered", lambda _: 0.0)
    (best,) = trials.leader_anew(bench, Trial((), fit), [Trial((spring,), near)])
    assert len(found) == times
    assert best.deviance == min(near.deviance, *found)


@pytest.mark.parametrize(
    ("reached", "gain", "again"),
    [
        (1000.0, 150.0, []),  # no promise beyond what the best, fitted anew, has
        (110.0, 150.0, ["pivot_dry_friction"]),
        (55.0, 62.0, []),  # as much as it promised, next to
    ],
)
def test_what_comes_furthest_from_a_null_that_is_far_off_is_fitted_anew_before_the_others(
    bench: BeltBench,
    fit: Fit,
    monkeypatch: pytest.MonkeyPatch,
    reached: float,
    gain: float,
    again: list[str],
) -> None:
    kinds = {one.name: one for one in bench.kinds()}
    step = np.zeros(len(fit.at))
    spring = Candidate(term(kinds["spring_cubic_k1"], {"k": 4.0}), 200.0, 1, step)
    pivot = Candidate(term(kinds["pivot_dry_friction"], {"f": 0.1, "v_c": 0.0}), gain, 1, step)
    near = {"spring_cubic_k1": 52.0, "pivot_dry_friction": 50.0}
    asked: list[str] = []

    def of(start: Fit) -> str:
        names = {n.name.rpartition(".")[0] for n in start.windows.numbers}
        return next(name for name in near if name in names)

    def anew(_: BeltBench, start: Fit) -> Fit:
        if asked[-1:] != [of(start)]:
            asked.append(of(start))
        return replace(start, deviance=fit.deviance - reached)

    monkeypatch.setattr(trials, "explained", lambda _: False)
    monkeypatch.setattr(trials, "anew", anew)
    monkeypatch.setattr(
        trials, "from_near", lambda _, start: replace(start, deviance=fit.deviance - near[of(start)])
    )
    _, done = all_full(bench, Trial((), fit), [spring, pivot], ALONE)
    assert asked == list(done) == ["spring_cubic_k1", *again]
    # what comes less far than what was fitted before, and promises no more, is not fitted anew
    modest = [replace(spring, gain=55.0), replace(pivot, gain=55.0)]
    for best, first in ((60.0, []), (40.0, ["spring_cubic_k1"])):
        before = Trial((), replace(fit, deviance=fit.deviance - best))
        assert [*all_full(bench, Trial((), fit), modest, ALONE, [before])[1]] == first


@pytest.mark.parametrize(
    ("ends", "tried"),
    [
        (((30.0, 8),), 1),  # above the hypothesis that it contains, but it settled
        (((30.0, 16), (-20.0, 16)), 2),  # its steps ran out there: another start
        (((30.0, 16), (None, 0), (40.0, 16)), 3),
        (((-5.0, 16),), 1),
    ],
)
def test_a_fit_whose_steps_ran_out_above_the_hypothesis_is_begun_elsewhere(
    bench: BeltBench,
    fit: Fit,
    monkeypatch: pytest.MonkeyPatch,
    ends: tuple[tuple[float | None, int], ...],
    tried: int,
) -> None:
    """A curve that acts ended at 11,034 from its best start, 8,238 without it, and at 5,619 from the next."""
    (kind,) = [one for one in bench.kinds() if one.name == "spring_cubic_k1"]
    spring = Candidate(term(kind, {"k": 4.0}), 50.0, 1, np.zeros(len(fit.at)))
    made: list[Fit | None] = []

    def from_near(_: BeltBench, start: Fit) -> Fit | None:
        off, steps = ends[len(made)]
        made.append(None if off is None else replace(start, deviance=fit.deviance + off, steps=steps))
        return made[-1]

    monkeypatch.setattr(trials, "explained", lambda _: True)
    monkeypatch.setattr(trials, "from_near", from_near)
    monkeypatch.setattr(trials, "anew", lambda *_: None)
    (one,), _ = all_full(bench, Trial((), fit), [spring], ALONE)
    assert len(made) == tried
    assert one.fit.deviance == min(each.deviance for each in made if each is not None)


@pytest.mark.parametrize(
    ("times", "usual", "names"),
    [
        (1.9, True, ["spring_cubic_k1"]),
        (2.1, True, ["harmonic_forcing", "spring_cubic_k1"]),
        (1.9, False, ["harmonic_forcing", "spring_cubic_k1"]),
    ],
)
def test_a_wave_that_its_own_gate_cannot_let_pass_is_not_fitted(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, times: float, usual: bool, names: list[str]
) -> None:
    """That gate asks its score for its price twice, where the null is a model of the windows."""
    kinds = {one.name: one for one in bench.kinds()}
    step = np.zeros(len(fit.at))
    wave = Candidate(term(kinds["harmonic_forcing"], {"a": 0.1, "w": W, "phi": 0.0}), 0.0, 7, step)
    wave = replace(wave, gain=times * wave.price(len(bench.stretches)))
    spring = Candidate(term(kinds["spring_cubic_k1"], {"k": 4.0}), 10.0, 1, step)
    monkeypatch.setattr(searching, "is_usual", lambda _: usual)
    worthy = searching.worth_fitting(bench, Trial((), fit), Screen((wave, spring), ()))
    assert [one.term.name for one in worthy] == names


@pytest.mark.parametrize(("large", "again"), [(0.01, ()), (100.0, ("harmonic_forcing",))])
def test_what_scatter_has_of_a_wave_is_no_promise(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, large: float, again: tuple[str, ...]
) -> None:
    """One no larger than the waves that scatter is made of may fall short of its score: nothing was promised."""
    (kind,) = [one for one in bench.kinds() if one.name == "harmonic_forcing"]
    small = term(kind, {"a": 1.0, "w": W, "phi": 0.0})
    size = large * bench.scattered(fit, small)
    wave = Candidate(replace(small, effect=small.effect.replace(a=size)), 200.0, 7, np.zeros(len(fit.at)))
    anew: list[Fit] = []
    monkeypatch.setattr(trials, "explained", lambda _: True)
    monkeypatch.setattr(trials, "anew", lambda _, start: anew.append(start))
    monkeypatch.setattr(trials, "from_near", lambda _, start: replace(start, deviance=fit.deviance - 50.0))
    assert all_full(bench, Trial((), fit), [wave], ALONE)[1] == again
    assert bool(anew) == bool(again)


def test_a_wave_is_held_against_the_null_as_it_stands_best(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it gains beyond its amplitude's worth is no finding, of any null: of one that was left behind it is more."""
    (kind,) = [one for one in bench.kinds() if one.name == "harmonic_forcing"]
    wave = term(kind, {"a": 0.1, "w": W, "phi": 0.0})
    windows = bench.windows((wave,))
    at = np.array([*fit.at, *(n.start for n in windows.numbers[len(fit.at) :])])
    found = replace(fit, windows=windows, at=at, deviance=fit.deviance - 2000.0)
    left, best = (Trial((), replace(fit, deviance=fit.deviance + more)) for more in (5000.0, 0.0))
    monkeypatch.setattr(trials, "remembered", lambda _: 0.0)
    first = trials.trial_beside(bench, left, found, wave)
    (again,) = trials.held_against(bench, best, [first])
    told = 7000.0 - first.known
    assert 0 < told < 2000
    assert again.known == pytest.approx(2000.0 - told)
    price = again.numbers() * np.log(len(fit.own))
    assert again.over(best) == pytest.approx(told - price) == first.over(left)


def test_a_window_that_cannot_be_simulated_is_never_the_better_one(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What fails counts as a hundred times the noise: one that is farther off than that must not be given up for it."""
    windows = bench.windows()
    own = windows.first()
    own[:, windows.begins + np.array(windows.statics)] += 0.9  # it breaks away far too late
    far = replace(fit, windows=windows, own=own, knee=np.full(len(own), np.inf))
    simulated = type(windows).blocks

    def fails(self: BeltWindows, at: np.ndarray, given: np.ndarray, *rest: Any, **asked: Any) -> list[Any]:
        made = simulated(self, at, given, *rest, **asked)
        return [one if (now == was).all() else None for one, now, was in zip(made, given, own, strict=True)]

    cost = Cost(far, far.population, np.ones(windows.channels))
    here = windows.blocks(far.at, own, shared=(), local=False)
    assert (cost.of(here, own)[0] > LOST * windows.sizes).any()
    monkeypatch.setattr(type(windows), "blocks", fails)
    every = np.ones(len(own), dtype=bool)
    np.testing.assert_array_equal(polished(far, cost, own, every, 5), own)


@pytest.mark.parametrize(("times", "held"), [(2.5, False), (4.0, True)])
def test_the_model_before_is_as_declared_where_what_lacks_drives_its_constants_far_off(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, times: float, held: bool
) -> None:
    (kind,) = [one for one in bench.kinds() if one.name == "spring_cubic_k1"]
    at, names = bench.windows().prior.centre.copy(), [one.name for one in fit.windows.numbers]
    sd = float(np.sqrt(np.diag(bench.declared.covariance))[bench.declared.names.index("alpha1")])
    at[names.index("alpha1")] += times * sd
    away = Trial((), replace(fit, at=at))
    monkeypatch.setattr(verdicts, "null", lambda windows, *_, **__: replace(fit, windows=windows))
    said = verdicts.Verdicts(bench, Searched(away, Trial((term(kind, {"k": 4.0}),), fit)), None, fit)
    assert fit.windows.prior.farthest(at) == pytest.approx(times)
    if held:
        assert "alpha1" not in [one.name for one in said.before().fit.windows.numbers]
    else:
        assert said.before() is away


def test_a_size_at_its_bound_is_not_told(bench: BeltBench, fit: Fit) -> None:
    """
    A ripple of a drive's speed by 100 % of it, as large as it may be, was named: it stood in for what acted.

    One slower than any that is sought was named with the slowest frequency, and an interval of a ten-thousandth.
    """
    (kind,) = [one for one in bench.kinds() if one.name == "belt_speed_ripple"]
    slowest, fastest = often(kind, bench.policy)
    sizes = ((0.9, True), (1.0, False), (-1.0, False))
    for size, w, told in (*((a, 3.0, so) for a, so in sizes), (0.1, slowest, False), (0.1, fastest, False)):
        one = term(kind, {"a": size, "w": w, "phi": 0.0})
        windows = bench.windows((one,))
        at = np.array([*fit.at, *(n.start for n in windows.numbers[len(fit.at) :])])
        assert fit.solution is not None
        known = replace(fit.solution, covariance=1e-6 * np.eye(len(at)))
        there = replace(fit, windows=windows, at=at, solution=known)
        assert math.isfinite(told_by_sizes(Trial((one,), there))) == told


@pytest.mark.parametrize("name", ["harmonic_forcing", "belt_speed_ripple", "belt_seam"])
def test_frequencies_at_once_are_what_each_is_alone(bench: BeltBench, fit: Fit, name: str) -> None:
    (kind,) = [one for one in bench.kinds() if one.name == name]
    every = [0.5, 1.3, 3.0]
    together = waves_at(bench, fit, (), kind, every)
    assert [one.w for one in together] == every
    for w, one in zip(every, together, strict=True):
        for a, b in zip(one.columns, waves_at(bench, fit, (), kind, [w])[0].columns, strict=True):
            np.testing.assert_array_equal(a, b)


def test_a_wave_along_a_way_that_hardly_goes_is_sought_where_it_is(bench: BeltBench, fit: Fit) -> None:
    """None of its frequencies was left, and the search of a wheel that turns by a few degrees ended in a traceback."""
    (kind,) = [one for one in bench.kinds() if one.name == "belt_seam"]
    waves = Waves(bench, kind, waves_at(bench, fit, (), kind, [3.0]))
    waves.apart, waves.step = 1e4, 1e5
    assert waves.best(Null(fit)) == 3.0
