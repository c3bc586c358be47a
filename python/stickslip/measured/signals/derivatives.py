"""Velocity and acceleration by (3.1), twice in a chain, aligned with the displacement."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import scipy
from numpy.typing import ArrayLike

from stickslip.arguments import explained
from stickslip.errors import InputError
from stickslip.measured.signals._input import Booleans, Floats, finite_vector
from stickslip.measured.signals.glitches import Glitches, remove_glitches
from stickslip.measured.signals.recursion import Differentiator, Rule, differentiator, first_order

Align = Literal["match", "shift", "none"]


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Displacement, velocity and acceleration of one channel by (3.1).

    Attributes
    ----------
    x, v, a : ndarray, shape (n,)
        Displacement, velocity, acceleration.
    lag_x, lag_v, lag_a : float
        How far each is behind the truth at low frequency [time]: sample i tells of time ``t[i] - lag``.
    noise_gain_x, noise_gain_v, noise_gain_a : float
        Standard deviation of each per unit standard deviation of white noise on the channel.
    settled : ndarray of bool, shape (n,)
        False while the start ``y_0 = 0`` is still felt (to 0.1 %), and at an end that was shifted away.
    differentiator : Differentiator
        The constants of (3.1).

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> found = signals.derivatives(np.sin(np.arange(0, 10, 0.01)), dt=0.01, tau=0.05)
    >>> print(f"{found.lag_x:.2f} {found.lag_v:.2f} {found.lag_a:.2f}")
    0.10 0.10 0.10
    >>> print(f"noise of 1 becomes {found.noise_gain_a:.0f}")
    noise of 1 becomes 373
    """

    x: Floats
    v: Floats
    a: Floats
    lag_x: float
    lag_v: float
    lag_a: float
    noise_gain_x: float
    noise_gain_v: float
    noise_gain_a: float
    settled: Booleans
    differentiator: Differentiator


@explained
def derivatives(
    x: ArrayLike,
    dt: float,
    tau: float,
    *,
    rule: Rule = "tustin",
    align: Align = "match",
    glitches: Glitches | None = None,
) -> Derivatives:
    """First and second derivative by (3.1) in a chain, with the lag of each.

    Parameters
    ----------
    x : array_like, shape (n,)
        Displacement sampled every `dt`, n >= 2.
    dt, tau : float
        Sampling interval and time constant [time].
    rule : {"tustin", "backward-euler", "ramp-invariant"}
        See `differentiator`.
    align : {"match", "shift", "none"}
        ``"match"``: displacement and velocity go through the low-pass half of (3.1) as often as the
        acceleration, so that all three lag by ``2 delay`` at every frequency. ``"shift"``: velocity and
        acceleration are moved forward by `delay` and ``2 delay``, between samples by a cubic; right at
        low frequency only. ``"none"``: as the chain gives them; force plotted over velocity then shows a
        loop that is not there.
    glitches : Glitches, optional
        Samples to replace first; one glitch g is otherwise an acceleration of ``k0^2 g``.

    Returns
    -------
    Derivatives

    Raises
    ------
    InputError
        As `first_order` and `differentiator`.

    Notes
    -----
    (3.1) with ``k1 = -k0`` is ``H(z) = (1-a)/(1-a/z) (1-1/z)/dt``. Its low-pass half is taken as
    ``G(z) = (1-a)/(1-a/z) (1+1/z)/2``, (3.1) with ``k0 = k1 = (1-a)/2``: ``H/G = (2j/dt) tan(omega dt/2)``
    has no phase of its own, so ``G G x``, ``G H x`` and ``H H x`` are aligned exactly.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> t = np.arange(0, 10, 0.01)
    >>> found = signals.derivatives(np.sin(t), dt=0.01, tau=0.05)
    >>> late = t - found.lag_v
    >>> print(f"{np.abs(found.v - np.cos(late))[found.settled].max():.3f}")
    0.002
    """
    if align not in get_args(Align):
        raise InputError(f"align must be one of {', '.join(get_args(Align))}, not {align!r}")
    values = finite_vector(x, "x", at_least=2)
    if glitches is not None:
        values = remove_glitches(values, glitches)
    d = differentiator(dt, tau, rule)
    level = values[0]  # taken out so that only a slope, not an offset, has to settle
    relative, v, a = _chain(values - level, d, align)
    samples = np.arange(values.size)
    settled = samples >= 2 * d.settling()
    lags = {"match": (2.0, 2.0, 2.0), "shift": (0.0, 0.0, 0.0), "none": (0.0, 1.0, 2.0)}[align]
    if align == "shift":
        v, a = _advance(v, d.delay / dt), _advance(a, 2.0 * d.delay / dt)
        settled &= samples <= values.size - 1 - 2.0 * d.delay / dt
    impulse = np.zeros(1 + 2 * d.settling(1e-8) + 8)
    impulse[2] = 1.0
    gain_x, gain_v, gain_a = (float(np.linalg.norm(response)) for response in _chain(impulse, d, align))
    lag_x, lag_v, lag_a = (count * d.delay for count in lags)
    return Derivatives(
        x=relative + level,
        v=v,
        a=a,
        lag_x=lag_x,
        lag_v=lag_v,
        lag_a=lag_a,
        noise_gain_x=gain_x,
        noise_gain_v=gain_v,
        noise_gain_a=gain_a,
        settled=settled,
        differentiator=d,
    )


def _chain(x: Floats, d: Differentiator, align: Align) -> tuple[Floats, Floats, Floats]:
    """Displacement, velocity and acceleration as the recursions give them."""
    velocity = first_order(x, d.a, d.k0, d.k1)
    acceleration = first_order(velocity, d.a, d.k0, d.k1)
    if align != "match":
        return x, velocity, acceleration
    half = 0.5 * (1.0 - d.a)
    once = first_order(x, d.a, half, half)
    return first_order(once, d.a, half, half), first_order(velocity, d.a, half, half), acceleration


def _advance(y: Floats, samples: float) -> Floats:
    """`y` a (fractional) number of samples later; the last value is held past the end."""
    n = np.arange(y.size, dtype=np.float64)
    if y.size < 4:
        return np.interp(n + samples, n, y)
    return np.asarray(scipy.interpolate.CubicSpline(n, y)(np.minimum(n + samples, n[-1])))
