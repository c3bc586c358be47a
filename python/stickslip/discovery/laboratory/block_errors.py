"""Errors of a block on a belt on runs never fitted: single events, and forecasts of a cycle from the past alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.result import WORSE, ErrorBlock, RunError
from stickslip.errors import StickslipError
from stickslip.fitted.block_events.predict import BlockForecaster, BlockPrediction, cycle_of, instants
from stickslip.fitted.block_events.table import MeasuredBlock
from stickslip.measured.case import Case
from stickslip.measured.stick_speed import why_idle

Floats = NDArray[np.float64]
METRIC = (
    "single events with friction of their own: rms error over the standard deviation of the readings "
    "in the event; median over events, mean over runs"
)
FORECASTS = 60  # a run
POINTS = 160  # readings of a forecast
NAN = float("nan")


@dataclass(frozen=True)
class BlockForecasts:
    """Forecasts of one cycle from the past alone: samples, predictions, and their errors."""

    samples: NDArray[np.int64]
    predictions: tuple[BlockPrediction, ...]
    nrmse: float
    timing: float


def ahead(model: Model, measured: MeasuredBlock) -> BlockForecasts:
    """Forecast one cycle from the middle of up to 60 sticks."""
    cycle = cycle_of(measured)
    forecaster, run = BlockForecaster(model, measured), measured.run
    dt = float(np.median(np.diff(run.t)))
    samples, predictions, errors, timing = [], [], [], []
    for stop in instants(measured, cycle, FORECASTS):
        at = np.unique(np.linspace(stop, stop + max(int(cycle / dt), 2) - 1, POINTS).astype(np.int64))
        at = at[at < len(run.t)]
        try:
            one = forecaster.forecast(stop, run.t[at])
        except StickslipError:
            continue
        samples.append(at)
        predictions.append(one)
        off = one.reading - run.x[at]
        errors.append(float(np.nanmean(off**2)))
        timing.append(_release_error(one, measured, float(run.t[stop - 1]), cycle))
    if not errors:
        return BlockForecasts(np.zeros(0, dtype=np.int64), (), NAN, NAN)
    spread = float(np.nanstd(run.x))
    return BlockForecasts(
        np.concatenate(samples),
        tuple(predictions),
        float(np.sqrt(np.mean(errors))) / spread,
        float(np.sqrt(np.mean(np.square(timing)))) / cycle,
    )


def _release_error(one: BlockPrediction, measured: MeasuredBlock, start: float, cycle: float) -> float:
    """Error of the next breakaway's time, half a cycle where it does not come within the forecast."""
    coming = measured.events.t[measured.events.t > start]
    slid = np.flatnonzero(one.mode != 0)
    if not len(coming) or not len(slid):
        return 0.5 * cycle
    return float(np.clip(one.t[slid[0]] - coming[0], -cycle, cycle))


def error_block(
    case: Case,
    before: Model,
    after: Model,
    runs: Sequence[MeasuredBlock],
    single: Mapping[str, tuple[float, float, float, float]],
) -> tuple[ErrorBlock, dict[str, tuple[BlockForecasts, BlockForecasts]], tuple[str, ...]]:
    """
    `error` of the report on the validate runs, the forecasts, and a sentence on them for each run.

    Parameters
    ----------
    case, before, after, runs : two models, and the runs
    single : by run the error of single events before and after, the noise's, and the median spread
    """
    rows, kept, words = [], {}, []
    for one in runs:
        was, now, floor, spread = single[one.run.name]
        forecasts = (ahead(before, one), ahead(after, one))
        kept[one.run.name] = forecasts
        rows.append(_row(case, one, (was, now, floor), spread, forecasts))
        if not len(one.events) and not np.isfinite(was):
            words.append(
                f"{one.run.name}: no error is measured on it, as no slip is found: "
                + why_idle(case.run(one.run.name), len(one.run.track.sticks))
            )
            continue
        if now > WORSE * was:
            words.append(
                f"{one.run.name}: the error of single events RISES from {was:.3g} to {now:.3g}: what was found does "
                "not carry over to this run"
            )
        off, then = (made.nrmse for made in forecasts)
        words.append(
            f"{one.run.name}: forecasts of one cycle from the past alone are off by {off:.2f} of the readings' "
            f"standard deviation before and {then:.2f} after: what the next event's friction will be is not in the past"
            if np.isfinite([off, then]).all()
            else f"{one.run.name}: no forecast of one cycle from the past alone can be made"
        )
    good = [row.one_cycle for row in rows if np.isfinite(row.one_cycle["before"])]
    mean = {
        who: float(np.mean([one[who] for one in good])) if good else NAN
        for who in ("before", "after", "floor")
    }
    return ErrorBlock(METRIC, mean["before"], mean["after"], mean["floor"], tuple(rows)), kept, tuple(words)


def _row(
    case: Case,
    one: MeasuredBlock,
    errors: tuple[float, float, float],
    spread: float,
    forecasts: tuple[BlockForecasts, BlockForecasts],
) -> RunError:
    recording = case.run(one.run.name)

    def each(before: float, after: float, floor: float = NAN) -> Mapping[str, float]:
        return {"before": before, "after": after, "floor": floor}

    spread /= abs(recording.factor("x1"))
    return RunError(
        run=one.run.name,
        belt_speed=one.run.sign * one.run.belt_speed,
        one_cycle=each(*errors),
        two_cycles=each(NAN, NAN),
        transition_time=each(forecasts[0].timing, forecasts[1].timing),
        period=each(NAN, NAN),
        stick_fraction=each(NAN, NAN),
        portrait=each(NAN, NAN),
        rmse={"x1": each(*(spread * e for e in errors))},
        unit={"x1": recording.unit("x1")},
    )
