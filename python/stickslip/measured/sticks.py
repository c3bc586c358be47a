"""Where the block sticks, read from its noisy displacement: the one answer, which everything else asks.

This is the coarse look: a local quadratic gives the velocity, and a stretch is a stick while that velocity is
the belt's within the noise. It errs by a few samples at each transition.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import scipy

from stickslip.errors import InputError
from stickslip.measured.fit_window import Array

SIGMAS = 4.5  # one false alarm in 150 000 samples
RIPPLE = 0.05  # share of the belt speed by which a stick may be off it: belts ripple
CREEP = (
    0.25  # the same for a contact that creeps before it slips, and for a velocity whose noise is not known
)
BROKEN = 3  # samples by which noise may break a stick
SURE = 3.0  # standard deviations of a stretch's rise
EDGE = (
    0.25  # radians by which noise may lengthen either half of the time that a swing is near the belt's speed
)
CLEAR = 12  # samples of a stick whose middle is in no doubt
LEAST_SLIP = 12.0  # size of a slip over the noise, below which it is not told from noise
EARLY = (0.1, 0.6)  # part of a stick whose rise is taken: its end creeps
LONG = 24  # samples of a stick whose rise can be told


@dataclass(frozen=True)
class Segment:
    """Samples start <= i < stop in one mode: 0 stick, -1 slip with v_w < 0, +1 slip with v_w > 0."""

    start: int
    stop: int
    mode: int

    def __len__(self) -> int:
        return self.stop - self.start

    @property
    def middle(self) -> int:
        """The sample farthest from both ends."""
        return (self.start + self.stop) // 2


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
    def clear_sticks(self) -> tuple[Segment, ...]:
        """Sticks long enough for their middle to be in no doubt."""
        return tuple(s for s in self.sticks if len(s) >= CLEAR)

    @property
    def slips(self) -> tuple[tuple[Segment, Segment, Segment], ...]:
        """Slips against the belt with a stick on both sides: the stick before, the slip, the stick after."""
        trios = zip(self.segments[:-2], self.segments[1:-1], self.segments[2:], strict=True)
        against = -int(np.sign(self.belt_speed))
        return tuple(t for t in trios if (t[0].mode, t[1].mode, t[2].mode) == (0, against, 0))

    def size(self, slip: Segment) -> float:
        """Range of the displacement from release to capture: what the eye sees of a slip."""
        return float(np.ptp(self.x[slip.start : slip.stop + 1]))

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
    tolerance: float = RIPPLE,
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
    for s in runs(stick.astype(np.int64)) if belt_speed else ():
        part = slice(s.start, s.stop)
        if s.mode and s.stop - s.start > 1:
            stick[part] = not (
                _rests(t[part], filled[part], belt_speed)
                or passes_by(t[part], filled[part], belt_speed, noise, period, threshold / abs(belt_speed))
            )
    mode = _without_specks(np.where(stick, 0, np.where(v > belt_speed, 1, -1)))
    return Track(t, smooth, v, mode, runs(mode), belt_speed, threshold, n)


def rides(v: Array, belt_speed: float | Array) -> npt.NDArray[np.bool_]:
    """Whether velocities (n,) are the belt's, within what ripple, creep and noise make of it."""
    return np.asarray(np.abs(v - belt_speed) <= CREEP * np.abs(belt_speed))


@dataclass(frozen=True)
class Rises:
    """How fast the sticks of a record rise; (k,) arrays. `std` is what the noise leaves of `speed`."""

    t: Array
    x: Array
    speed: Array
    std: Array


def rises(track_: Track, readings: Array, noise: float) -> Rises:
    """Slopes of the sticks, early in each, by least squares without outliers; NaN in readings (n,) is left out."""
    rows = []
    for s in track_.sticks:
        if len(s) < LONG:
            continue
        at = np.arange(s.start + int(EARLY[0] * len(s)), s.start + int(EARLY[1] * len(s)))
        at = at[np.isfinite(readings[at])]
        if len(at) < LONG // 3:
            continue
        u = track_.t[at] - track_.t[at].mean()
        kept = np.ones(len(at), dtype=bool)
        c = np.zeros(2)
        for _ in range(3):
            c = np.polyfit(u[kept], readings[at][kept], 1)
            off = np.abs(readings[at] - np.polyval(c, u))
            kept = off <= max(4 * noise, float(np.median(off)))
        rows.append((track_.t[at].mean(), c[1], c[0], noise / np.sqrt(float(np.sum(u[kept] ** 2)))))
    return Rises(*np.array(rows).reshape(-1, 4).T)


def plateau_speed(track_: Track, readings: Array, noise: float) -> tuple[float, float]:
    """Speed at which the block rides in its sticks: weighted mean of their rises and its standard error.

    Returns (nan, nan) without at least three sticks.
    """
    found = rises(track_, readings, noise)
    if len(found.t) < 3:
        return float("nan"), float("nan")
    w = found.std**-2.0 / np.sum(found.std**-2.0)
    mean = float(w @ found.speed)
    return mean, float(np.sqrt(w**2 @ (found.speed - mean) ** 2))


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


def _rests(t: Array, x: Array, belt_speed: float) -> bool:
    """
    Whether a stretch rises less than half as fast as the belt: the block is at rest, and the belt slides on it.

    Where noise hides the belt's speed in every single velocity, a stretch as a whole still tells.
    """
    return bool(np.polyfit(t - t[0], x, 1)[0] / belt_speed <= 0.5)


def passes_by(t: Array, x: Array, belt_speed: float, noise: float, period: float, band: float) -> bool:
    """
    Whether a stretch near the belt's speed is the top of a swing, and no stick.

    The top is below the belt's speed, and is passed as soon as a cosine passes it. A stick on a belt that slows down,
    or on a contact that creeps, lasts longer.

    Parameters
    ----------
    t, x : (n,) its times and displacements
    belt_speed, noise, period : of the belt; standard deviation of x; of the block on its spring
    band : share of the belt's speed by which a velocity may be off it and is near it
    """
    t = t - t.mean()
    square = float(t @ t)
    rise, error = float(t @ x) / square / belt_speed, noise / float(np.sqrt(square))
    return tops_out(rise, error / abs(belt_speed), 2 * np.pi * float(t[-1]) / period, band)


def tops_out(rise: float, error: float, half: float, band: float) -> bool:
    """
    Whether a rise near a belt's speed is the top of a swing; see `passes_by`.

    Parameters
    ----------
    rise, error : share of the belt's speed that it is, and its standard deviation
    half : of its duration, radians of the swing
    band : share of the belt's speed by which a velocity may be off it and is near it
    """
    top = rise * (1 + half**2 / 10)  # of a cosine with that rise
    if top + SURE * error >= 1 - RIPPLE:
        return False
    return bool(top <= max(1 - band, 0.0) or half <= np.arccos(max(1 - band, 0.0) / top) + EDGE)


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
