"""What carries over: forecasts of runs never fitted, the friction of each event to come as the model lets expect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery import errors
from stickslip.discovery.carry_over import deciding
from stickslip.discovery.errors import ForecastErrors
from stickslip.discovery.result import ErrorBlock, Likelihood, RunError
from stickslip.discovery.workers import Workers
from stickslip.fitted.data import Data
from stickslip.fitted.predict import Prediction, joined
from stickslip.fitted.readings import reading_rate
from stickslip.likelihoods.ahead import KEPT, EnsembleForecast, ahead
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.held_out import Unseen, falls
from stickslip.likelihoods.unseen import likely
from stickslip.measured.case import Recording

Floats = NDArray[np.float64]
Samples = NDArray[np.int64]
METRIC = (
    "NRMSE of x1 and y1 over forecasts of one cycle, state from the past alone and events to come as they scatter; "
    "mean over validate runs"
)


def error_block(
    fits: tuple[Fit, Fit],
    models: tuple[Model, Model],
    runs: Sequence[Data],
    recordings: Sequence[Recording],
    workers: Workers,
    seed: int,
) -> tuple[ErrorBlock, dict[str, tuple[ForecastErrors, ForecastErrors]]]:
    """
    Return `error` of the report, and the forecasts it rests on.

    Its floor is what a model that is right leaves: the friction of the next events, and the noise.

    Parameters
    ----------
    fits, models : before and after
    runs, recordings : never fitted
    workers, seed : make the forecasts
    """
    same = fits[0] is fits[1]
    every = [_light(one) for one in (fits[1:] if same else fits)]
    done = iter(workers.map(partial(_made, seed=seed), [(fit, run) for run in runs for fit in every]))
    table: list[RunError] = []
    kept: dict[str, tuple[ForecastErrors, ForecastErrors]] = {}
    for run, recording in zip(runs, recordings, strict=True):
        made = [one for one in [next(done) for _ in every] if one is not None]
        if len(made) < len(every):  # too few windows to know where the run stands
            part, others = errors.error_block(*models, [run], [recording], workers, seed)
            table.append(part.runs[0])
            kept |= others
            continue
        (was, _), (now, floor) = made[0], made[-1]
        kept[run.name] = (was, now)
        table.append(errors.row(run, recording, (was, now, floor)))
    return replace(errors.block(METRIC, table), covered=_covered(runs, kept)), kept


def likelihood(
    now: Fit,
    without: Fit | None,
    spare: float | None,
    less: Mapping[str, tuple[Fit, float]],
    runs: Sequence[Data],
    workers: Workers,
) -> Likelihood | None:
    """
    Return how likely runs never fitted are with what was found, by their windows.

    Parameters
    ----------
    now, without : the fit with all of it, and with none; None where nothing was found
    spare : by how much what was found passes its gate; None for what has none
    less : the fit without each of several effects, by name, and by how much that one passes its gate
    runs, workers : never fitted; do what does not wait for one another
    """
    if without is None or without is now:
        return None
    every = [_light(one) for one in (now, without, *(fit for fit, _ in less.values()))]
    made = iter(workers.map(_likely, [(fit, run) for run in runs for fit in every]))
    fell: list[list[float]] = [[] for _ in every[1:]]
    for _ in runs:
        own = next(made)
        for one in fell:
            other = next(made)
            one += [] if own is None or other is None else falls(other, own)
    beside = {name: (own, beyond) for own, (name, (_, beyond)) in zip(fell[1:], less.items(), strict=True)}
    return deciding(fell[0], spare, beside)


def _likely(task: tuple[Fit, Data]) -> Unseen | None:
    return likely(*task)


def _light(fit: Fit) -> Fit:
    """A fit without what is of its own runs alone: it is sent elsewhere."""
    return replace(fit, blocks=[], linear=None, solution=None)


def _covered(runs: Sequence[Data], kept: Mapping[str, tuple[ForecastErrors, ForecastErrors]]) -> float | None:
    """Share of the readings that the bands of the model after hold."""
    inside = []
    for run in runs:
        now = kept[run.name][1]
        if now.band is not None:
            low, high = now.band
            read, good = run.readings[now.samples, :2], run.weight[now.samples, :2] > 0
            inside.append(((low <= read) & (read <= high))[good])
    return float(np.mean(np.concatenate(inside))) if inside else None


def _made(task: tuple[Fit, Data], *, seed: int) -> tuple[ForecastErrors, ForecastErrors] | None:
    """What a fit makes of a run, and of what it might itself have been; None where it forecasts nothing."""
    fit, run = task
    short = two = ahead(fit, run, 2.0, seed)
    if not two and not (short := ahead(fit, run, 1.0, seed)):
        return None
    firsts = [_first(one, run) for one in short]
    samples = np.concatenate([np.arange(a, b) for a, b in firsts])
    longer = None
    if two:
        every = np.concatenate([np.arange(one.start, one.stop) for one in two])
        longer = errors.rmse(_expected(two, run, [one.stop for one in two]), every, run)
    stops = [b for _, b in firsts]
    expected = _expected(short, run, stops)
    noise = run.noise * np.sqrt(fit.noise)
    rng = np.random.default_rng(seed)
    sides = [one.band(noise, rng) for one in short]
    low, high = (
        np.concatenate([side[i][: b - a, :2] for side, (a, b) in zip(sides, firsts, strict=True)])
        for i in range(2)
    )
    noise = noise[:2]
    measured = replace(
        errors.compared(run, expected, samples, longer),
        band=(low, high),
    )
    draws = [
        errors.compared(_as(run, _member(short, run, stops, k), samples), expected, samples, None)
        for k in range(1, KEPT)
    ]
    left = errors.mean(draws)
    assert left is not None
    one = _spread(short, stops, noise)
    floor = replace(
        left,
        one=errors.relative(one, run),
        two=errors.relative(_spread(two, [w.stop for w in two], noise), run) if two else float("nan"),
        rmse=one,
    )
    return measured, floor


def _first(one: EnsembleForecast, run: Data) -> tuple[int, int]:
    """The samples of its first cycle."""
    stop = int(np.searchsorted(run.t, run.t[one.start] + run.cycle))
    return one.start, min(max(stop, one.start + 1), one.stop)


def _expected(every: Sequence[EnsembleForecast], run: Data, stops: Sequence[int]) -> Prediction:
    """Forecasts end to end: readings as they are expected, the motion where events have no friction of their own."""
    parts = [_part(one, run, stop, 0) for one, stop in zip(every, stops, strict=True)]
    means = [one.mean[: stop - one.start] for one, stop in zip(every, stops, strict=True)]
    return replace(joined(parts), readings=np.concatenate(means))


def _member(every: Sequence[EnsembleForecast], run: Data, stops: Sequence[int], k: int) -> Prediction:
    """A member, which might have been the run."""
    return joined([_part(one, run, stop, k) for one, stop in zip(every, stops, strict=True)])


def _part(one: EnsembleForecast, run: Data, stop: int, k: int) -> Prediction:
    n = stop - one.start
    t, state = run.t[one.start : stop], one.flown.state[k, :n]
    rate = reading_rate(t, state, one.values, one.beside)
    return Prediction(t, one.flown.readings[k, :n], rate, state, one.flown.mode[k, :n])


def _as(run: Data, member: Prediction, samples: Samples) -> Data:
    """The run as a member might have been it."""
    readings, v = run.readings.copy(), run.v.copy()
    readings[samples], v[samples] = member.readings, errors.as_seen(run, member.rate)
    return replace(run, readings=readings, v=v)


def _spread(every: Sequence[EnsembleForecast], stops: Sequence[int], noise: Floats) -> tuple[float, float]:
    """Rms errors of x1 and y1 that a model which is right has."""
    spread = np.concatenate(
        [one.spread[: stop - one.start, :2] for one, stop in zip(every, stops, strict=True)]
    )
    x1, y1 = np.sqrt(np.mean(spread**2, axis=0) + noise**2).tolist()
    return x1, y1
