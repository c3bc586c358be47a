"""A window as it was simulated."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class WindowMotion:
    """
    One window as simulated.

    Parameters
    ----------
    t : (n,) times of its samples
    state : (n, 9) states
    mode : (n,) -1, 0 in stick, 1
    readings : (n, channels)
    """

    t: Floats
    state: Floats
    mode: NDArray[np.int8]
    readings: Floats
