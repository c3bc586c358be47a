"""The recursion (3.1) of the paper and the real differentiators it realises."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from stickslip import _core
from stickslip.arguments import explained
from stickslip.errors import InputError
from stickslip.measured.signals._input import Floats, finite, first_bad, positive, real_array

Rule = Literal["tustin", "backward-euler", "ramp-invariant"]


@explained
def first_order(x: ArrayLike, a: float, k0: float, k1: float) -> Floats:
    """Run ``y[n] = a y[n-1] + k0 x[n] + k1 x[n-1]`` along the first axis, (3.1).

    Parameters
    ----------
    x : array_like, shape (n,) or (n, channels)
        Signal; any real dtype, any strides.
    a : float
        Pole of the recursion, ``|a| < 1``.
    k0, k1 : float
        Weights of the sample and of the one before it.

    Returns
    -------
    ndarray of float64, same shape as `x`
        ``y[0] = 0``, as the paper starts; ``y[1] = k0 x[1] + k1 x[0]`` is the first value computed, so
        no sample before ``x[0]`` is ever supposed.

    Raises
    ------
    InputError
        If ``|a| >= 1``, a constant or a sample is not finite, `x` has masked samples or another shape, or the
        result is beyond float64.

    Notes
    -----
    The input terms are formed as ``k0 (x[n] - x[n-1]) + (k0 + k1) x[n-1]``: with ``k1 = -k0`` a signal
    at rest gives exactly 0, however far from 0 it rests. The recursion is evaluated as a scan (vectorised
    over time too); the result differs from that of the plain loop by rounding alone, at most a few
    ``eps (|k0| + |k1|) max|x| / (1 - |a|)``.

    References
    ----------
    Paper, (3.1), with the subscripts ``n+1`` read as ``n-1``.

    Examples
    --------
    >>> from stickslip import signals
    >>> signals.first_order([0.0, 1.0, 2.0, 3.0], a=0.5, k0=0.5, k1=-0.5)
    array([0.   , 0.5  , 0.75 , 0.875])
    """
    array = real_array(x, "x")
    if array.ndim not in (1, 2):
        raise InputError(f"x must have shape (n,) or (n, channels), not {array.shape}")
    for name, constant in (("a", a), ("k0", k0), ("k1", k1)):
        finite(constant, name)
    if not abs(a) < 1.0:
        raise InputError(f"a = {a} makes (3.1) unstable; it needs |a| < 1")
    rows = array.reshape(-1, 1) if array.ndim == 1 else array
    y = np.empty_like(rows)
    if not _core.first_order(x=rows, y=y, a=float(a), k0=float(k0), k1=float(k1)):
        raise InputError(first_bad(array, "x"))
    _refuse_overflow(y, a, k0, k1)
    return y.reshape(array.shape)


def _refuse_overflow(y: Floats, a: float, k0: float, k1: float) -> None:
    """Raise `InputError` if the recursion went beyond float64; one sum sees it, as a rule, at little cost."""
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(y.sum()) or np.isfinite(y).all():
            return
    row = int(np.argmin(np.isfinite(y).all(axis=1)))
    words = f"(3.1) with a = {a:g}, k0 = {k0:g}, k1 = {k1:g} overflows at sample {row}"
    raise InputError(f"{words}: constants and samples must be of a size whose products are finite")


@dataclass(frozen=True)
class Differentiator:
    """Constants of (3.1) that differentiate, ``s/(1 + tau s)`` in discrete time, and what they cost.

    All three rules have ``k0 = (1 - a)/dt`` and ``k1 = -k0``: a straight line has, once the start has
    died out, exactly its slope as derivative; a constant has 0.

    Attributes
    ----------
    a, k0, k1 : float
        Constants of (3.1); `k0`, `k1` in 1/time.
    dt, tau : float
        Sampling interval and time constant [time].
    rule : str
        How `a` was found from `tau` and `dt`.

    Examples
    --------
    >>> from stickslip import signals
    >>> made = signals.differentiator(dt=0.01, tau=0.05, rule="backward-euler")
    >>> print(f"noise of 1 becomes {made.noise_gain():.2f}")
    noise of 1 becomes 17.41
    """

    a: float
    k0: float
    k1: float
    dt: float
    tau: float
    rule: Rule

    @property
    def delay(self) -> float:
        """Lag of the derivative behind the true one at low frequency, ``dt (1/2 + a/(1 - a))`` [time]."""
        return self.dt * (0.5 + self.a / (1.0 - self.a))

    def phase_delay(self, omega: ArrayLike) -> Floats:
        """Lag [time] of a sine of angular frequency `omega` [rad/time], ``0 < omega < pi/dt``."""
        w = np.asarray(omega, dtype=np.float64)
        lag = np.arctan2(self.a * np.sin(w * self.dt), 1.0 - self.a * np.cos(w * self.dt))
        return np.asarray(0.5 * self.dt + lag / w)

    def gain(self, omega: ArrayLike) -> Floats:
        """Amplitude of the derivative over the true one, for sines of `omega` [rad/time]; 1 at rest."""
        angle = np.asarray(omega, dtype=np.float64) * self.dt
        pole = np.sqrt(1.0 - 2.0 * self.a * np.cos(angle) + self.a**2)
        return np.asarray((1.0 - self.a) * np.sinc(angle / (2.0 * np.pi)) / pole)

    def noise_gain(self, order: int = 1) -> float:
        """Give the standard deviation of the derivative of white noise of standard deviation 1.

        Parameters
        ----------
        order : {1, 2}
            Once: ``k0 sqrt(2/(1 + a))`` [1/time]; twice in a chain:
            ``k0^2 sqrt((6 + 2a)/(1 + a)^3)`` [1/time^2].

        Returns
        -------
        float
        """
        if order == 1:
            return self.k0 * math.sqrt(2.0 / (1.0 + self.a))
        if order == 2:
            return self.k0**2 * math.sqrt((6.0 + 2.0 * self.a) / (1.0 + self.a) ** 3)
        raise InputError(f"order must be 1 or 2, not {order}")

    def settling(self, fraction: float = 1e-3) -> int:
        """Count the samples until the start ``y_0 = 0`` has died out to `fraction` of its size."""
        if self.a == 0.0:
            return 1
        return max(1, math.ceil(math.log(fraction) / math.log(abs(self.a))))


@explained
def differentiator(dt: float, tau: float, rule: Rule = "tustin") -> Differentiator:
    """Constants of (3.1) for the real differentiator ``s/(1 + tau s)``.

    Parameters
    ----------
    dt : float
        Sampling interval, > 0 [time].
    tau : float
        Time constant, > 0 (0 too for ``"backward-euler"``: the plain difference) [time].
    rule : {"tustin", "backward-euler", "ramp-invariant"}
        See the table.

    Returns
    -------
    Differentiator

    Raises
    ------
    InputError
        If `dt` or `tau` is not as said, or the rule is unknown.

    Notes
    -----
    ==================  =====================================  ==============  ===========================
    rule                made by                                a               lag at low frequency
    ==================  =====================================  ==============  ===========================
    ``tustin``          ``s = 2(1-1/z)/(dt(1+1/z))``           (2tau-dt)/      tau
                                                               (2tau+dt)
    ``backward-euler``  ``s = (1-1/z)/dt``                     tau/(tau+dt)    tau + dt/2
    ``ramp-invariant``  the exact answer to straight lines     exp(-dt/tau)    (dt/2) coth(dt/(2 tau))
                        between the samples
    ==================  =====================================  ==============  ===========================

    With ``tau < dt/2`` Tustin's pole is negative: stable, but the derivative rings from sample to sample.

    Examples
    --------
    >>> from stickslip import signals
    >>> made = signals.differentiator(dt=0.01, tau=0.05)
    >>> print(f"a = {made.a:.4f}, k0 = {made.k0:.4f}, late by {made.delay:.4f}")
    a = 0.8182, k0 = 18.1818, late by 0.0500
    """
    h = positive(dt, "dt")
    if rule not in get_args(Rule):
        raise InputError(f"rule must be one of {', '.join(get_args(Rule))}, not {rule!r}")
    if rule == "backward-euler" and tau == 0.0:
        a = 0.0
    else:
        t = positive(tau, "tau")
        a = {
            "tustin": (2.0 * t - h) / (2.0 * t + h),
            "backward-euler": t / (t + h),
            "ramp-invariant": math.exp(-h / t),
        }[rule]
    if not abs(a) < 1.0:
        raise InputError(f"tau = {tau} is out of proportion to dt = {dt}: (3.1) would have a = {a}")
    k0 = (1.0 - a) / h
    return Differentiator(a=a, k0=k0, k1=-k0, dt=h, tau=float(tau), rule=rule)


@explained
def differentiate(x: ArrayLike, dt: float, tau: float, rule: Rule = "tustin") -> Floats:
    """First derivative by (3.1), the real differentiator ``s/(1 + tau s)``.

    Parameters
    ----------
    x : array_like, shape (n,) or (n, channels)
        Signal sampled every `dt`.
    dt, tau : float
        Sampling interval and time constant [time].
    rule : {"tustin", "backward-euler", "ramp-invariant"}
        See `differentiator`, which also tells lag and noise gain.

    Returns
    -------
    ndarray of float64, same shape as `x`
        Derivative [unit of x / time], late by ``differentiator(dt, tau, rule).delay``; ``y[0] = 0``.

    Raises
    ------
    InputError
        As `first_order` and `differentiator`.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> x = 3.0 * np.arange(200) * 0.01
    >>> print(f"{signals.differentiate(x, dt=0.01, tau=0.05)[-1]:.4f}")
    3.0000
    """
    d = differentiator(dt, tau, rule)
    return first_order(x, d.a, d.k0, d.k1)
