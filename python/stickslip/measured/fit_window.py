"""A window: a stretch of one run that a fit meets with one simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Window:
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
    """

    run: int
    belt_speed: float
    t: Array
    readings: Array
    columns: tuple[int, ...]
    initial: Array
    free: tuple[str, ...]
    local: Mapping[str, float] = field(default_factory=dict)
