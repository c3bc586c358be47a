"""What is wrong with a channel: noise, quantisation, clipping; its glitches are in `glitches.py`."""

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from stickslip.arguments import explained
from stickslip.errors import InputError
from stickslip.measured.signals._input import Booleans, Floats, finite_vector, positive, real_array

_AT_ONCE = 1 << 14  # samples whose differences are weighted at once: each takes some 500 bytes


def _trimmed_std(values: Floats, cut: float) -> float:
    """Scale of a normal sample of mean 0, deaf to what lies beyond `cut` standard deviations."""
    density = math.exp(-0.5 * cut**2) / math.sqrt(2.0 * math.pi)
    kept = math.sqrt(1.0 - 2.0 * cut * density / (2.0 * scipy.special.ndtr(cut) - 1.0))  # std of a cut normal
    scale = 1.4826 * float(np.median(np.abs(values))) or float(np.mean(np.abs(values)))
    for _ in range(20):
        inside = values[np.abs(values) <= cut * scale]
        new = float(np.sqrt(np.mean(inside**2))) / kept if inside.size else scale
        if abs(new - scale) <= 1e-6 * scale:
            break
        scale = new
    return scale


@explained
def noise_std(x: ArrayLike, *, t: ArrayLike | None = None, cut: float = 3.5) -> float:
    """Estimate the standard deviation of the white noise on a channel.

    Third differences, scaled to unit weight, leave the noise and next to nothing of a signal that is a
    parabola over four samples; the few that meet an onset of slip, a capture or a glitch are trimmed.

    Parameters
    ----------
    x : array_like, shape (n,)
        Channel, n >= 12.
    t : array_like, shape (n,), optional
        Times, if the sampling is not regular.
    cut : float
        Differences beyond so many standard deviations are left out.

    Returns
    -------
    float
        In the unit of `x`. Noise that is correlated from sample to sample is underestimated.

    Raises
    ------
    InputError
        On samples that are not finite, too few, or times that do not increase.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> t = np.arange(0, 10, 0.01)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    >>> x = np.sin(t) + noise
    >>> print(f"{signals.noise_std(x):.4f}")
    0.0010
    """
    values = finite_vector(x, "x", at_least=12)
    times = None
    if t is not None:
        times = finite_vector(t, "t", at_least=12)
        if times.shape != values.shape or not (np.diff(times) > 0.0).all():
            raise InputError(f"t must increase and have the shape of x, {values.shape}")
    found = np.empty(values.size - 3)
    for first in range(0, found.size, _AT_ONCE):
        part = slice(first, first + _AT_ONCE + 3)
        found[first : first + _AT_ONCE] = _differences(values[part], None if times is None else times[part])
    return _trimmed_std(found, positive(cut, "cut"))


def _differences(x: Floats, t: Floats | None) -> Floats:
    """Third differences (n - 3,) scaled to unit weight."""
    windows = np.lib.stride_tricks.sliding_window_view(x, 4)
    if t is None:
        weights = np.broadcast_to(np.array([-1.0, 3.0, -3.0, 1.0]) / math.sqrt(20.0), windows.shape)
    else:
        quads = np.lib.stride_tricks.sliding_window_view(t, 4)
        apart = quads[:, :, None] - quads[:, None, :] + np.eye(4) * (quads[:, 3:] - quads[:, :1])[:, :, None]
        divided = 1.0 / np.prod(apart / (quads[:, 3:] - quads[:, :1])[:, :, None], axis=2)
        weights = divided / np.linalg.norm(divided, axis=1, keepdims=True)
    return np.asarray(np.einsum("ij,ij->i", weights, windows))


@dataclass(frozen=True)
class Quantisation:
    """Resolution of a channel.

    Attributes
    ----------
    step : float
        Spacing of the levels; 0 if the values lie on no grid [unit of x].
    levels : int
        Distinct values that occur.
    fraction_on_grid : float
        Part of the distinct spacings that are whole multiples of `step`, to 5 % of it.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> found = signals.quantisation(np.round(np.sin(np.arange(0, 10, 0.01)), 2))
    >>> print(f"{found.noise:.5f}")  # step/sqrt(12), the noise of rounding
    0.00289
    """

    step: float
    levels: int
    fraction_on_grid: float

    @property
    def noise(self) -> float:
        """Standard deviation of the rounding, ``step/sqrt(12)``: holds once other noise exceeds step/3."""
        return self.step / math.sqrt(12.0)


@explained
def quantisation(x: ArrayLike) -> Quantisation:
    """Find the grid the values of a channel lie on, from the spacings of the values that occur.

    Parameters
    ----------
    x : array_like, shape (n,)
        Channel.

    Returns
    -------
    Quantisation
        The printed digits of a text file are a grid too; `noise` says whether it matters.

    Raises
    ------
    InputError
        `x` is not one finite channel.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> found = signals.quantisation(np.round(np.sin(np.arange(0, 10, 0.01)), 2))
    >>> print(f"{found.step:.2f}, {found.levels} levels")
    0.01, 201 levels
    """
    values = finite_vector(x, "x")
    if values.size == 0:
        return Quantisation(0.0, 0, 0.0)
    rounding = 64.0 * np.finfo(np.float64).eps * float(np.abs(values).max())
    level = np.unique(values)
    spacing = np.diff(level)
    level = np.concatenate([level[:1], level[1:][spacing > rounding]])
    spacing = np.diff(level)
    if spacing.size < 2:  # two values make no grid
        return Quantisation(0.0, level.size, 0.0)
    smallest = float(spacing.min())
    step = float(np.median(spacing[spacing < 1.5 * smallest]))
    for _ in range(3):  # refine over several steps, while the count of steps is beyond doubt
        count = np.rint(spacing / step)
        sure = count <= 10.0
        step = float(np.sum(spacing[sure]) / np.sum(count[sure]))
    off = np.abs(spacing / step - np.rint(spacing / step))
    fraction = float(np.mean(off < 0.05 + rounding / step))
    return Quantisation(step if fraction >= 0.9 else 0.0, level.size, fraction)


@dataclass(frozen=True, eq=False)
class Clipping:
    """Limits at which a channel is cut off.

    Attributes
    ----------
    low, high : float or None
        The limit, None where the channel is not clipped [unit of x].
    mask : ndarray of bool, shape (n,)
        Samples at a limit.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> found = signals.find_clipping(np.minimum(np.sin(np.arange(0, 10, 0.01)), 0.8))
    >>> print(f"{found.mask.mean():.0%} of the samples are at the limit")
    26% of the samples are at the limit
    """

    low: float | None
    high: float | None
    mask: Booleans


@explained
def find_clipping(x: ArrayLike) -> Clipping:
    """Find limits at which a channel rests unnaturally often.

    An extreme value is a limit if it occurs at least five times, three of them in a row, and more than
    four times as often as the next level (a smooth extreme that is merely quantised: 2.4 times).

    Parameters
    ----------
    x : array_like, shape (n,)
        Channel. NaN is refused, infinities are limits.

    Returns
    -------
    Clipping

    Raises
    ------
    InputError
        A sample is NaN.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> found = signals.find_clipping(np.minimum(np.sin(np.arange(0, 10, 0.01)), 0.8))
    >>> found.low, float(found.high)
    (None, 0.8)
    """
    values = real_array(x, "x")
    if values.ndim != 1 or np.isnan(values).any():
        raise InputError(f"x must be one channel without NaN, not shape {values.shape}")
    mask = np.zeros(values.shape, dtype=np.bool_)
    limits: list[float | None] = [None, None]
    if np.unique(values).size > 2:
        for side, sign in enumerate((-1.0, 1.0)):
            at = values == sign * np.max(sign * values)
            beyond = values == sign * np.max(sign * values[~at])
            in_a_row = bool((at[:-2] & at[1:-1] & at[2:]).any())
            if at.sum() >= 5 and in_a_row and at.sum() > 4 * beyond.sum():
                limits[side] = float(values[at][0])
                mask |= at
    return Clipping(low=limits[0], high=limits[1], mask=mask)
