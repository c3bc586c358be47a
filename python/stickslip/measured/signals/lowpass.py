"""Elliptic low-pass filters, causal and without delay."""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from stickslip.arguments import explained
from stickslip.errors import InputError
from stickslip.measured.signals._input import Floats, first_bad, positive, real_array

SLOWEST = 0.05  # periods of the cutoff in the record


@dataclass(frozen=True, eq=False)
class Lowpassed:
    """A filtered channel.

    Attributes
    ----------
    x : ndarray, shape (n,) or (n, channels)
        Filtered signal.
    delay : float
        Lag at low frequency [time]; 0 without phase.
    cutoff : float
        End of the pass band [1/time].
    sos : ndarray, shape (sections, 6)
        The filter, run once (causal) or forth and back (zero phase).

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> t = np.arange(0, 10, 0.01)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    >>> x = np.sin(t) + noise
    >>> causal = signals.lowpass(x, dt=0.01, cutoff=2.0, zero_phase=False)
    >>> print(f"{causal.delay:.3f}")  # how late it is
    0.186
    """

    x: Floats
    delay: float
    cutoff: float
    sos: Floats


@explained
def lowpass(
    x: ArrayLike,
    dt: float,
    cutoff: float,
    *,
    order: int = 4,
    ripple: float = 0.1,
    attenuation: float = 60.0,
    zero_phase: bool = True,
) -> Lowpassed:
    """Low-pass a channel by an elliptic filter, gain exactly 1 at rest.

    Parameters
    ----------
    x : array_like, shape (n,) or (n, channels)
        Signal sampled every `dt`.
    dt : float
        Sampling interval [time].
    cutoff : float
        End of the pass band [1/time], below ``1/(2 dt)``.
    order : int
        Order of the filter.
    ripple, attenuation : float
        In the pass band and at least in the stop band [dB]; both count twice without phase.
    zero_phase : bool
        Forth and back (no delay, but a capture is felt before it happens) or causal.

    Returns
    -------
    Lowpassed

    Raises
    ------
    InputError
        If a number is out of range, a sample is not finite, or the signal is too short to turn at its ends.

    Notes
    -----
    Filters smear what is sudden: kinks of the velocity at onset and capture are rounded over about
    ``1/(2 cutoff)``. `stickslip.measured.signals.smooth` keeps them.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> t = np.arange(0, 10, 0.01)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    >>> x = np.sin(t) + noise
    >>> smooth = signals.lowpass(x, dt=0.01, cutoff=2.0)
    >>> left = (smooth.x - np.sin(t))[100:-100]  # the ends are worse
    >>> print(f"noise of {np.std(x - np.sin(t)):.4f} becomes {np.std(left):.4f}")
    noise of 0.0010 becomes 0.0015
    """
    values = real_array(x, "x")
    if values.ndim not in (1, 2) or values.shape[0] == 0:
        raise InputError(f"x must have shape (n,) or (n, channels), n > 0, not {values.shape}")
    if not np.isfinite(values).all():
        raise InputError(first_bad(values, "x"))
    nyquist = 0.5 / positive(dt, "dt")
    if not positive(cutoff, "cutoff") < nyquist:
        raise InputError(f"cutoff = {cutoff} must be below half the sampling rate, {nyquist:g}")
    if cutoff * dt * values.shape[0] < SLOWEST:
        raise InputError(
            f"cutoff = {cutoff} is far below one over the record's length, {1 / (dt * values.shape[0]):.3g}: "
            "nothing would be left"
        )
    if order < 1 or not 0.0 < ripple < attenuation:
        raise InputError(
            f"needs order >= 1 and 0 < ripple < attenuation, not {order}, {ripple}, {attenuation}"
        )
    sos = np.asarray(scipy.signal.ellip(order, ripple, attenuation, cutoff, fs=1.0 / dt, output="sos"))
    at_rest = np.prod(sos[:, :3].sum(axis=1) / sos[:, 3:].sum(axis=1))
    sos[0, :3] /= at_rest  # even orders pass a constant with -ripple dB: slopes would be wrong by that
    if not zero_phase:
        start = scipy.signal.sosfilt_zi(sos).reshape(sos.shape[0], 2, *[1] * (values.ndim - 1)) * values[0]
        return Lowpassed(
            scipy.signal.sosfilt(sos, values, axis=0, zi=start)[0], _delay(sos) * dt, cutoff, sos
        )
    ends = 3 * (2 * sos.shape[0] + 1)
    if values.shape[0] <= ends:
        raise InputError(f"x has {values.shape[0]} samples; forth and back needs more than {ends}")
    return Lowpassed(scipy.signal.sosfiltfilt(sos, values, axis=0), 0.0, cutoff, sos)


def _delay(sos: Floats) -> float:
    """Group delay at zero frequency, in samples."""
    power = np.arange(3.0)
    ahead = sos[:, :3] @ power / sos[:, :3].sum(axis=1)
    behind = sos[:, 3:] @ power / sos[:, 3:].sum(axis=1)
    return float(np.sum(ahead - behind))
