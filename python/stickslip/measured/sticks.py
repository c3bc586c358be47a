"""Where the block sticks, read from its noisy displacement, and the windows that fitting starts from.

This is the coarse look: a local quadratic gives the velocity, and a stretch is a stick while that velocity is
the belt's within the noise. It errs by a few samples at each transition, which is why windows are cut in the
middle of sticks, where nothing is in doubt, and transition times are left to the simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import scipy

from stickslip.errors import InputError
from stickslip.measured.fit_window import Array, Window

SIGMAS = 4.5  # one false alarm in 150 000 samples


@dataclass(frozen=True)
class Segment:
    """Samples start <= i < stop in one mode: 0 stick, -1 slip with v_w < 0, +1 slip with v_w > 0."""

    start: int
    stop: int
    mode: int


@dataclass(frozen=True)
class Track:
    """A displacement with its velocity and modes.

    Attributes
    ----------
    t, x, v : (n,) arrays
        Time, smoothed displacement, velocity.
    mode : (n,) int array
    segments : tuple of Segment
    belt_speed : float
        Speed the sticks were compared with.
    threshold : float
        |v - v_b| below which a sample can be stick.
    width : int
        Samples in the local quadratic.
    """

    t: Array
    x: Array
    v: Array
    mode: npt.NDArray[np.int64]
    segments: tuple[Segment, ...]
    belt_speed: float
    threshold: float
    width: int

    @property
    def sticks(self) -> tuple[Segment, ...]:
        """Stick segments, in time order."""
        return tuple(s for s in self.segments if s.mode == 0)

    @property
    def slips(self) -> tuple[Segment, ...]:
        """Slip segments that both begin and end inside the record."""
        return tuple(s for s in self.segments[1:-1] if s.mode != 0)

    @property
    def releases(self) -> Array:
        """Times of stick to slip, (k,)."""
        return np.array([self.t[b.start] for a, b in self._pairs() if a.mode == 0])

    @property
    def captures(self) -> Array:
        """Times of slip to stick, (k,)."""
        return np.array([self.t[b.start] for a, b in self._pairs() if b.mode == 0])

    def after(self, start: int) -> Track:
        """The track from sample `start` on, its time counted from there."""
        kept = tuple(
            Segment(max(s.start - start, 0), s.stop - start, s.mode) for s in self.segments if s.stop > start
        )
        return replace(
            self,
            t=self.t[start:] - self.t[start],
            x=self.x[start:],
            v=self.v[start:],
            mode=self.mode[start:],
            segments=kept,
        )

    def _pairs(self) -> list[tuple[Segment, Segment]]:
        return list(pairwise(self.segments))


def filter_width(dt: float, noise: float, belt_speed: float, period: float) -> int:
    """Odd number of samples for which `SIGMAS` of velocity noise stay below 15 % of the belt speed."""
    longest = max(9, int(period / 6 / dt))
    n = 9
    while n < longest and SIGMAS * velocity_noise(n, dt, noise) > 0.15 * abs(belt_speed):
        n += 2
    return n | 1


def velocity_noise(width: int, dt: float, noise: float) -> float:
    """Standard deviation of the slope of a line (or quadratic) fitted to `width` samples."""
    return noise * float(np.sqrt(12.0 / (width * (width**2 - 1.0)))) / dt


def track(
    t: Array,
    x: Array,
    *,
    belt_speed: float,
    noise: float,
    period: float,
    width: int | None = None,
    tolerance: float = 0.05,
    threshold: float | None = None,
) -> Track:
    """Modes and velocity of one displacement record.

    Parameters
    ----------
    t, x : (n,) arrays
        Time and displacement; NaN in x is bridged.
    belt_speed : float
        v_b; 0 is allowed (friction on a base at rest).
    noise : float
        Standard deviation of x.
    period : float
        Natural period of the block on its spring, in the unit of t.
    width : int, optional
        Samples of the local quadratic; chosen from the noise if absent.
    tolerance : float
        Share of the belt speed (of the typical speed, where the belt stands still) by which a stick may be off it:
        belts ripple, and real contacts creep.
    threshold : float, optional
        |v - v_b| below which a sample can be stick; from the noise and `tolerance` if absent.

    Returns
    -------
    Track

    Raises
    ------
    InputError
        If the record is shorter than the filter.
    """
    dt = float(np.median(np.diff(t)))
    reference = abs(belt_speed) or float(np.nanstd(x)) / period
    n = width or filter_width(dt, noise, reference, period)
    if len(t) < 3 * n:
        raise InputError(f"{len(t)} samples are too few: {3 * n} are needed to tell stick from slip")
    good = np.isfinite(x)
    filled = np.interp(t, t[good], x[good])
    smooth = scipy.signal.savgol_filter(filled, n, 2)
    v = scipy.signal.savgol_filter(filled, n, 2, deriv=1, delta=dt)
    if threshold is None:
        threshold = max(SIGMAS * velocity_noise(n, dt, noise), tolerance * reference)
    stick = _without_short_runs(np.abs(v - belt_speed) < threshold, shortest=n)
    stick = _without_rests(stick, t, filled, belt_speed)
    mode = _without_specks(np.where(stick, 0, np.where(v > belt_speed, 1, -1)))
    return Track(t, smooth, v, mode, runs(mode), belt_speed, threshold, n)


def plateau_speed(track_: Track, readings: Array) -> tuple[float, float]:
    """Speed at which the block rides in its sticks: weighted mean slope of the plateaus and its standard error.

    Returns (nan, nan) without at least three plateaus.
    """
    slopes, weights = [], []
    for s in track_.sticks:
        trim = track_.width // 2
        part = slice(s.start + trim, s.stop - trim)
        t, x = track_.t[part], readings[part]
        ok = np.isfinite(x)
        if ok.sum() < 2 * track_.width:
            continue
        slopes.append(float(np.polyfit(t[ok], x[ok], 1)[0]))
        weights.append(float(ok.sum()) ** 3)
    if len(slopes) < 3:
        return float("nan"), float("nan")
    w = np.array(weights) / np.sum(weights)
    mean = float(w @ slopes)
    return mean, float(np.sqrt(w**2 @ (np.array(slopes) - mean) ** 2))


def runs(mode: npt.NDArray[np.int64]) -> tuple[Segment, ...]:
    """Segments of equal mode, from the modes (n,) of all samples."""
    edges = np.flatnonzero(np.diff(mode)) + 1
    bounds = [0, *edges.tolist(), len(mode)]
    return tuple(Segment(a, b, int(mode[a])) for a, b in pairwise(bounds))


def _without_short_runs(mask: npt.NDArray[np.bool_], shortest: int) -> npt.NDArray[np.bool_]:
    """Sticks shorter than `shortest` are slips passing through v_b; shorter slips are noise."""
    out = mask.copy()
    for value, limit in ((False, max(shortest // 3, 3)), (True, shortest)):
        for s in runs(out.astype(np.int64)):
            if bool(out[s.start]) is value and s.stop - s.start < limit and s.start > 0 and s.stop < len(out):
                out[s.start : s.stop] = not value
    return out


def _without_rests(
    mask: npt.NDArray[np.bool_], t: Array, x: Array, belt_speed: float
) -> npt.NDArray[np.bool_]:
    """Sticks that rise less than half as fast as the belt are a block at rest, on which the belt slides.

    Where noise hides the belt's speed in every single velocity, a stretch as a whole still tells.
    """
    out = mask.copy()
    for s in runs(mask.astype(np.int64)) if belt_speed else ():
        part = slice(s.start, s.stop)
        if s.mode and s.stop - s.start > 1:
            out[part] = np.polyfit(t[part] - t[s.start], x[part], 1)[0] / belt_speed > 0.5
    return out


def as_read(track_: Track, t: Array, x: Array) -> Track:
    """The modes of a track with displacement and velocity of other readings, smoothed alike; NaN is bridged."""
    good = np.isfinite(x)
    filled, dt = np.interp(t, t[good], x[good]), float(np.median(np.diff(t)))
    smooth, v = (
        scipy.signal.savgol_filter(filled, track_.width, 2, deriv=order, delta=dt) for order in (0, 1)
    )
    return replace(track_, x=smooth, v=v)


def _without_specks(mode: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Slips of one or two samples take the mode of the segment before them."""
    out = mode.copy()
    for s in runs(mode)[1:]:
        if s.mode and s.stop - s.start < 3:
            out[s.start : s.stop] = out[s.start - 1]
    return out


def local_state(t: Array, x: Array, at: int, width: int, past_only: bool = False) -> tuple[float, float]:
    """Value and slope at sample `at` by a quadratic through the readings around (or up to) it."""
    lo = max(0, at - width)
    hi = at + 1 if past_only and at - lo >= 5 else min(len(t), at + width + 1)
    part = slice(lo, max(hi, lo + 6))
    ok = np.isfinite(x[part])
    c = np.polynomial.polynomial.polyfit(t[part][ok] - t[at], x[part][ok], 2)
    return float(c[0]), float(c[1])


def stick_position(track_: Track, readings: Array, stick: Segment, at: int, past_only: bool = False) -> float:
    """Displacement at sample `at` of a stick, where it rises at exactly v_b."""
    lo, hi = stick.start, at + 1 if past_only else stick.stop
    trim = min(track_.width // 2, (hi - lo) // 4)
    part = slice(lo + trim, hi if past_only else hi - trim)
    return float(np.nanmean(readings[part] - track_.belt_speed * (track_.t[part] - track_.t[at])))


def cut(track_: Track, length: float) -> list[tuple[int, int]]:
    """Window bounds (start, stop), cut in the middle of sticks, each at least `length` long.

    Without sticks the cuts are where the block is fastest against the belt, far from any transition.
    """
    t = track_.t
    candidates = [(s.start + s.stop) // 2 for s in track_.sticks if s.stop - s.start >= 12]
    if not candidates:
        speed = np.abs(track_.v - track_.belt_speed)
        inner = (speed[1:-1] >= speed[:-2]) & (speed[1:-1] > speed[2:]) & (speed[1:-1] > np.median(speed))
        candidates = (np.flatnonzero(inner) + 1).tolist()
    starts = [0]
    for c in candidates:
        if t[c] - t[starts[-1]] >= length and t[-1] - t[c] >= 0.5 * length:
            starts.append(c)
    return list(zip(starts, [*starts[1:], len(t)], strict=True))


def window(
    track_: Track,
    readings: Array,
    bounds: tuple[int, int],
    *,
    run: int,
    columns: Sequence[int],
    past_only: bool = False,
) -> Window:
    """A `Window` on the samples `bounds` with the state estimated at its start.

    Parameters
    ----------
    track_ : Track
        Of the first channel, x1.
    readings : (n, c) array
        Channels x1 and, for the rig of (2.1), y1.
    bounds : (int, int)
    run : int
    columns : sequence of int
        State column of each channel: (0,) or (0, 2).
    past_only : bool
        Estimate the state from samples up to the start only, as a forecast must.
    """
    start, stop = bounds
    stick = next((s for s in track_.sticks if s.start <= start < s.stop), None)
    t, vb = track_.t, track_.belt_speed
    if stick is None:
        initial, free = list(local_state(t, readings[:, 0], start, track_.width, past_only)), ["x1", "x2"]
    else:
        initial, free = [stick_position(track_, readings[:, 0], stick, start, past_only), vb], ["x1"]
    if len(columns) > 1:
        initial += local_state(t, readings[:, 1], start, 2 * track_.width, past_only)
        free += ["y1", "y2"]
    part = slice(start, stop)
    return Window(
        run=run,
        belt_speed=vb,
        t=t[part] - t[start],
        readings=readings[part],
        columns=tuple(columns),
        initial=np.array(initial),
        free=tuple(free),
    )
