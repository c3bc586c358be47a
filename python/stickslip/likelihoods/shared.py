"""Numbers that all windows share, and what is known of them before the readings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Number:
    """
    One number of a hypothesis in the coordinate it is fitted in.

    Parameters
    ----------
    name : as `Model.parameters` has it, or `gain.x1`
    start : where a fit starts, in the coordinate
    centre, sd : of its prior; infinite where it has none
    logarithmic : whether the coordinate is the logarithm
    run : the one run that it belongs to; None: all
    low, high : bounds of the coordinate
    stride : the most that a step moves it
    long_tail : whether the prior is Student's t
    """

    name: str
    start: float
    centre: float
    sd: float
    logarithmic: bool = False
    run: int | None = None
    low: float = -math.inf
    high: float = math.inf
    stride: float = math.inf
    long_tail: bool = False

    def value(self, at: float) -> float:
        """Return the number at a coordinate."""
        return math.exp(at) if self.logarithmic else at

    def slope(self, at: float) -> float:
        """Return d number/d coordinate."""
        return math.exp(at) if self.logarithmic else 1.0


def priors(numbers: Sequence[Number], at: Floats, tail: float) -> tuple[Floats, Floats]:
    """
    Return how far the prior's centre lies from `at`, and its precision there, (p,) each.

    A long tail is a Gaussian whose precision falls with the distance.
    """
    away = np.array([n.centre for n in numbers]) - at
    sd = np.array([n.sd for n in numbers])
    away[~np.isfinite(sd)] = 0.0
    precision = np.where(np.isfinite(sd), 1.0 / sd**2, 0.0)
    long = np.array([n.long_tail for n in numbers])
    weight = np.where(long, (tail + 1) / (tail + precision * away**2), 1.0)
    return away, precision * weight


def penalty(numbers: Sequence[Number], at: Floats, tail: float) -> float:
    """Return -2 log prior at `at`, without constants."""
    away, _ = priors(numbers, at, tail)
    sd = np.array([n.sd for n in numbers])
    z = np.where(np.isfinite(sd), (away / sd) ** 2, 0.0)
    long = np.array([n.long_tail for n in numbers])
    return float(np.where(long, (tail + 1) * np.log1p(z / tail), z).sum())
