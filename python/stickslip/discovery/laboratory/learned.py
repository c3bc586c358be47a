"""A curve that no name explains, as it was scored."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.score import Columns

Floats = NDArray[np.float64]
Factors = Sequence[Floats | None]


@dataclass(frozen=True)
class Learned:
    """
    A curve that was scored.

    Parameters
    ----------
    where, variable : the place it acts and what it depends on
    gain : fall of -2 log marginal likelihood
    x, value, std : (k,) the curve and its standard deviation
    count : shapes that it is made of
    columns, size : behind it, and their numbers
    events : what it adds to each window's random effects, of a force or a factor of friction or of the belt's speed
    threshold : what the best of all curves gains, prices paid, where nothing is lacking
    period : of one that repeats, at a phase of its own in each run
    """

    where: str
    variable: str
    gain: float
    x: Floats
    value: Floats
    std: Floats
    count: int
    columns: Columns
    size: Floats
    events: Factors | None = None
    threshold: float = math.inf
    period: float | None = None

    def worth(self, windows: int) -> float:
        """Return the gain less the price of the curve's shapes."""
        return self.gain - self.count * math.log(windows)
