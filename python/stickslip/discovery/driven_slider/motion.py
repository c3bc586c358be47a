"""What a recording of a driven slider says of the equation of motion, within the band in which it says anything."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.errors import InputError

Floats = NDArray[np.float64]

COHERENT = 0.5  # coherence of drive and acceleration at which the band ends
WIDER = 1.2  # the band is taken this much wider
FLOOR_CYCLES = 40  # the band is at least so many periods of the record wide
TAPS_PER_BAND = 3.3  # taps of a Hamming window over the width of its edge
EDGE = 0.3  # width of the band's edge over its limit
# periods of the band's limit: within so long of a turn, or in a stick as short, the sign is in doubt
HIDDEN = 0.5
SLOW = 4.0  # standard deviations of the velocity below which the slider may be at rest


@dataclass(frozen=True)
class Band:
    """A zero-phase low-pass and the step at which its output is kept.

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

    def matrix(self, n: int, precision: type[np.floating] = np.float32) -> scipy.sparse.csr_array:
        """The same as a matrix, for many columns of `n` samples."""
        at = self.kept(n)
        width = len(self.taps)
        rows = np.repeat(np.arange(len(at)), width)
        columns = (at[:, None] - self.half + np.arange(width)).ravel()
        weights = np.tile(self.taps, len(at)).astype(precision)
        return scipy.sparse.csr_array((weights, (rows, columns)), shape=(len(at), n))

    def smoothed(self, column: Floats) -> Floats:
        """Filter a column (n,) at its own rate, its ends continued by odd reflection."""
        h = self.half
        head, tail = 2 * column[0] - column[h:0:-1], 2 * column[-1] - column[-2 : -h - 2 : -1]
        return np.convolve(np.concatenate([head, column, tail]), self.taps, mode="valid")


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
    a half, and a fifth more; beyond, the position's quantisation and noise hide the motion.
    """
    dt = float(np.median(np.diff(t)))
    a = mass * np.diff(x, 2) / dt**2
    for what, values in (("the drive", force), ("the acceleration", a)):
        if np.ptp(values) == 0:
            raise InputError(
                f"no verdict: {what} never changes; a force balance needs a drive that moves the slider"
            )
    size = int(min(1024, max(64, len(a) // 16)))
    f, c = scipy.signal.coherence(force[1:-1], a, fs=1 / dt, nperseg=size)
    c = scipy.ndimage.median_filter(c, size=5)
    low = FLOOR_CYCLES / (t[-1] - t[0])
    under = np.flatnonzero((c < COHERENT) & (f > low))
    limit = float(f[under[0]]) if under.size else float(f[-1])
    cutoff = float(np.clip(WIDER * limit, low, 0.4 / dt))
    half = int(np.ceil(TAPS_PER_BAND / (EDGE * cutoff * dt) / 2))
    if 6 * half > len(x):
        raise InputError(f"{len(x)} samples are too few for a band of {cutoff:.3g} Hz", key="t")
    taps = scipy.signal.firwin(2 * half + 1, cutoff, fs=1 / dt)
    return Band(cutoff, np.asarray(taps, dtype=np.float64), max(int(1 / (2.5 * cutoff * dt)), 1))


@dataclass(frozen=True, eq=False)
class Motion:
    """One run: (n,) arrays at the sampling rate, SI.

    `x`, `v` position and velocity within the band, `a` the acceleration from second differences of the position as
    read, `command` the drive as recorded and `drive` as it acts at the samples, `rest` where the sign of the velocity
    is in doubt.
    """

    name: str
    t: Floats
    x: Floats
    v: Floats
    a: Floats
    command: Floats
    drive: Floats
    rest: NDArray[np.bool_]
    dt: float

    @cached_property
    def sign(self) -> Floats:
        """Sign of the velocity; 0 where it is in doubt."""
        return np.where(self.rest, 0.0, np.sign(self.v))


def motion(name: str, t: Floats, x: Floats, force: Floats, over: Band) -> Motion:
    """Read a run's motion.

    The drive is held from each sample to the next, so that the second difference of the position at a sample,
    divided by dt^2, is the acceleration that the mean of the two drives beside it makes: a mean over the two
    intervals, with triangular weight. `instant` makes values at the sample of both, for the other forces to add to.
    """
    dt = float(np.median(np.diff(t)))
    smooth = over.smoothed(x)
    v = np.gradient(smooth, dt)
    a = np.empty_like(x)
    a[1:-1] = np.diff(x, 2) / dt**2
    a[0], a[-1] = a[1], a[-2]
    held = np.concatenate([force[:1], 0.5 * (force[1:] + force[:-1])])
    return Motion(name, t, smooth, v, instant(a), force, instant(held), _rest(x, smooth, v, dt, over), dt)


def instant(mean: Floats) -> Floats:
    """Values at the samples (n,) of means over the two intervals beside each, with triangular weight.

    Such a mean is 1 + dt^2/12 d^2/dt^2 of the value (Numerov); what is neglected is of the order (w dt)^4.
    """
    out = mean.copy()
    out[1:-1] = (14 * mean[1:-1] - mean[:-2] - mean[2:]) / 12
    return out


def _rest(x: Floats, smooth: Floats, v: Floats, dt: float, over: Band) -> NDArray[np.bool_]:
    """Samples at which the slider may stick: beside a turn, slower than known, or so slow that a stick is hidden."""
    noise = 1.4826 * float(np.median(np.abs(x - smooth)))
    reach = HIDDEN / over.cutoff
    bend = np.abs(np.gradient(np.gradient(v, dt), dt))
    slow = np.abs(v) <= SLOW * noise * 2 * np.pi * over.cutoff + 0.5 * bend * reach**2
    turn = np.zeros(len(v), dtype=bool)
    turn[1:] = np.sign(v[1:]) != np.sign(v[:-1])
    near = slow | turn | np.append(turn[1:], False)
    wide = int(np.ceil(reach / dt))
    return np.asarray(scipy.ndimage.binary_dilation(near, iterations=wide))


Columns = Callable[[Motion], Floats]


def stacked(runs: Sequence[Motion], over: Band, columns: Columns) -> Floats:
    """Columns (n, m) of every run, filtered, one run below the other."""
    return np.concatenate([over(columns(run)) for run in runs])
