"""A window: a stretch of one run that a fit meets with one simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def half_apart(t: Array, averaged: int) -> float:
    """Half the distance of two instants whose mean is that of the `averaged` readings behind a row.

    The mean of k values of a cubic, h/k apart, is that of two values h sqrt((1 - 1/k^2)/12) on either side of its
    middle (Gauss-Legendre with two points, for a sum). `t` (n,) are the rows' times, h apart.
    """
    return 0.0 if averaged == 1 else float(np.median(np.diff(t)) * np.sqrt((1 - averaged**-2.0) / 12))


@dataclass(frozen=True)
class FitWindow:
    """A stretch of one run to be met by one simulation.

    Attributes
    ----------
    run : int
        Index of the run it is cut from.
    belt_speed : float
        v_b.
    t : (n,) array
        Times since the window's start.
    readings : (n, c) array
        Channels in the order of `columns`; NaN where a reading is missing.
    columns : tuple of int
        State column that each channel reads.
    initial : (d,) array
        Estimate of the state at t = 0.
    free : tuple of str
        Initial state components to estimate; the others (x2 = v_b in stick) are exact.
    local : mapping of str to float
        Law or rig parameters estimated for this window alone, with their starting values.
    averaged : int
        How many readings each row is the mean of: its noise is as much smaller as the root of it. `initial` is then
        the state at the first of `instants`.
    """

    run: int
    belt_speed: float
    t: Array
    readings: Array
    columns: tuple[int, ...]
    initial: Array
    free: tuple[str, ...]
    local: Mapping[str, float] = field(default_factory=dict)
    averaged: int = 1

    @property
    def middles(self) -> Array:
        """Times of the rows since the start of the simulation, (n,)."""
        return self.t + half_apart(self.t, self.averaged)

    @property
    def instants(self) -> Array:
        """Times since the start at which a simulation is asked: of the rows, or two for each mean, (n,) or (2 n,)."""
        if self.averaged == 1:
            return self.t
        return np.column_stack([self.t, self.t + 2 * half_apart(self.t, self.averaged)]).ravel()
