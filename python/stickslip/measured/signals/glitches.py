"""Samples, singly or in twos, that a channel cannot have read: found, and taken out."""

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained
from stickslip.errors import InputError
from stickslip.measured.signals._input import Booleans, Floats, finite_vector
from stickslip.measured.signals.quality import noise_std, quantisation

_CUBIC = (-1.0 / 6.0, 4.0 / 6.0, 0.0, 4.0 / 6.0, -1.0 / 6.0)  # the middle of five by its four neighbours
_CUBIC_STD = math.sqrt(1.0 + sum(w * w for w in _CUBIC))  # of x - prediction, for unit white noise
_PAIRS = {  # the first of two, so many places apart, by the two neighbours on either side of both
    1: (-0.3, 1.0, 0.5, -0.2),
    2: (-0.4, 1.2, 0.4, -0.2),
}
_WINDOW = 101  # samples over which the local scale of `find_glitches` is taken


@dataclass(frozen=True, eq=False)
class Glitches:
    """Glitches of a channel, of one sample or of two side by side.

    Attributes
    ----------
    mask : ndarray of bool, shape (n,)
        True where the sample is a glitch.
    deviation : ndarray, shape (n,)
        Sample less the cubic through its four neighbours [unit of x].
    threshold : ndarray, shape (n,)
        What `deviation` had to exceed [unit of x]; two side by side hide each other in it.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> t = np.arange(0, 10, 0.01)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    >>> x = np.sin(t) + noise
    >>> x[500] += 0.1
    >>> found = signals.find_glitches(x)
    >>> print(f"{found.deviation[500]:.2f}, where {found.threshold[500]:.3f} is allowed")
    0.10, where 0.007 is allowed
    """

    mask: Booleans
    deviation: Floats
    threshold: Floats

    @property
    def indices(self) -> NDArray[np.intp]:
        """Indices of the glitches."""
        return np.flatnonzero(self.mask)


@explained
def find_glitches(x: ArrayLike, *, false_alarms: float = 1e-6, noise: float | None = None) -> Glitches:
    """Mark samples that their neighbours on both sides contradict.

    A sample is compared with the cubic through its four neighbours; the deviation must exceed the
    normal quantile of `false_alarms` times its standard deviation, ``1.394 noise``, and stand out from
    the deviations beside it (a glitch g leaves -2g/3 there). Where the signal itself is rough (deviations
    over a hundred samples half as large again as usual) the local scale is used, after Hampel. The
    strongest are taken out first and the rest looked at again. Two side by side, or with one
    between them, hide each other from such a comparison: before it, both are compared with the cubic through the
    two neighbours on either side of them, and both must be beyond the same quantile by more than the slopes that
    these neighbours show differ: a bend or a jump of the motion is no glitch.

    Parameters
    ----------
    x : array_like, shape (n,)
        Channel; with n < 12 nothing is marked.
    false_alarms : float
        Bound on the probability that a sound sample with normal noise is marked, in (0, 1); about half
        of it is met, because a marked sample must also stand out from its neighbours.
    noise : float, optional
        Standard deviation of the noise; by default estimated by `noise_std`.

    Returns
    -------
    Glitches

    Raises
    ------
    InputError
        If `x` is not one finite channel, or a number is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> t = np.arange(0, 10, 0.01)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    >>> x = np.sin(t) + noise
    >>> x[500] += 0.1
    >>> found = signals.find_glitches(x)
    >>> print(np.flatnonzero(found.mask))
    [500]
    """
    values = finite_vector(x, "x").copy()
    if not 0.0 < false_alarms < 1.0:
        raise InputError(f"false_alarms must be between 0 and 1, not {false_alarms}")
    if noise is not None and not (math.isfinite(noise) and noise >= 0.0):
        raise InputError(f"noise must be a number >= 0, not {noise}")
    mask = np.zeros(values.shape, dtype=np.bool_)
    if values.size < 12:
        return Glitches(mask, np.zeros_like(values), np.full_like(values, np.inf))
    first = _deviation(values)
    threshold = _threshold(values, first, false_alarms, noise)
    for apart in _PAIRS:
        pairs = _pairs(values, threshold, apart)
        mask |= pairs != 0.0
        values -= pairs
    deviation = _deviation(values)
    for _ in range(10):
        size = np.abs(deviation)
        beside = np.maximum(np.roll(size, 1), np.roll(size, -1))
        further = np.maximum(np.roll(size, 2), np.roll(size, -2))
        new = (size > threshold) & (size > 1.1 * beside) & (size > further) & ~mask
        if not new.any():
            break
        values[new] -= deviation[new]
        mask |= new
        deviation = _deviation(values)
    return Glitches(mask, first, threshold)


def _deviation(x: Floats) -> Floats:
    """Each sample less the cubic through its four neighbours; 0 for the first two and the last two."""
    out = np.zeros_like(x)
    out[2:-2] = x[2:-2] - np.convolve(x, _CUBIC, mode="valid")
    return out


def _pairs(x: Floats, threshold: Floats, apart: int) -> Floats:
    """What two samples are off by, (n,), where both are glitches and one between them is none; 0 elsewhere.

    Of a jump they are off by less than the slopes around them differ (neighbours: by 0.3 of it, where those do by
    1/3), of a bend too (by 0.25 of the change of slope, where those differ by 0.5).
    """
    weights, places = np.array(_PAIRS[apart]), np.array([0, 1, apart + 3, apart + 4])
    first, second = (_off(x, weights, places, 2), _off(x, weights[::-1], places, 2 + apart))
    allowed = math.sqrt(1.0 + float(weights @ weights)) / _CUBIC_STD * threshold[2 : 2 + first.size]
    at = np.flatnonzero(np.minimum(np.abs(first), np.abs(second)) > allowed)  # few: the rest is done for them
    around = x[at + places[:, None]]
    between = x[at + 3] - (around[1] + around[2]) / 2 if apart > 1 else np.zeros(at.size)
    before, across, after = (
        around[1] - around[0],
        (around[2] - around[1]) / (apart + 2),
        around[3] - around[2],
    )
    bend = np.maximum(np.abs(before - across), np.abs(after - across))
    least = np.maximum(allowed[at] + bend, 2.0 * np.abs(between))  # a hump of three is motion
    at = at[np.minimum(np.abs(first[at]), np.abs(second[at])) > least]
    at = at[~np.isin(at - apart, at)]
    out = np.zeros_like(x)
    out[at + 2] += first[at]
    out[at + 2 + apart] += second[at]
    return out


def _off(x: Floats, weights: Floats, places: NDArray[np.intp], at: int) -> Floats:
    """What a sample of each window is off from the weighted ones in it, (n - width + 1,)."""
    kernel = np.zeros(places[-1] + 1)
    kernel[places], kernel[at] = -weights, 1.0
    return np.correlate(x, kernel, mode="valid")


def _threshold(x: Floats, deviation: Floats, false_alarms: float, noise: float | None) -> Floats:
    sigma = max(noise_std(x) if noise is None else noise, quantisation(x).noise)
    usual = _CUBIC_STD * sigma + 16.0 * np.finfo(np.float64).eps * float(np.abs(x).max())
    local = 1.4826 * scipy.ndimage.median_filter(np.abs(deviation), size=min(_WINDOW, x.size), mode="nearest")
    return np.asarray(-scipy.special.ndtri(0.5 * false_alarms) * np.where(local > 1.5 * usual, local, usual))


@explained
def remove_glitches(x: ArrayLike, glitches: Glitches) -> Floats:
    """`x` with the marked samples, and no others, replaced.

    Parameters
    ----------
    x : array_like, shape (n,)
        Channel.
    glitches : Glitches
        From `find_glitches`.

    Returns
    -------
    ndarray, shape (n,)
        Marked samples lie on the cubic through the two sound neighbours on either side (fewer at the ends).

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> t = np.arange(0, 10, 0.01)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    >>> x = np.sin(t) + noise
    >>> x[500] += 0.1
    >>> mended = signals.remove_glitches(x, signals.find_glitches(x))
    >>> print(f"{x[500]:.2f} {mended[500]:.2f}")
    -0.86 -0.96
    """
    values = finite_vector(x, "x").copy()
    sound = np.flatnonzero(~glitches.mask)
    if glitches.mask.shape != values.shape or sound.size == 0:
        raise InputError(
            f"glitches were found on a channel of shape {glitches.mask.shape}, not {values.shape}"
        )
    for at in glitches.indices:
        place = int(np.searchsorted(sound, at))
        near = sound[max(0, place - 2) : place + 2]
        others = near[:, None] - near[None, :] + np.eye(near.size)
        lagrange = np.prod(np.where(np.eye(near.size) == 1.0, 1.0, (at - near)[None, :] / others), axis=1)
        values[at] = lagrange @ values[near]
    return values
