"""A curve that no name explains, as it was scored."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated
from stickslip.likelihoods.score import Columns

Floats = NDArray[np.float64]
Factors = Sequence[Floats | None]
DRAWN = 49  # places between the outer knots


@dataclass(frozen=True)
class ScoredCurve:
    """
    A curve that was scored.

    Parameters
    ----------
    where, variable : the place it acts and what it depends on
    gain : fall of -2 log marginal likelihood
    x, value, std : (k,) the curve and its standard deviation
    count : shapes that it is made of
    columns : behind it
    free : (k, count) its shapes by the values at its knots: what is left of all but the law's own level
    effect : what it is in a model; None for one of the belt, or one that repeats
    width : standard deviation of its values before the readings
    events : what it adds to each window's random effects, of the belt's speed
    threshold : what the best of all curves gains, prices paid, where nothing is lacking
    period : of one that repeats, at a phase of its own in each run
    told : what its values are worth by their own errors, once it is fitted: a fall that they do not tell is what the
        fit without it was short of
    """

    where: str
    variable: str
    gain: float
    x: Floats
    value: Floats
    std: Floats
    count: int
    columns: Columns
    free: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    effect: Tabulated | None = None
    width: float = math.inf
    events: Factors | None = None
    threshold: float = math.inf
    period: float | None = None
    told: float = math.inf

    def fitted(self, values: Floats, covariance: Floats, gain: float) -> ScoredCurve:
        """
        Return the curve as it was fitted: the values of the model, whose law goes with their level.

        Where the law has a level of its own, errors are those of what is beside it.
        """
        k = len(values)
        own = apart = np.eye(k)
        if self.count < k:
            weights = scipy.linalg.null_space(self.free.T)[:, 0]  # of a mean over all slips
            own, apart = own - weights / weights.sum(), own[1:] - own[0]
        std = np.sqrt(np.maximum(np.diag(own @ covariance @ own.T), 0.0))
        size, of = apart @ values, apart @ covariance @ apart.T
        told = float(size @ np.linalg.pinv(of, hermitian=True) @ size)
        return replace(self, value=values, std=std, gain=gain, told=told)

    def drawn(self) -> tuple[Floats, Floats, Floats]:
        """Return the curve and its standard deviation at places near enough to each other to be drawn, (n,) each."""
        if self.period is not None:
            return self.x, self.value, self.std
        x = np.union1d(self.x, np.linspace(self.x[0], self.x[-1], DRAWN))
        spline = scipy.interpolate.CubicSpline(self.x, self.value, bc_type="natural")
        return x, np.asarray(spline(x)), np.interp(x, self.x, self.std)

    def worth(self, windows: int) -> float:
        """Return the gain less the price of the curve's shapes."""
        return self.gain - self.count * math.log(windows)

    def passes(self, windows: int) -> bool:
        """Return whether the curve is beyond what scatter alone gains, by the fall and by its values."""
        return min(self.gain, self.told) - self.count * math.log(windows) > self.threshold
