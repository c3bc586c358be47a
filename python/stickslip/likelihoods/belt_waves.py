"""A belt whose speed wanders within a window: what the readings show of it, to first order.

The belt's relative speed is a broken line over the window. A block that sticks rides it. How far the belt has come says
when the force reaches its limit: the slip is taken as the same, earlier or later. What a wandering speed does to a slip
beside that is as large, but far less than what friction's own scatter does, and the window's own friction takes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np
import scipy.signal
from numpy.typing import NDArray

from stickslip.likelihoods.symmetric_root import symmetric_root

Floats = NDArray[np.float64]


def weights(count: int) -> Floats:
    """Return what each knot of the line counts in its mean over the window, (count,)."""
    out = np.full(count, 1.0 / (count - 1))
    out[[0, -1]] *= 0.5
    return out


def correlation(length: float, count: int, slow: tuple[float, float]) -> Floats:
    """
    Return the correlation of the speed at the knots, (count, count).

    Parameters
    ----------
    length : of a window, in time
    count : knots
    slow : angular frequencies at which belts wander, all alike
    """
    at = np.linspace(0.0, length, count)
    w = np.linspace(*slow, 40)
    return np.asarray(np.cos(w * (at[:, None, None] - at[None, :, None])).mean(axis=2))


def root(length: float, count: int, slow: tuple[float, float]) -> Floats:
    """Return the factor of the line less its mean, and last of the mean, (count + 1, count), of unit variance."""
    whole = symmetric_root(correlation(length, count, slow))
    mean = weights(count) @ whole
    return np.concatenate([whole - mean, mean[None]])


def hats(t: Floats, count: int) -> Floats:
    """Return the line's shapes over a window, (n, count)."""
    at = (t - t[0]) * ((count - 1) / (t[-1] - t[0])) if len(t) > 1 else np.zeros(1)
    left = np.minimum(at.astype(np.int64), count - 2)
    out, rows = np.zeros((len(t), count)), np.arange(len(t))
    out[rows, left], out[rows, left + 1] = 1.0 - (at - left), at - left
    return out


def times(t: Floats, shapes: Floats) -> Floats:
    """Return the integral of each shape from the window's start, (n, count)."""
    steps = 0.5 * (shapes[1:] + shapes[:-1]) * np.diff(t)[:, None]
    return np.concatenate([np.zeros((1, shapes.shape[1])), np.cumsum(steps, axis=0)])


def ridden(
    speed: Floats,
    mode: NDArray[np.int8] | NDArray[np.bool_],
    belt_speed: float | Floats,
    passed: Floats,
    begins: Sequence[int] | NDArray[np.int64] = (0,),
) -> Floats:
    """
    Return the derivatives of the block's place by the knots' relative speeds, (n, count).

    Parameters
    ----------
    speed, mode : (n,) the block's speed at the samples of windows one after the other, and 0 where it sticks
    belt_speed : of the belt, or (n,)
    passed : (n, count) of `times`
    begins : where each window begins
    """
    out = np.reshape(belt_speed, (-1, 1)) * passed
    share = speed / belt_speed
    sticks = mode == 0
    edges = np.flatnonzero(np.diff(sticks)) + 1
    ahead = np.zeros(out.shape[1])  # place of the block in the last stick, less that of the belt since
    first = {int(one) for one in begins}
    cuts = sorted(first.union(edges.tolist()))
    for a, b in zip(cuts, [*cuts[1:], len(speed)], strict=True):
        if a in first:
            ahead = np.zeros(out.shape[1])
        if sticks[a]:
            out[a:b] += ahead - out[a]
            ahead = out[b - 1]
        else:  # the slip is the same, by as much sooner as the belt was ahead
            out[a:b] = share[a:b, None] * ahead
    return out


def leg(
    place: Floats,
    step: float,
    values: Mapping[str, float],
    offset: NDArray[np.int64] | None = None,
) -> Floats:
    """
    Return the derivatives of y1 that follow from those of the block's place, (n, count): the leg is a linear filter.

    Parameters
    ----------
    place : (n, count) of `ridden`
    step : between samples
    values : numbers of the rig of (2.1)
    offset : (w + 1,) where windows begin and end, if there are several
    """
    over = -values["eta1"], -1.0
    if offset is None:
        return _filtered(over, place, step, values)
    # side by side, each as long as the longest: a filter sees nothing of what comes later
    lengths = np.diff(offset)
    window = np.repeat(np.arange(len(lengths)), lengths)
    row = np.arange(len(place)) - offset[window]
    beside = np.zeros((int(lengths.max()), len(lengths), place.shape[1]))
    beside[row, window] = place
    return np.asarray(_filtered(over, beside, step, values)[row, window])


def _filtered(over: tuple[float, ...], x: Floats, step: float, values: Mapping[str, float]) -> Floats:
    b, a = _filter(step, over, *(values[name] for name in ("alpha2", "eta12", "beta3")))
    return np.asarray(scipy.signal.lfilter(b, a, x, axis=0))


@lru_cache(maxsize=64)  # every window of a run asks for the same one, and it takes longer to make than to use
def _filter(
    step: float, over: tuple[float, ...], alpha2: float, eta12: float, beta3: float
) -> tuple[Floats, Floats]:
    """The angle body's filter between samples."""
    b, a = scipy.signal.bilinear(over, [alpha2, eta12, beta3], 1.0 / step)
    return np.asarray(b), np.asarray(a)
