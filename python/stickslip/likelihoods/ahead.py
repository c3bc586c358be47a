"""Forecasts of a run never fitted, from cycle to cycle: the population is known, the past alone says where it stands.

Windows of the run are fitted with what differs between them as the runs of the fit have it (see `unseen`). A phase that
is another in every run is fitted to the windows before a forecast begins, to first order about the whole run.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.data import Data
from stickslip.fitted.readings import Added
from stickslip.likelihoods.band import band
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.members import ComingEvents, Flown, Members
from stickslip.likelihoods.memory import of_effects
from stickslip.likelihoods.mixed import solve
from stickslip.likelihoods.population import factor
from stickslip.likelihoods.stretches import Stretch, stretches, timed
from stickslip.likelihoods.unseen import of_run
from stickslip.simulated.states import X2

Floats = NDArray[np.float64]
DRAWN = 60  # members of an ensemble: its mean is known to an eighth of its spread
KEPT = 4  # members whose states are kept: the one without friction of its own, then those that stand for the truth
FIRST = 3.0  # cycles of the past, at least one


@dataclass(frozen=True)
class EnsembleForecast:
    """
    One forecast.

    Parameters
    ----------
    start, stop : samples that it is for
    values : numbers of the run, by name
    beside : what its channels have beside the effects of the catalogue
    flown : its members over these samples, the first `KEPT` with states: that whose events to come have no friction of
        their own, then others
    """

    start: int
    stop: int
    values: dict[str, float]
    beside: tuple[Added, ...]
    flown: Flown

    @property
    def mean(self) -> Floats:
        """Expected readings, (n, channels)."""
        return np.asarray(self.flown.readings[1:].mean(axis=0))

    def band(self, noise: Floats, rng: np.random.Generator) -> tuple[Floats, Floats]:
        """Return the ends of the band that holds 95 % of the readings to come, (n, channels) each."""
        return band(self.flown.readings[1:], noise, rng)

    @property
    def spread(self) -> Floats:
        """Standard deviation of the readings to come, their noise apart, (n, channels)."""
        return np.asarray(self.flown.readings[1:].std(axis=0, ddof=1))


def ahead(fit: Fit, run: Data, cycles: float, seed: int = 0) -> list[EnsembleForecast]:
    """
    Return forecasts of a run from every cycle on; none where it has no windows, or where nothing can be simulated.

    None begins in a slip that goes on for a window's time after the next stick was due, or is through one in which the
    block passes a place again: friction of its own is that of one event, and is another by then.

    Parameters
    ----------
    fit : of other runs
    run : never fitted
    cycles : that a forecast lasts
    seed : of the draws
    """
    cut = [one for one in stretches([run], fit.windows.policy) if one.stuck]  # where it next sticks is known
    known = of_run(fit, run, cut)
    if known is None:
        return []
    cut = timed(cut, known.windows.motions(known.at, known.own))
    rng = np.random.default_rng(seed)
    rest = float(np.median([one.rest for one in cut]))
    # the runs of the fit tell correlations poorly: every member has some that may be the true ones
    found, like = of_effects(fit, DRAWN + 1, rng)
    out = []
    least, longest = fit.windows.policy.fewest_stuck, max(one.stop - one.start for one in cut)
    for start, stop in _spans(run, cycles, min(one.start for one in cut) + least):
        tail, before = _tail(cut, start, least)
        if tail.stop - tail.start > 2 * longest:
            continue
        at, last = _of_past(known, before)
        windows = known.windows
        assert isinstance(windows, BeltWindows)
        root = factor(fit.population, windows.places)[0]
        events = ComingEvents(
            root,
            like,
            np.zeros((DRAWN + 1, windows.effects)),
            np.ones(DRAWN + 1),
            1,
        )
        members = Members(windows, at, run, events, rest, rng)
        own = members.begun(tail, fit.population, fit.noise, found * last)
        if own is None:
            continue
        flown = members.run(own, tail, stop, KEPT)
        part = slice(start - tail.start, stop - tail.start)
        good = np.array([bool(np.isfinite(one[part]).all()) for one in flown.readings])
        if good[:KEPT].all() and good.sum() > DRAWN // 2 and not _slips_on(flown, run.belt_speed):
            kept = Flown(flown.readings[good][:, part], flown.state[:, part], flown.mode[:, part])
            out.append(EnsembleForecast(start, stop, windows.values(at, 0), windows.beside, kept))
    return out


def _slips_on(flown: Flown, belt_speed: float) -> bool:
    """Whether half of the members whose states are kept, or more, come to pass a place again in one slip."""
    slips, forth = flown.mode != 0, flown.state[:, :, X2] * belt_speed >= 0
    within = slips[:, 1:] & slips[:, :-1]
    back = within & forth[:, :-1] & ~forth[:, 1:]
    each = np.cumsum(~within, axis=1)  # of samples in one slip the same
    again = [np.bincount(number, weights=turned).max() > 1 for number, turned in zip(each, back, strict=True)]
    return bool(2 * sum(again) >= len(again))


def _spans(run: Data, cycles: float, known: int) -> Iterator[tuple[int, int]]:
    """Samples start to stop of the forecasts, one a cycle; the first when the sample `known` of a window is past."""
    first = max(1.0, min(FIRST, float(run.t[-1] - run.t[0]) / run.cycle - cycles - 1.0))
    at = max(float(run.t[0]) + first * run.cycle, float(run.t[min(known, len(run.t) - 1)]))
    while at + cycles * run.cycle <= run.t[-1] + 1e-9:
        start, stop = np.searchsorted(run.t, [at, at + cycles * run.cycle])
        if stop > start:
            yield int(start), int(stop)
        at += run.cycle


def _tail(cut: Sequence[Stretch], start: int, least: int) -> tuple[Stretch, int]:
    """The window that a forecast begins in, up to its first sample, and how many windows lie before it."""
    every = list(cut)
    for one, other in zip(cut, [*cut[1:], None], strict=True):
        if other is None or other.start > one.stop:
            every.append(replace(one, start=one.stop, stop=one.stop))
    every.sort(key=lambda one: one.start)
    begun = [one for one in every if one.start + least <= start]
    return replace(begun[-1], stop=start), sum(one.stop <= begun[-1].start for one in cut)


def _of_past(known: Fit, before: int) -> tuple[Floats, Floats]:
    """Shared numbers as the windows before a forecast have them, and the random effects of the last of those."""
    last = known.random[before - 1] if before else np.zeros(known.windows.effects)
    if known.linear is None or before == 0:
        return known.at, last
    weight = np.where(np.arange(len(known.own)) < before, known.linear.weight, 0.0)
    roots = factor(known.population, known.windows.places)
    prior = known.windows.prior.at(known.at)
    linear, bounds = replace(known.linear, weight=weight), known.windows.steps(known.at)
    found = solve(linear, roots, known.noise, *prior, known.random, bounds=bounds)
    return known.at + found.shared, found.effects[before - 1]
