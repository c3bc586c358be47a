"""The residual against the noise: how large, where it sits, how white, and its spectrum."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.result import Part, Residual
from stickslip.fitted.data import Data
from stickslip.fitted.window import WindowSpan
from stickslip.measured.findings import FINE
from stickslip.measured.signals import quantisation

Floats = NDArray[np.float64]
LAGS = 20
LIMIT = 4.0  # sampling errors above noise at which something is left
NEAR = 4  # samples on either side that belong to a transition
BINS = 120


class WindowResidual(Protocol):
    """What a fit leaves of a window."""

    @property
    def r(self) -> Floats:
        """Residuals over their noise."""
        ...

    @property
    def mode(self) -> NDArray[np.int8]:
        """Mode at each sample."""
        ...


class _Runs(Protocol):
    @property
    def data(self) -> Sequence[Data]: ...


class AnyFit(Protocol):
    """A fit of windows, whichever engine made it."""

    @property
    def engine(self) -> _Runs:
        """Hold the runs."""
        ...

    @property
    def windows(self) -> Sequence[WindowSpan]:
        """Where the windows are."""
        ...

    @property
    def blocks(self) -> Sequence[WindowResidual]:
        """Residuals and modes of each."""
        ...

    @property
    def readings(self) -> int:
        """How many readings there are."""
        ...

    @property
    def dof(self) -> float:
        """How many of them the fit takes."""
        ...

    @property
    def chi2(self) -> float:
        """Their chi-squared."""
        ...

    @property
    def per_reading(self) -> float:
        """chi-squared per reading."""
        ...


@dataclass
class _Residuals:
    """All residuals of a fit, flat: one entry a reading."""

    r: Floats
    channel: NDArray[np.int64]
    mode: NDArray[np.int64]  # -1, 0, 1; 2 onset, 3 capture
    run: NDArray[np.int64]
    third: NDArray[np.int64]


def describe(fit: AnyFit, limit: float = LIMIT) -> Residual:
    """Residual of a fit, in all and in parts, worst first.

    It is clean where neither all readings nor those of a channel leave more than noise does, by `limit` sampling
    errors. Where a noise was taken too large chi-squared hides what is left: a misfit then still goes on from reading
    to reading as white noise does not, whatever its size. Such channels are `correlated`.
    """
    s = _collect(fit)
    dof = max(fit.readings - fit.dof, 1)
    chi2, error = fit.chi2 / dof, math.sqrt(2.0 / dof)
    share = dof / max(fit.readings, 1)
    parts = sorted(_parts(fit, s, share), key=lambda p: -(p.chi2 - 1) / p.error)
    clean = left_over(fit) < limit
    channels = fit.engine.data[0].channels
    alike = [name for name, one in zip(channels, correlation(fit), strict=True) if one > limit]
    said = _sentence(chi2, error, clean, parts)
    return Residual(chi2, error, whiteness(fit), clean, tuple(parts), said, tuple(alike))


def left_over(fit: AnyFit) -> float:
    """chi-squared per reading above 1 in its sampling errors: of all readings, or of the channel that leaves most.

    A channel counts by itself where its noise is declared. One that was read off the readings is no measure so sharp.
    """
    dof = max(fit.readings - fit.dof, 1)
    share, out = dof / max(fit.readings, 1), (fit.per_reading - 1.0) / math.sqrt(2.0 / fit.readings)
    for c, told in enumerate(fit.engine.data[0].declared):
        power, count = _of_channel(fit, c) if told else (0.0, 0)
        if count:
            out = max(out, (power / (count * share) - 1.0) / math.sqrt(2.0 / count))
    return out


def _of_channel(fit: AnyFit, c: int) -> tuple[float, int]:
    """Sum of squares of a channel's residuals over the noise, and how many there are."""
    power, count = 0.0, 0
    for w, b in zip(fit.windows, fit.blocks, strict=True):
        run = fit.engine.data[w.run]
        used = run.weight[w.start : w.stop, c] > 0
        r = b.r.reshape(-1, run.readings.shape[1])[used, c]
        power, count = power + float(r @ r), count + len(r)
    return power, count


def correlation(fit: AnyFit) -> list[float]:
    """By channel, the largest correlation over lags 1 to 20 in its sampling errors: of a misfit it is positive.

    0 for a channel whose noise is no larger than twice its steps: these go on from reading to reading too.
    """
    data = fit.engine.data
    out = []
    for c in range(len(data[0].channels)):
        series = [
            b.r.reshape(-1, data[w.run].readings.shape[1])[:, c]
            for w, b in zip(fit.windows, fit.blocks, strict=True)
        ]
        step = max(quantisation(run.readings[:, c]).step / float(run.noise[c]) for run in data)
        out.append(persistence(series) if step < FINE else 0.0)
    return out


def persistence(series: Iterable[Floats]) -> float:
    """The largest correlation over lags 1 to 20 of several series (n,), in its sampling errors; 0 of short ones."""
    sums, norm, count = np.zeros(LAGS), 0.0, 0
    for r in series:
        if len(r) > 2 * LAGS:
            norm, count = norm + float(r @ r), count + len(r)
            sums += [r[k:] @ r[:-k] for k in range(1, LAGS + 1)]
    return float(sums.max()) / norm * math.sqrt(count) if norm > 0 else 0.0


def _sentence(chi2: float, error: float, clean: bool, parts: list[Part]) -> str:
    if clean:
        return (
            f"chi-squared is {chi2:.3f} per reading (1 +- {error:.3f} is noise alone): nothing is left over"
        )
    worst = [p for p in parts if p.what in ("channel", "mode", "transition")][:2]
    words = " and ".join(f"{p.what} {p.name} ({p.chi2:.3g})" for p in worst)
    return f"chi-squared is {chi2:.4g} per reading where noise alone leaves 1 +- {error:.3f}; most in {words}"


def _collect(fit: AnyFit) -> _Residuals:
    columns: list[list[Floats]] = [[], [], [], [], []]
    for w, b in zip(fit.windows, fit.blocks, strict=True):
        run = fit.engine.data[w.run]
        c = run.readings.shape[1]
        used = (run.weight[w.start : w.stop] > 0).ravel()
        mode = _modes(b.mode)
        third = np.minimum((3 * run.t[w.start : w.stop] / run.t[-1]).astype(int), 2)
        n = w.stop - w.start
        for target, value in zip(
            columns,
            (
                b.r,
                np.tile(np.arange(c), n),
                np.repeat(mode, c),
                np.full(n * c, w.run),
                np.repeat(third, c),
            ),
            strict=True,
        ):
            target.append(np.asarray(value)[used])
    r, *labels = (np.concatenate(one) for one in columns)
    return _Residuals(r, *(one.astype(np.int64) for one in labels))


def _modes(mode: NDArray[np.int8]) -> NDArray[np.int64]:
    out = mode.astype(np.int64)
    for i in np.flatnonzero(np.diff(mode)):
        out[max(0, i - NEAR) : i + NEAR + 1] = 2 if mode[i] == 0 else 3
    return out


def _parts(fit: AnyFit, s: _Residuals, share: float) -> Iterator[Part]:
    channels = fit.engine.data[0].channels
    for c, name in enumerate(channels):
        yield from _part("channel", name, s.r[s.channel == c], share)
    words = {-1: "slip, v_w < 0", 0: "stick", 1: "slip, v_w > 0"}
    for value, name in words.items():
        yield from _part("mode", name, s.r[s.mode == value], share)
    for value, name in {2: "onset of slip", 3: "capture"}.items():
        yield from _part("transition", name, s.r[s.mode == value], share)
    for k, run in enumerate(fit.engine.data):
        yield from _part("speed", f"{run.belt_speed:.4g}", s.r[s.run == k], share)
    for k, name in enumerate(("first third", "middle third", "last third")):
        yield from _part("time", name, s.r[s.third == k], share)


def _part(what: str, name: str, r: Floats, share: float) -> Iterator[Part]:
    if len(r) > 20:
        yield Part(what, name, float(r @ r) / (len(r) * share), math.sqrt(2.0 / len(r)), len(r))


def by_run(fit: AnyFit) -> list[Floats]:
    """Residuals in units of the noise, run by run as its readings are (n, c); NaN where a reading is not used."""
    out = [np.full(run.readings.shape, np.nan) for run in fit.engine.data]
    for w, b in zip(fit.windows, fit.blocks, strict=True):
        unused = fit.engine.data[w.run].weight[w.start : w.stop] == 0
        out[w.run][w.start : w.stop] = np.where(unused, np.nan, b.r.reshape(unused.shape))
    return out


def _series(fit: AnyFit) -> Iterator[Floats]:
    """Residual of each window and channel in time order."""
    for w, b in zip(fit.windows, fit.blocks, strict=True):
        c = fit.engine.data[w.run].readings.shape[1]
        yield from b.r.reshape(-1, c).T


def whiteness(fit: AnyFit) -> float:
    """Largest autocorrelation over lags 1 to 20, over the limit that white noise passes one time in twenty."""
    top, norm, count = np.zeros(LAGS), 0.0, 0
    for r in _series(fit):
        if len(r) <= 2 * LAGS:
            continue
        norm += float(r @ r)
        count += len(r)
        top += np.array([r[k:] @ r[:-k] for k in range(1, LAGS + 1)])
    limit = 3.03 / math.sqrt(max(count, 1))  # normal quantile of 0.05 / 20, two-sided
    return float(np.max(np.abs(top)) / max(norm, 1e-300) / limit)


def spectrum(before: AnyFit, after: AnyFit) -> Mapping[str, Floats]:
    """Mean normalised power of residuals over angular frequency, in even bins of its logarithm; white noise is 1."""
    w, was = _power(before)
    _, now = _power(after)
    filled = np.isfinite(was) & np.isfinite(now)
    return {"frequency": w[filled], "before": was[filled], "after": now[filled]}


def _power(fit: AnyFit) -> tuple[Floats, Floats]:
    data = fit.engine.data
    dt = float(np.median([np.median(np.diff(run.t)) for run in data]))
    edges = np.geomspace(np.pi / max(float(run.t[-1]) for run in data), np.pi / dt, BINS + 1)
    total, count = np.zeros(BINS), np.zeros(BINS)
    for k in range(len(data)):
        parts = [
            b.r.reshape(-1, len(data[k].channels))
            for w, b in zip(fit.windows, fit.blocks, strict=True)
            if w.run == k
        ]
        if not parts:  # no window of it can be simulated
            continue
        r = np.concatenate(parts)
        power = (np.abs(np.fft.rfft(r, axis=0)) ** 2 / len(r)).mean(axis=1)[1:]
        w = 2 * np.pi * np.fft.rfftfreq(len(r), float(np.median(np.diff(data[k].t))))[1:]
        bins = np.clip(np.searchsorted(edges, w) - 1, 0, BINS - 1)
        np.add.at(total, bins, power)
        np.add.at(count, bins, 1)
    mean = np.divide(total, count, out=np.full(BINS, np.nan), where=count > 0)
    return np.sqrt(edges[1:] * edges[:-1]), mean
