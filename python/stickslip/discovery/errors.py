"""The error on runs never fitted: forecasts by cycle, and stick-slip's own measures, before, after and at the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.result import ErrorBlock, RunError
from stickslip.discovery.workers import Workers
from stickslip.errors import StickslipError
from stickslip.fitted.data import Data, read_again, velocity_width
from stickslip.fitted.predict import Forecaster, Prediction, free_run, stitched
from stickslip.fitted.readings import curves_of
from stickslip.measured.case import Recording
from stickslip.measured.sticks import rides

Floats = NDArray[np.float64]
METRIC = "NRMSE of x1 and y1 over forecasts of one cycle, state from the past alone; mean over validate runs"
WHO = ("before", "after", "floor")
DRAWS = 3  # of the floor: what one draw of the noise leaves differs from the next by a tenth and more


@dataclass
class ForecastErrors:
    """What one model makes of one run."""

    one: float
    two: float
    transition: float
    period: float
    fraction: float
    portrait: float
    rmse: tuple[float, float]
    prediction: Prediction
    samples: NDArray[np.int64]
    band: tuple[Floats, Floats] | None = None  # of the readings at the samples


def measure(model: Model, run: Data) -> ForecastErrors:
    """Forecast a run one and two cycles ahead and compare with its readings."""
    forecaster = Forecaster(model, run, 1, curves_of(model))
    try:
        one = stitched(forecaster, 1.0)
    except StickslipError:
        one = _second_half(forecaster)
    try:
        return compared(run, *one, rmse(*stitched(forecaster, 2.0), run))
    except StickslipError:
        return compared(run, *one, None)


def compared(
    run: Data, prediction: Prediction, samples: NDArray[np.int64], two: tuple[float, float] | None
) -> ForecastErrors:
    """
    Return what forecasts of one cycle make of a run.

    Parameters
    ----------
    run : as measured
    prediction, samples : the forecasts, laid end to end
    two : rms errors of x1 and y1 over two cycles, None where the run is too short
    """
    one, v = rmse(prediction, samples, run), as_seen(run, prediction.rate)
    return ForecastErrors(
        relative(one, run),
        float("nan") if two is None else relative(two, run),
        *_events(v, run, samples),
        _portrait(prediction, v, run, samples),
        one,
        prediction,
        samples,
    )


def _second_half(forecaster: Forecaster) -> tuple[Prediction, NDArray[np.int64]]:
    """A run too short for forecasts by cycle: its second half from its first."""
    t = forecaster.run.t
    half = len(t) // 2
    return forecaster.forecast(half, t[half:]), np.arange(half, len(t))


def rmse(prediction: Prediction, samples: NDArray[np.int64], run: Data) -> tuple[float, float]:
    """Return the rms errors of x1 and y1 over the samples forecast."""
    out = []
    for c in range(2):
        good = run.weight[samples, c] > 0
        off = prediction.readings[good, c] - run.readings[samples[good], c]
        out.append(float(np.sqrt(np.mean(off**2))))
    return out[0], out[1]


def relative(rmse: tuple[float, float], run: Data) -> float:
    """Return the rms errors of x1 and y1 over the spread of their readings, the two together."""
    spread = [max(float(np.std(run.readings[:, c])), float(run.noise[c])) for c in range(2)]
    return float(np.sqrt(np.mean([(e / s) ** 2 for e, s in zip(rmse, spread, strict=True)])))


def _onsets(t: Floats, stuck: NDArray[np.bool_]) -> Floats:
    edges = np.flatnonzero(stuck[:-1] & ~stuck[1:])
    times = t[edges]
    return times[np.diff(times, prepend=-np.inf) > 0.5] if len(times) else times


def as_seen(run: Data, v: Floats) -> Floats:
    """Return a model's velocity as the quadratics see one that the run's own is taken from."""
    width = velocity_width(run.t, float(run.noise[0]), run.belt_speed)
    h = width // 2
    weights = 1.0 - (np.arange(-h, h + 1) / (h + 1)) ** 2
    return np.asarray(np.convolve(v, weights, "same") / np.convolve(np.ones_like(v), weights, "same"))


def _events(v: Floats, run: Data, samples: NDArray[np.int64]) -> tuple[float, float, float]:
    """Transition-time error and period error over the cycle, stick fraction's error."""
    t = run.t[samples]
    ours, theirs = rides(v, run.belt_speed), rides(run.v[samples], run.belt_speed)
    a, b = _onsets(t, theirs), _onsets(t, ours)
    if len(a) == 0 or len(b) == 0:
        timing = 0.0 if len(a) == len(b) else 0.5
    else:
        timing = float(np.median([np.min(np.abs(b - one)) for one in a])) / run.cycle
    period = 0.0
    if len(a) > 2 and len(b) > 2:
        period = abs(float(np.median(np.diff(b)) - np.median(np.diff(a)))) / run.cycle
    return timing, period, abs(float(ours.mean() - theirs.mean()))


def _portrait(prediction: Prediction, v: Floats, run: Data, samples: NDArray[np.int64]) -> float:
    """Mean distance from the measured phase portrait (x1, v) to the predicted one, over its size."""
    measured = np.stack([run.readings[samples, 0], run.v[samples]], 1)
    predicted = np.stack([prediction.readings[:, 0], v], 1)
    size = np.maximum(measured.std(axis=0), 1e-12)
    distance, _ = scipy.spatial.cKDTree(predicted / size).query(measured / size)
    return float(np.mean(distance))


def error_block(
    before: Model,
    after: Model,
    runs: Sequence[Data],
    recordings: Sequence[Recording],
    workers: Workers,
    seed: int = 0,
) -> tuple[ErrorBlock, dict[str, tuple[ForecastErrors, ForecastErrors]]]:
    """`error` of the report on the validate runs, and the forecasts it rests on, each made by one of the workers."""
    asked = [("after", 0), *(("floor", seed + i) for i in range(DRAWS))]
    if before != after:
        asked.append(("before", 0))
    tasks = [(who, run, own) for run in runs for who, own in asked]
    done = iter(workers.map(partial(_forecast, before=before, after=after), tasks))
    table, kept = [], {}
    for run, recording in zip(runs, recordings, strict=True):
        now, *others = [next(done) for _ in asked]
        was = others[-1] if before != after else now
        assert was is not None
        assert now is not None
        kept[run.name] = (was, now)
        floor = mean([one for one in others[:DRAWS] if one is not None]) or now
        table.append(row(run, recording, (was, now, floor)))
    return block(METRIC, table), kept


def block(metric: str, table: Sequence[RunError]) -> ErrorBlock:
    """Return the error over all validate runs."""
    mean = {who: float(np.mean([one.one_cycle[who] for one in table])) for who in WHO}
    return ErrorBlock(metric, mean["before"], mean["after"], mean["floor"], tuple(table))


def _forecast(task: tuple[str, Data, int], *, before: Model, after: Model) -> ForecastErrors | None:
    """One of `WHO` on a run; None where the model after cannot make readings of its own."""
    who, run, seed = task
    if who != "floor":
        return measure(before if who == "before" else after, run)
    try:
        own = free_run(Forecaster(after, run, 1, curves_of(after)), seed)
        return measure(after, read_again(run, own.readings))
    except StickslipError:
        return None


def mean(draws: Sequence[ForecastErrors]) -> ForecastErrors | None:
    """Return one with the mean of what these measured; None of none."""
    if not draws:
        return None
    names = ("one", "two", "transition", "period", "fraction", "portrait")
    numbers = {name: float(np.mean([getattr(one, name) for one in draws])) for name in names}
    x1, y1 = np.mean([one.rmse for one in draws], axis=0).tolist()
    return replace(draws[0], **numbers, rmse=(x1, y1))  # type: ignore[arg-type]  # floats by name


def row(
    run: Data, recording: Recording, measured: tuple[ForecastErrors, ForecastErrors, ForecastErrors]
) -> RunError:
    """Return the errors on one run, before, after and at the floor."""

    def each(name: str) -> dict[str, float]:
        return {who: float(getattr(m, name)) for who, m in zip(WHO, measured, strict=True)}

    def timed(name: str) -> dict[str, float]:  # no better than the sampling allows
        found = each(name)
        return {**found, "floor": max(found["floor"], float(np.median(np.diff(run.t))) / run.cycle)}

    rmse = {
        channel: {who: m.rmse[c] / recording.factor(channel) for who, m in zip(WHO, measured, strict=True)}
        for c, channel in enumerate(("x1", "y1"))
    }
    return RunError(
        run.name,
        run.belt_speed,
        each("one"),
        each("two"),
        timed("transition"),
        timed("period"),
        timed("fraction"),
        each("portrait"),
        rmse,
        {channel: recording.unit(channel) for channel in ("x1", "y1")},
    )
