"""The times of a recording: gaps, repeats and irregular sampling, detected and said."""

import math
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


_PIECE = 1 << 20  # steps that are looked at together


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
    dt = usual_step(times)
    if not dt > 0.0:
        raise InputError("t never increases; are the columns swapped?")
    parts = [_looked_at(times, first, dt, allowed) for first in range(0, times.size - 1, _PIECE)]
    gaps, duplicates, backward, irregular = (np.concatenate([part[i] for part in parts]) for i in range(4))
    ordinary, mean = sum(part[4] for part in parts), 0.0
    if ordinary:
        mean = sum(part[4] * part[5] for part in parts) / ordinary
    spread = sum(part[4] * (part[6] ** 2 + (part[5] - mean) ** 2) for part in parts) / max(ordinary, 1)
    return TimeBase(
        samples=times.size,
        dt=dt,
        jitter=math.sqrt(spread) / dt,
        gaps=np.column_stack([times[gaps], times[gaps + 1]]),
        missing=_missing(times[gaps + 1] - times[gaps], dt),
        duplicates=duplicates + 1,
        backward=backward + 1,
        irregular=irregular + 1,
    )


def _missing(widths: Floats, dt: float) -> int:
    """How many samples are missing in gaps (n,); of a time that is next to infinite, no more than can be counted."""
    with np.errstate(over="ignore"):
        steps = np.minimum(np.rint(widths / dt), 2.0**53)
    return int(np.sum(np.maximum(steps - 1.0, 0.0)))


def usual_step(t: Floats) -> float:
    """Return the median of the steps of times (n,) that increase; of many, of those at places evenly apart. 0: none."""
    every = max(1, (t.size - 1) // _PIECE)
    step = t[1::every] - t[:-1:every]
    forward = step[step > 0.0]
    if forward.size == 0 and every > 1:
        step = np.diff(t)
        forward = step[step > 0.0]
    return float(np.median(forward)) if forward.size else 0.0


_Part = tuple[Indices, Indices, Indices, Indices, int, float, float]


def _looked_at(times: Floats, first: int, dt: float, allowed: float) -> _Part:
    """Gaps, repeated, backward and irregular steps from sample `first` on; number, mean and scatter of the others."""
    step = np.diff(times[first : first + _PIECE + 1])
    gap = step > 1.5 * dt
    ordinary = (step > 0.0) & ~gap
    irregular = ordinary & (np.abs(step - dt) > allowed * dt)
    usual = step[ordinary]
    mean, scatter = (float(usual.mean()), float(usual.std())) if usual.size else (0.0, 0.0)
    kinds = (gap, step == 0.0, step < 0.0, irregular)
    one, two, three, four = (np.flatnonzero(kind) + first for kind in kinds)
    return one, two, three, four, usual.size, mean, scatter
