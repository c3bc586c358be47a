"""What a recording of a driven slider says of its motion, and the band within which its force balance is shown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.errors import InputError
from stickslip.likelihoods.driven_slider.noise import (
    Noise,
    Rows,
    Sampling,
    Whitener,
    fitted,
)
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.measured.signals import quantisation

Floats = NDArray[np.float64]

HAMMING = 3.3  # taps of a Hamming window over the width of its edge
FEWEST = 10  # samples over the highest order of the noise


@dataclass(frozen=True)
class Band:
    """A zero-phase low-pass and the step at which its output is kept: what a report shows of a balance.

    `cutoff` in Hz, `taps` (2 h + 1,) symmetric, `step` in samples. Output sample i belongs to input sample
    h + i step; what the filter does not cover whole at either end is dropped.
    """

    cutoff: float
    taps: Floats
    step: int

    @property
    def half(self) -> int:
        """Samples lost at either end."""
        return len(self.taps) // 2

    def kept(self, n: int) -> NDArray[np.intp]:
        """Indices of the input samples that the output belongs to."""
        return np.arange(self.half, n - self.half, self.step)

    def __call__(self, columns: Floats) -> Floats:
        """Filter and thin columns (n,) or (n, m) along axis 0."""
        pad = -2 * self.half % self.step  # so that the first whole output falls on the grid that is kept
        head = np.zeros((pad, *columns.shape[1:]))
        out = scipy.signal.upfirdn(self.taps, np.concatenate([head, columns]), down=self.step, axis=0)
        first = (2 * self.half + pad) // self.step
        return np.asarray(out[first : first + len(self.kept(len(columns)))], dtype=np.float64)


def band(t: Floats, x: Floats, force: Floats, mass: float) -> Band:
    """The band in which the drive still explains the acceleration.

    Parameters
    ----------
    t, x, force
        Times [s], position [m] and drive [N], (n,).
    mass
        kg.

    Notes
    -----
    The limit is the last frequency at which the coherence of drive and second difference of the position is above
    a half; beyond, the position's quantisation and noise hide the motion. Nothing is fitted in it.
    """
    if len(x) < FEWEST * STEER.order:
        raise InputError(f"{len(x)} samples are too few; {FEWEST * STEER.order} are needed at least", key="t")
    dt = float(np.median(np.diff(t)))
    a = mass * np.diff(x, 2) / dt**2
    for what, values in (("the drive", force), ("the acceleration", a)):
        if np.ptp(values) == 0:
            raise InputError(f"{what} never changes; a force balance needs a drive that moves the slider")
    size = int(min(1024, max(64, len(a) // 16)))
    f, c = scipy.signal.coherence(force[1:-1], a, fs=1 / dt, nperseg=size)
    c = scipy.ndimage.median_filter(c, size=5)
    low = STEER.cycles / (t[-1] - t[0])
    under = np.flatnonzero((c < STEER.coherent) & (f > low))
    limit = float(f[under[0]]) if under.size else float(f[-1])
    cutoff = float(np.clip(limit, low, 0.4 / dt))
    half = int(np.ceil(HAMMING / (STEER.edge * cutoff * dt) / 2))
    if 6 * half > len(x):
        raise InputError(f"{len(x)} samples are too few for a band of {cutoff:.3g} Hz", key="t")
    taps = scipy.signal.firwin(2 * half + 1, cutoff, fs=1 / dt)
    return Band(cutoff, np.asarray(taps, dtype=np.float64), max(int(1 / (2.5 * cutoff * dt)), 1))


@dataclass(frozen=True, eq=False)
class DrivenRun:
    """One run: (n,) arrays at the sampling rate, SI.

    `reading` is the position as read, `step` that of its encoder or file (0: none), `x` and `v` position and velocity
    as smoothed, `a` the acceleration from second differences of the readings, `command` the drive as recorded and
    `drive` as it acts at the samples, `rest` where the sign of the velocity is in doubt.
    """

    name: str
    t: Floats
    reading: Floats
    step: float
    x: Floats
    v: Floats
    a: Floats
    command: Floats
    drive: Floats
    rest: NDArray[np.bool_]
    dt: float

    @cached_property
    def sign(self) -> Floats:
        """Sign of the velocity; at rest the likelier one."""
        return np.where(self.v < 0, -1.0, 1.0)

    @cached_property
    def sure(self) -> NDArray[np.bool_]:
        """Intervals (n - 1,) between samples in which the sign of the velocity is known."""
        return ~(self.rest[1:] | self.rest[:-1])

    @property
    def least(self) -> tuple[float, float]:
        """The least noise of the readings [m], rounding included, and of the drive [N] that a record may claim."""
        return (
            max(STEER.least_reading * float(np.ptp(self.reading)), self.step / float(np.sqrt(12))),
            STEER.least_force * float(np.sqrt(np.mean(self.command**2))),
        )

    def accelerations(self, sampling: Sampling) -> Floats:
        """What the readings say (n - 2,), as in `noise`."""
        return sampling.read(self.reading)

    def driven(self, sampling: Sampling) -> Floats:
        """The drive (n - 2,) as it acts on them: exact for one that is held."""
        return sampling.forced(self.command)

    def doubt(self, accelerated: float) -> Floats:
        """Variance (n,) of friction over the mass in the interval after each sample, `accelerated` being its limit.

        Friction in doubt most often keeps its sign: a stretch of m intervals has a variance of m limits squared each,
        so that their sum may be as large as if it did.
        """
        unsure = np.append(~self.sure, True)
        stretch, count = scipy.ndimage.label(unsure)
        sizes = np.append(0, scipy.ndimage.sum_labels(unsure, stretch, np.arange(1, count + 1)))
        return np.asarray(accelerated**2 * sizes[stretch], dtype=np.float64)


def motion(name: str, t: Floats, x: Floats, force: Floats, mass: float) -> DrivenRun:
    """Read a run's motion: the position smoothed by the noise model itself, friction being part of its noise.

    Parameters
    ----------
    name, t, x, force
        The run: times [s], position [m] and drive [N], (n,).
    mass
        Declared [kg].

    Notes
    -----
    The drive is held from each sample to the next. `instant` makes values at the samples of means over the intervals
    beside each, for the other forces to add to.
    """
    dt = float(np.median(np.diff(t)))
    a = np.empty_like(x)
    a[1:-1] = np.diff(x, 2) / dt**2
    a[0], a[-1] = a[1], a[-2]
    held = np.concatenate([force[:1], 0.5 * (force[1:] + force[:-1])])
    none = np.zeros(len(x), dtype=bool)
    raw = DrivenRun(name, t, x, quantisation(x).step, x, x, instant(a), force, instant(held), none, dt)
    sampling = Sampling(dt, 0.0)
    rows = Rows(raw.accelerations(sampling) - raw.driven(sampling) / mass, sampling, np.zeros(len(x)))
    reading, least = raw.least
    return moved(raw, fitted([rows], Noise(reading, least / mass)), rows)


def moved(run: DrivenRun, noise: Noise, rows: Rows) -> DrivenRun:
    """The motion smoothed by a noise and the residual of what is known of the forces; where it is sure of its sign."""
    x = run.reading - Whitener(noise, rows.sampling, rows.doubt).reading_noise(rows.residual)
    v = np.gradient(x, run.dt)
    change = np.abs(np.gradient(v)) + STEER.doubt * _deviation(noise, rows, run.dt)
    slow = np.abs(v) <= scipy.ndimage.maximum_filter1d(change, 3)
    turn = np.zeros(len(v), dtype=bool)
    turn[1:] = np.sign(v[1:]) != np.sign(v[:-1])
    near = scipy.ndimage.binary_dilation(slow | turn | np.append(turn[1:], False), iterations=2)
    return replace(run, x=x, v=v, rest=near)


def _deviation(noise: Noise, rows: Rows, dt: float) -> float:
    """Standard deviation of the smoothed velocity: the smoother on a drawn residual of known reading noise."""
    n = len(rows.doubt)
    e, d = noise.drawn(n, np.random.default_rng(0))
    residual = rows.sampling.read(e) + rows.sampling.forced(d)
    known = Whitener(noise, rows.sampling, np.zeros(n)).reading_noise(residual)
    return float(np.std(np.gradient(e - known, dt)))


def rounded(run: DrivenRun, noise: Noise, count: int, generator: np.random.Generator) -> Floats:
    """Errors (n, count) of rounding to the run's step, had its scale been mounted elsewhere; other noise dithers it."""
    if not run.step:
        return np.zeros((len(run.t), count))
    other = float(np.sqrt(max(noise.reading**2 - run.step**2 / 12, 0.0)))
    x = run.x[:, None] + run.step * generator.random(count)
    x = (x + other * generator.standard_normal(x.shape)) / run.step
    return np.asarray(run.step * (np.rint(x) - x), dtype=np.float64)


def instant(mean: Floats) -> Floats:
    """Values at the samples (n,) of means over the two intervals beside each, with triangular weight.

    Such a mean is 1 + dt^2/12 d^2/dt^2 of the value (Numerov); what is neglected is of the order (w dt)^4.
    """
    out = mean.copy()
    out[1:-1] = (14 * mean[1:-1] - mean[:-2] - mean[2:]) / 12
    return out


def spread(columns: Floats, sure: NDArray[np.bool_] | None = None) -> Floats:
    """Means (n - 2, ..) over the two intervals beside each sample, with triangular weight, of values (n, ..) at them.

    Parameters
    ----------
    columns
        Values; between the samples parabolas.
    sure
        Intervals (n - 1,) that count, the others being 0; None: all.
    """
    last, now, coming = columns[:-2], columns[1:-1], columns[2:]
    if sure is None:
        return np.asarray((last + 10 * now + coming) / 12, dtype=np.float64)
    counts = sure.reshape(-1, *[1] * (columns.ndim - 1)) / 24
    after, before = 3 * coming + 10 * now - last, 3 * last + 10 * now - coming
    return np.asarray(counts[1:] * after + counts[:-1] * before, dtype=np.float64)


Columns = Callable[[DrivenRun], Floats]


def stacked(runs: Sequence[DrivenRun], over: Band, columns: Columns) -> Floats:
    """Columns (n, m) of every run, filtered, one run below the other."""
    return np.concatenate([over(columns(run)) for run in runs])
