"""Errors on runs never fitted, and what the models leave on those that were: the numbers of the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.residual import LIMIT, persistence
from stickslip.discovery.result import WORSE, ErrorBlock, Part, Residual, RunError
from stickslip.discovery.slider.held import Held, constants_of, held
from stickslip.errors import StickslipError
from stickslip.fitted.block_events.predict import BlockForecaster, BlockPrediction, cycle_of, instants
from stickslip.fitted.block_events.table import Measured
from stickslip.measured.case import Case
from stickslip.measured.findings import FINE
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
class Ahead:
    """Forecasts of one cycle from the past alone: samples, predictions, and their errors."""

    samples: NDArray[np.int64]
    predictions: tuple[BlockPrediction, ...]
    nrmse: float
    timing: float


def ahead(model: Model, measured: Measured) -> Ahead:
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
        return Ahead(np.zeros(0, dtype=np.int64), (), NAN, NAN)
    spread = float(np.nanstd(run.x))
    return Ahead(
        np.concatenate(samples),
        tuple(predictions),
        float(np.sqrt(np.mean(errors))) / spread,
        float(np.sqrt(np.mean(np.square(timing)))) / cycle,
    )


def _release_error(one: BlockPrediction, measured: Measured, start: float, cycle: float) -> float:
    """Error of the next breakaway's time, half a cycle where it does not come within the forecast."""
    coming = measured.events.t[measured.events.t > start]
    slid = np.flatnonzero(one.mode != 0)
    if not len(coming) or not len(slid):
        return 0.5 * cycle
    return float(np.clip(one.t[slid[0]] - coming[0], -cycle, cycle))


def nrmse(one: Held, measured: Measured) -> tuple[float, float, float]:
    """Median over events of the error with their own levels over their spread; the noise's; the median spread."""
    run = measured.run
    rows = []
    for i, (a, b) in enumerate(measured.events.window):
        x, r = run.x[a:b], one.residual[i, : b - a]
        good = np.isfinite(x) & np.isfinite(r)
        spread = float(np.std(x[good]))
        rows.append((float(np.sqrt(np.mean(r[good] ** 2))) * run.noise / spread, run.noise / spread, spread))
    if not rows:
        return NAN, NAN, NAN
    error, floor, spread = (float(v) for v in np.median(np.array(rows), axis=0))
    return error, floor, spread


def error_block(
    case: Case,
    before: Model,
    after: Model,
    runs: Sequence[Measured],
    single: Mapping[str, tuple[float, float, float, float]] | None = None,
) -> tuple[ErrorBlock, dict[str, tuple[Ahead, Ahead]], tuple[str, ...]]:
    """
    `error` of the report on the validate runs, the forecasts, and a sentence on them for each run.

    Parameters
    ----------
    case, before, after, runs : two models, and the runs
    single : by run the error of single events before and after, the noise's, and the median spread; in closed form
        where it is not given
    """
    rows, kept, words = [], {}, []
    for one in runs:
        if single is None:
            ours = [held(one, constants_of(model, one)) for model in (before, after)]
            (was, floor, spread), (now, *_) = (nrmse(h, one) for h in ours)
        else:
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
    one: Measured,
    errors: tuple[float, float, float],
    spread: float,
    forecasts: tuple[Ahead, Ahead],
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


def residual(runs: Sequence[Measured], helds: Sequence[Held], numbers: int) -> Residual:
    """What single events with their own levels leave, over the noise of the readings."""
    r = np.concatenate([h.residual[np.isfinite(h.residual)] for h in helds]) if helds else np.zeros(0)
    events = sum(len(h.p) for h in helds)
    dof = max(len(r) - 3 * events - numbers, 1)
    chi2, error = float(r @ r) / dof, float(np.sqrt(2 / dof))
    parts = []
    for one, h in zip(runs, helds, strict=True):
        own = h.residual[np.isfinite(h.residual)]
        if len(own) > 20:
            speed = one.run.sign * one.run.belt_speed
            parts.append(
                Part(
                    "speed",
                    f"{speed:.4g}",
                    float(own @ own) / len(own),
                    float(np.sqrt(2 / len(own))),
                    len(own),
                )
            )
    parts += _by_mode(runs, helds)
    parts.sort(key=lambda p: -(p.chi2 - 1) / p.error)
    clean = chi2 < 1 + LIMIT * error
    words = f"chi-squared is {chi2:.3g} per reading over single events with their own levels (noise: 1 +- {error:.2g})"
    fine = all(one.run.step < FINE * one.run.noise for one in runs)
    alike = fine and persistence(_series(helds)) > LIMIT
    channel = "spring_force" if runs and runs[0].run.force_channel else "x1"
    correlated = (channel,) if alike else ()
    return Residual(chi2, error, _whiteness(helds), clean, tuple(parts), words, correlated)


def _part(what: str, name: str, r: Floats) -> Part:
    return Part(what, name, float(r @ r) / len(r), float(np.sqrt(2 / len(r))), len(r))


def _by_mode(runs: Sequence[Measured], helds: Sequence[Held]) -> list[Part]:
    stick, slip = [], []
    for one, h in zip(runs, helds, strict=True):
        for i, (a, b) in enumerate(one.events.window):
            r, t = h.residual[i, : b - a], one.run.t[a:b]
            sliding = (t > h.p[i, 2]) & (t < h.p[i, 2] + np.pi / np.exp(0.5 * h.p[i, 4]) * 1.5)
            good = np.isfinite(r)
            slip.append(r[good & sliding])
            stick.append(r[good & ~sliding])
    out = []
    for name, parts in (("stick", stick), ("slip", slip)):
        r = np.concatenate(parts) if parts else np.zeros(0)
        if len(r) > 20:
            out.append(_part("mode", name, r))
    return out


def _series(helds: Sequence[Held]) -> Iterator[Floats]:
    """The residual of each event."""
    for h in helds:
        for row in h.residual:
            yield np.nan_to_num(row[: np.count_nonzero(np.isfinite(row))])


def _whiteness(helds: Sequence[Held]) -> float:
    """Largest autocorrelation over lags 1 to 20, over the limit that white noise passes one time in twenty."""
    top, norm, count = np.zeros(20), 0.0, 0
    for r in _series(helds):
        if len(r) > 40:
            norm += float(r @ r)
            count += len(r)
            top += np.array([r[k:] @ r[:-k] for k in range(1, 21)])
    return float(np.max(np.abs(top)) / max(norm, 1e-300) * np.sqrt(max(count, 1)) / 3.03)
