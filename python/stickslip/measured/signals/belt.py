"""The speed of the belt as the sticks themselves tell it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.arguments import explained
from stickslip.errors import InputError
from stickslip.measured.signals._input import Floats, finite, finite_vector, positive
from stickslip.measured.signals.quality import noise_std

_STEPS = 2001


@dataclass(frozen=True)
class BeltSpeed:
    """Belt speed found in a channel.

    Attributes
    ----------
    speed : float
        The most frequent slope near the set-point [unit of x / time].
    std : float
        Scatter of the slopes about it: what `smooth` may be given as `stick_speed` [unit of x / time].
    share : float
        Part of all windows with a slope within two `std`: near 0, there is no stick to speak of.

    Examples
    --------
    >>> from stickslip import data, signals
    >>> t, x = data.stick_slip()  # s, m; the belt runs at 0.01 m/s
    >>> found = signals.find_belt_speed(t, x, set_point=0.01)
    >>> print(f"{found.share:.0%} of the windows ride the belt")
    71% of the windows ride the belt
    """

    speed: float
    std: float
    share: float


@explained
def find_belt_speed(
    t: ArrayLike, x: ArrayLike, set_point: float, *, within: float = 0.3, noise: float | None = None
) -> BeltSpeed:
    """Find the speed at which a channel sticks, near a set-point.

    While it sticks the channel moves with the belt: of the slopes over short windows the belt's own is by
    far the most frequent. It differs from the set-point if the belt runs off it or the channel's gain is
    wrong; compare the two before blaming either.

    Parameters
    ----------
    t, x : array_like, shape (n,)
        Increasing times and displacement, n >= 12.
    set_point : float
        Nominal belt speed, not 0 [unit of x / time].
    within : float
        Fraction of the set-point searched on either side, in (0, 1).
    noise : float, optional
        Standard deviation of the noise on `x`; by default `noise_std`.

    Returns
    -------
    BeltSpeed

    Raises
    ------
    InputError
        If the set-point is 0, an argument is out of range, or no slope is near the set-point.

    Examples
    --------
    >>> from stickslip import data, signals
    >>> t, x = data.stick_slip()  # s, m; the belt runs at 0.01 m/s
    >>> found = signals.find_belt_speed(t, 1.1 * x, set_point=0.01)  # a sensor 10 % off
    >>> print(f"{found.speed:.4f} m/s")
    0.0110 m/s
    """
    times, values = finite_vector(t, "t", at_least=12), finite_vector(x, "x", at_least=12)
    if times.shape != values.shape or not (np.diff(times) > 0.0).all():
        raise InputError(f"t must increase and have the shape of x, {values.shape}")
    if not (finite(set_point, "set_point") != 0.0 and 0.0 < finite(within, "within") < 1.0):
        raise InputError(f"needs a set-point other than 0 and 0 < within < 1, not {set_point}, {within}")
    sigma = noise_std(values, t=times) if noise is None else positive(noise, "noise")
    slopes, doubt = _slopes(times, values - set_point * times, sigma, abs(set_point))
    width = max(doubt, 0.005 * abs(set_point))
    grid = np.linspace(-1.0, 1.0, _STEPS) * within * abs(set_point)
    near = np.sort(slopes[np.abs(slopes) <= grid[-1] + width])
    counts = np.searchsorted(near, grid + width) - np.searchsorted(near, grid - width)
    if counts.max(initial=0) < 3:
        raise InputError(f"no slope of x is within {within:.0%} of the set-point {set_point}")
    peak = float(grid[counts == counts.max()].mean())
    for _ in range(5):  # mean shift: from the fullest bin to the middle of its heap
        peak = float(near[np.abs(near - peak) <= 2.0 * width].mean())
    heap = near[np.abs(near - peak) <= 2.0 * width]
    return BeltSpeed(float(set_point + peak), float(np.std(heap)), heap.size / slopes.size)


def _slopes(t: Floats, x: Floats, sigma: float, speed: float) -> tuple[Floats, float]:
    """Slopes over windows in which the noise leaves about 2 % of `speed` in doubt, and that doubt."""
    dt = float(np.median(np.diff(t)))
    need = (np.sqrt(12.0) * sigma / (0.02 * speed * dt)) ** (2.0 / 3.0)
    m = int(np.clip(np.ceil(need), 6, max(6, t.size // 8)))

    def total(values: Floats) -> Floats:
        sums = np.concatenate([[0.0], np.cumsum(values)])
        return np.asarray(sums[m:] - sums[:-m])

    x, t = x - x.mean(), t - t.mean()
    st, sx = total(t), total(x)
    stt = total(t * t) - st * st / m
    return (total(t * x) - st * sx / m) / stt, float(sigma / np.sqrt(np.median(stt)))
