"""Single events of runs never fitted, each with friction of its own as it scatters: what a hypothesis leaves.

What friction the next event has nobody can know; what it does between breakaway and arrest a model can.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.trials import Trial
from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit import ALONE
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.population import Population
from stickslip.likelihoods.shown_levels import shown_levels
from stickslip.likelihoods.single_windows import settled
from stickslip.likelihoods.stretches import stretches
from stickslip.likelihoods.unseen import PHASES

Floats = NDArray[np.float64]
LATE = (0.0, 0.05, -0.05)  # static levels that an event is fitted from


@dataclass(frozen=True)
class Single:
    """
    Single events of one run.

    Parameters
    ----------
    error, floor : rms error, and noise, over the standard deviation of the readings in the event; median over events
    spread : that deviation, in the unit of the readings
    """

    error: float
    floor: float
    spread: float


NOWHERE = Single(math.nan, math.nan, math.nan)  # of a run without any


def single(bench: BeltBench, trial: Trial, run: Data, population: Population) -> Single:
    """
    Return what a hypothesis leaves of a run's single events; NaN where there are none.

    Parameters
    ----------
    bench, trial : the hypothesis
    run : never fitted
    population : how friction scatters, the same for all hypotheses: what one lacks is no scatter
    """
    there = replace(bench, data=[run], stretches=stretches([run], bench.policy))
    if not there.stretches:
        return NOWHERE
    phases = np.arange(PHASES) * 2 * math.pi / PHASES if any(one.phases for one in trial.terms) else [0.0]
    tried = [_settled(there, trial, population, float(phase)) for phase in phases]
    chi, _ = min(tried, key=lambda one: float(np.sum(one[1])))
    parts = [slice(s.start, s.stop) for s in there.stretches]
    used = [run.weight[part, 0] > 0 for part in parts]
    spread = np.array([np.std(run.readings[part, 0][good]) for part, good in zip(parts, used, strict=True)])
    error = np.sqrt(chi / [max(good.sum(), 1) for good in used])
    noise = float(run.noise[0])
    return Single(
        float(np.median(error * noise / spread)), float(np.median(noise / spread)), float(np.median(spread))
    )


def _settled(bench: BeltBench, trial: Trial, population: Population, phase: float) -> tuple[Floats, Floats]:
    """Chi-squared of each event and its cost with the scatter's, (w,) each, at its best own numbers."""
    windows = bench.windows([replace(one, phases=(phase,) if one.phases else ()) for one in trial.terms])
    at, count = _numbers(windows, trial), len(bench.stretches)
    best = np.full(count, np.inf), np.full(count, np.inf)
    starts = [windows.first() for _ in LATE]
    for own, late in zip(starts, LATE, strict=True):
        own[:, windows.begins] = late
    shown = shown_levels(windows, at)
    for own in starts if shown is None else [*starts, shown]:
        start = Fit(windows, at, own, population, np.ones(windows.channels), np.full(count, np.inf))
        _, chi, cost = settled(start, ALONE)
        better = cost < best[1]
        best = np.where(better, chi, best[0]), np.where(better, cost, best[1])
    return best


def _numbers(windows: BeltWindows, trial: Trial) -> Floats:
    """Shared numbers as a hypothesis has them; a phase as given, a constant that it has exactly as declared."""
    known = {n.name: float(x) for n, x in zip(trial.fit.windows.numbers, trial.fit.at, strict=True)}
    return np.array([n.start if n.run is not None else known.get(n.name, n.start) for n in windows.numbers])
