"""Recordings as the fit takes them: readings by channel with their weights, cycles, and where windows may start."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.rig import AnyRig, BlockOnBelt
from stickslip.errors import InputError
from stickslip.measured import signals
from stickslip.measured.case import Recording
from stickslip.measured.fit_window import half_apart
from stickslip.measured.repeats import held, held_sentence
from stickslip.measured.sticks import velocity_noise

Floats = NDArray[np.float64]
CHANNELS = ("x1", "y1", "belt")
COPIED = 50  # values in a row that two records share by no chance
MOST_OUTLIERS = 0.05  # share of a channel in a run: more that stands out is motion
SLIP = 0.5  # speed against a belt over the belt's, below which a block creeps
SURE_SLIP = 6.0  # standard deviations of a velocity that no noise reaches in a million samples
OUTLIER_SIGMAS = 5.5  # above what white noise does in a million samples


@dataclass(frozen=True)
class Data:
    """One run for fitting, in model units.

    Attributes
    ----------
    name, role, belt_speed
    t : (n,) times from the run's first sample.
    readings : (n, c) channels x1, y1 and, where recorded, belt; x1 alone of a block on a belt; 0 where missing.
    weight : (n, c) 1/noise; 0 where a reading is missing or a glitch.
    noise : (c,) standard deviations.
    v : (n,) smoothed velocity of x1.
    slips : (k,) samples of fastest slip, one a cycle: far from any transition.
    cycle : time from slip to slip; a natural period where there are none.
    held : (n, c) readings that only repeat the one before.
    declared : (c,) whether a channel's noise is the declared one; else it is as the readings scatter.
    half : what readings that are means are simulated at on either side of their times; 0 of single readings.
    constants : of the rig, in model units, that this run has for itself; taken as exact.
    """

    name: str
    role: str
    belt_speed: float
    t: Floats
    readings: Floats
    weight: Floats
    noise: Floats
    v: Floats
    slips: NDArray[np.int64]
    cycle: float
    held: NDArray[np.bool_]
    declared: tuple[bool, ...] = ()
    half: float = 0.0
    constants: Mapping[str, float] = field(default_factory=dict)
    _states: dict[tuple[int, bool], Floats] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the columns of `readings`."""
        return CHANNELS[: self.readings.shape[1]]

    def local_state(self, at: int, past_only: bool = False) -> Floats:
        """(x1, x2, y1, y2) at sample `at`, by local polynomials through the readings around it; kept, do not change."""
        if (at, past_only) not in self._states:
            self._states[at, past_only] = self._local_state(at, past_only)
        return self._states[at, past_only]

    def _local_state(self, at: int, past_only: bool) -> Floats:
        dt = float(np.median(np.diff(self.t)))
        x = _local(self.t, self.readings[:, 0], self.weight[:, 0], at, max(6, int(0.3 / dt)), past_only)
        if self.readings.shape[1] == 1:
            return np.array([*x, 0.0, 0.0])
        y = _local(self.t, self.readings[:, 1], self.weight[:, 1], at, max(8, int(0.7 / dt)), past_only)
        return np.array([*x, *y])


def prepare(runs: Sequence[Recording]) -> list[Data]:
    """Runs with their noise, from [noise] where it is given and from the readings where not.

    Raises
    ------
    InputError
        A run lacks a channel or is too short to hold a cycle.
    """
    return [_prepare(run, noise) for run, noise in zip(runs, _noise(runs), strict=True)]


def _noise(runs: Sequence[Recording]) -> Floats:
    """Noise of each run by channel (r, c); that of a mean falls with the root of how many it is of."""
    channels: Sequence[str] = CHANNELS if all(run.belt is not None for run in runs) else CHANNELS[:2]
    if all(isinstance(run.rig, BlockOnBelt) for run in runs):
        channels = CHANNELS[:1]
    root = np.sqrt([run.averaged for run in runs])
    found = []
    for channel in channels:
        given = [run.noise[channel] for run in runs if channel in run.noise]
        if given:
            found.append([run.noise.get(channel, given[0]) for run in runs])
        else:
            single = [size * _estimated(run, channel) for run, size in zip(runs, root, strict=True)]
            found.append(list(float(np.median(single)) / root))
    return np.array(found).T


def rounding(readings: Floats) -> Floats:
    """Standard deviation that quantisation adds to the noise of readings (n, c): its step over root 12, (c,)."""
    return np.array([signals.quantisation(one[np.isfinite(one)]).step for one in readings.T]) / math.sqrt(12)


def _estimated(run: Recording, channel: str) -> float:
    values = np.asarray(getattr(run, channel))
    good = np.isfinite(values)
    return float(signals.noise_std(values[good], t=run.t[good]))


def _prepare(run: Recording, noise: Floats) -> Data:
    if run.y1 is None and len(noise) > 1:
        raise InputError(f"run '{run.name}' has no channel y1; discovery needs both displacements")
    if len(run.t) < 60:
        raise InputError(f"run '{run.name}' has {len(run.t)} samples; at least 60 are needed")
    columns = [run.x1, run.y1, run.belt][: len(noise)]
    readings = np.column_stack([np.asarray(column, dtype=np.float64) for column in columns])
    noise = np.hypot(noise, rounding(readings))
    t = run.t - run.t[0]
    readings, weight, same = cleaned(t, readings, noise)
    v = _velocity(t, readings[:, 0], noise[0], run.belt_speed)
    slips, cycle = _slips(t, v, run.belt_speed, noise)
    told = tuple(channel in run.noise for channel in CHANNELS[: len(noise)])
    half = half_apart(t, run.averaged)
    return Data(
        run.name, run.role, run.belt_speed, t, readings, weight, noise, v, slips, cycle, same, told, half
    )


def cleaned(t: Floats, readings: Floats, noise: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """
    Return readings (n, c) with what is no reading bridged, their weights, and which only repeat the one before.

    Parameters
    ----------
    t : (n,) times
    readings : (n, c), NaN where there is none
    noise : (c,) standard deviations
    """
    weight = np.where(np.isfinite(readings), 1.0 / noise, 0.0)
    readings = np.where(np.isfinite(readings), readings, 0.0)
    for c in range(readings.shape[1]):  # a reading at the end of its range says only that it is beyond
        weight[signals.find_clipping(readings[:, c]).mask, c] = 0.0
    same = np.column_stack([held(one, size) for one, size in zip(readings.T, noise, strict=True)]) & (
        weight > 0
    )
    weight[same] = 0.0
    for c in range(readings.shape[1]):
        _bridge(t, readings[:, c], weight[:, c])
        weight[signals.find_glitches(readings[:, c], noise=float(noise[c])).mask, c] = 0.0
        _bridge(t, readings[:, c], weight[:, c])
    return readings, weight, same


def held_words(data: Sequence[Data]) -> tuple[str, ...]:
    """What was found held, channel by channel."""
    return tuple(
        held_sentence(run.name, channel, run.t, mask)
        for run in data
        for channel, mask in zip(run.channels, run.held.T, strict=True)
        if mask.any()
    )


def one_rig(rig: AnyRig, runs: Sequence[Recording]) -> None:
    """Refuse runs that [[run]] gives another rig than the case's, which alone is fitted.

    Raises
    ------
    InputError
        With the run.
    """
    for run in runs:
        if run.rig != rig:
            raise InputError(
                f"{run.name}: [[run]] rig: one rig is taken for all runs of a case, and this run has another; put its "
                "numbers into [rig] if all have them, or make a case of its own of it"
            )


def copied_words(runs: Sequence[Recording]) -> tuple[str, ...]:
    """What is validated on readings that are trained on, under whatever name and from whatever row on."""
    out = []
    for run in (one for one in runs if one.role == "validate"):
        for other in (one for one in runs if one.role == "train"):
            count = max(_shared(run.x1, other.x1), _shared(other.x1, run.x1))
            if count:
                which = "the readings" if count == run.x1.size else f"{count} readings in a row"
                out.append(
                    f"{run.name} holds {which} of {other.name}, a train run: the error on it is no test, validate on "
                    "another record"
                )
    return tuple(out)


def _shared(one: Floats, other: Floats) -> int:
    """Readings from the start of a record that stand in a row in another; 0 where few values may do so by chance."""
    one, other = (np.where(np.isfinite(x), x, np.inf) for x in (one, other))
    if (one == one[0]).all():  # dead: every place of another dead one would be followed to its end
        return 0
    count, at = 0, np.arange(len(other))
    while count < len(one):
        at = at[at + count < len(other)]
        at = at[other[at + count] == one[count]]
        if not len(at):
            break
        count += 1
    values = len(np.unique(one[:count]))
    return count if values >= COPIED or (values > 1 and count == len(one)) else 0


def _bridge(t: Floats, values: Floats, weight: Floats) -> None:
    """Put neighbours' values where a reading has no weight, for the smoothers alone."""
    bad = weight == 0
    if bad.any() and not bad.all():
        values[bad] = np.interp(t[bad], t[~bad], values[~bad])


def _flanks(values: Floats) -> Floats:
    """The second and third neighbours on both sides of every value but the outer three, (4, n - 6, ...)."""
    return np.stack([values[:-6], values[1:-5], values[5:-1], values[6:]])


def _velocity(t: Floats, x: Floats, noise: float, belt_speed: float) -> Floats:
    """Velocity of x on the samples by local quadratics, narrow enough for a slip."""
    dt = float(np.median(np.diff(t)))
    grid = np.arange(0.0, t[-1] + 0.5 * dt, dt)
    resampled = np.interp(grid, t, x)
    width = velocity_width(t, noise, belt_speed)
    return np.asarray(np.interp(t, grid, scipy.signal.savgol_filter(resampled, width, 2, deriv=1, delta=dt)))


def velocity_width(t: Floats, noise: float, belt_speed: float) -> int:
    """Samples (odd) in the quadratics that a velocity is taken from, as few as its noise allows."""
    dt, width = float(np.median(np.diff(t))), 9
    while width * dt < 1.0 and 4 * noise * math.sqrt(12 / width**3) / dt > 0.2 * abs(belt_speed):
        width += 2
    return min(width, int(np.ceil((t[-1] + 0.5 * dt) / dt) - 1) // 2 * 2 - 1)


def read_again(run: Data, readings: Floats) -> Data:
    """The run with other readings (n, c), and with what is taken from them."""
    v = _velocity(run.t, readings[:, 0], float(run.noise[0]), run.belt_speed)
    slips, cycle = _slips(run.t, v, run.belt_speed, run.noise)
    return replace(run, readings=readings, v=v, slips=slips, cycle=cycle)


def _slips(t: Floats, v: Floats, belt_speed: float, noise: Floats) -> tuple[NDArray[np.int64], float]:
    """
    Samples of fastest slip against the belt, and the cycle.

    Of a block alone (one channel) every slip is a cycle of its own, small ones too; a leg's swing may make several of
    one, and the largest tells. Noise makes no slip, however few samples of a slow run are in slips.
    """
    speed, dt = np.abs(v - belt_speed), float(np.median(np.diff(t)))
    top = float(np.quantile(speed, 0.98))
    height, prominence = 0.5 * top, 0.3 * top
    if len(noise) == 1:
        width = velocity_width(t, float(noise[0]), belt_speed)
        sure = SURE_SLIP * velocity_noise(width, dt, float(noise[0]))
        height, prominence = (max(min(size, SLIP * abs(belt_speed)), sure) for size in (height, prominence))
    peaks, _ = scipy.signal.find_peaks(
        speed, height=height, prominence=prominence, distance=max(3, int(2.0 / dt))
    )
    inner = peaks[(peaks > 5) & (peaks < len(t) - 6)]
    if len(inner) < 3 or top < 0.3 * abs(belt_speed):
        cycle = 2 * math.pi
        return np.searchsorted(t, np.arange(cycle, t[-1] - cycle, cycle)).astype(np.int64), cycle
    return inner.astype(np.int64), float(np.median(np.diff(t[inner])))


def _local(
    t: Floats, x: Floats, weight: Floats, at: int, half: int, past_only: bool = False
) -> tuple[float, float]:
    low, high = max(0, at - half), at + 1 if past_only else min(len(t), at + half + 1)
    if high - low < half + 1:  # at an end: take as many on the other side
        low, high = (max(0, high - half - 1), high) if past_only or low > 0 else (low, low + half + 1)
    part = slice(low, high)
    c = np.polynomial.polynomial.polyfit(t[part] - t[at], x[part], 2, w=np.where(weight[part] > 0, 1.0, 1e-9))
    return float(c[0]), float(c[1])


def refined(data: Sequence[Data], factor: Floats) -> list[Data]:
    """The runs with their noise multiplied by a factor per channel; one that changes is no longer the declared one."""
    return [
        replace(
            run,
            noise=run.noise * factor,
            weight=run.weight / factor,
            declared=tuple(bool(told and f == 1) for told, f in zip(run.declared, factor, strict=False)),
        )
        for run in data
    ]


def without_outliers(data: Sequence[Data], residuals: Sequence[Floats]) -> list[Data]:
    """The runs with samples masked that stand out, singly or in twos, from the residual (n, c) on both their sides.

    A misfit varies from sample to sample by less than the noise, and a smooth one by less than twice its spread over
    the flanks of two, so that it masks nothing. Where the sampling is too coarse for that, much stands out, and stays.
    """
    out = []
    for run, r in zip(data, residuals, strict=True):
        odd = np.zeros(r.shape, dtype=bool)
        middle, spread = 0.5 * (r[:-2] + r[2:]), np.abs(r[2:] - r[:-2])
        odd[1:-1] = np.abs(r[1:-1] - middle) > OUTLIER_SIGMAS + spread
        flanks = _flanks(r)
        odd[3:-3] |= np.abs(r[3:-3] - flanks.mean(axis=0)) > OUTLIER_SIGMAS + 2 * np.ptp(flanks, axis=0)
        odd[:, odd.mean(axis=0) > MOST_OUTLIERS] = False
        out.append(replace(run, weight=np.where(odd, 0.0, run.weight)))
    return out
