"""The times of a recording: gaps, repeats and irregular sampling, detected and said."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained
from stickslip.errors import InputError
from stickslip.measured.signals._input import Floats, finite_vector, positive

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class TimeBase:
    """What `check_time_base` found.

    Attributes
    ----------
    samples : int
        How many times there are.
    dt : float
        Sampling interval: the median of the increasing steps [time].
    jitter : float
        Standard deviation of the ordinary steps over `dt`.
    gaps : ndarray, shape (k, 2)
        Times before and after each step longer than 1.5 `dt`.
    missing : int
        Samples that would fill the gaps.
    duplicates, backward, irregular : ndarray of int
        Samples whose time equals, precedes, or follows off schedule that of the sample before.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import signals
    >>> base = signals.check_time_base(np.arange(100) / 50)
    >>> base.regular, round(base.dt, 6)
    (True, 0.02)
    """

    samples: int
    dt: float
    jitter: float
    gaps: Floats
    missing: int
    duplicates: Indices
    backward: Indices
    irregular: Indices

    @property
    def increasing(self) -> bool:
        """No time repeats or goes back."""
        return not (self.duplicates.size or self.backward.size)

    @property
    def regular(self) -> bool:
        """Equally spaced throughout, as (3.1) and the low-pass filters need."""
        return self.increasing and not (self.gaps.size or self.irregular.size)

    @property
    def problems(self) -> list[str]:
        """One sentence for each kind of fault, with the first place it occurs; empty if regular."""
        said = []
        if self.backward.size:
            said.append(f"time goes back at {_count(self.backward)}")
        if self.duplicates.size:
            said.append(f"the same time is given twice at {_count(self.duplicates)}")
        if self.gaps.size:
            first, last = self.gaps[0]
            said.append(
                f"{len(self.gaps)} gap(s), {self.missing} sample(s) missing, "
                f"the first from t = {first:g} to {last:g}"
            )
        if self.irregular.size:
            said.append(f"steps differ from dt = {self.dt:g} at {_count(self.irregular)}")
        return said

    def require_increasing(self, name: str = "t") -> None:
        """Raise `InputError` unless the times increase."""
        if not self.increasing:
            raise InputError(f"{name}: {self.problems[0]}; times must increase")

    def require_regular(self, name: str = "t") -> None:
        """Raise `InputError` unless the times are equally spaced."""
        if not self.regular:
            raise InputError(f"{name}: {'; '.join(self.problems)}; equally spaced samples are needed here")


def _count(where: Indices) -> str:
    return f"sample {where[0]}" if where.size == 1 else f"{where.size} samples, the first {where[0]}"


@explained
def check_time_base(t: ArrayLike, *, tolerance: float = 0.01) -> TimeBase:
    """Look for gaps, repeated, backward and irregular times.

    Parameters
    ----------
    t : array_like, shape (n,)
        Times, n >= 2.
    tolerance : float
        A step is irregular if it differs from the median one by more than this fraction.

    Returns
    -------
    TimeBase

    Raises
    ------
    InputError
        If a time is not finite, there are fewer than two, or none increases.

    Examples
    --------
    >>> from stickslip import signals
    >>> found = signals.check_time_base([0.0, 0.1, 0.2, 0.5, 0.6])
    >>> found.dt, found.missing
    (0.1, 2)
    >>> found.problems
    ['1 gap(s), 2 sample(s) missing, the first from t = 0.2 to 0.5']
    """
    times = finite_vector(t, "t", at_least=2)
    allowed = positive(tolerance, "tolerance")
    step = np.diff(times)
    forward = step[step > 0.0]
    if forward.size == 0:
        raise InputError("t never increases; are the columns swapped?")
    dt = float(np.median(forward))
    gap = step > 1.5 * dt
    ordinary = (step > 0.0) & ~gap
    irregular = ordinary & (np.abs(step - dt) > allowed * dt)
    at = np.flatnonzero(gap)
    return TimeBase(
        samples=times.size,
        dt=dt,
        jitter=float(np.std(step[ordinary] / dt)) if ordinary.any() else 0.0,
        gaps=np.column_stack([times[at], times[at + 1]]),
        missing=int(np.sum(np.maximum(np.rint(step[gap] / dt) - 1.0, 0.0))),
        duplicates=np.flatnonzero(step == 0.0) + 1,
        backward=np.flatnonzero(step < 0.0) + 1,
        irregular=np.flatnonzero(irregular) + 1,
    )
