"""Numbers that all windows share, and what is known of them before the readings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
JITTER = 1e-12  # relative, on the diagonal of a covariance whose numbers may follow from one another


@dataclass(frozen=True)
class SharedNumber:
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

    def value(self, at: float) -> float:
        """Return the number at a coordinate."""
        return math.exp(at) if self.logarithmic else at

    def slope(self, at: float) -> float:
        """Return d number/d coordinate."""
        return math.exp(at) if self.logarithmic else 1.0

    @property
    def usual(self) -> float:
        """How far it usually goes, in its unit: 0 says nothing of that. 1 where that is not known."""
        if self.logarithmic:  # it says so itself
            return 1.0
        return next((x for x in (self.sd, self.stride) if 0 < x < math.inf), 1.0)


@dataclass(frozen=True)
class Declared:
    """
    What a laboratory says of its constants together: they follow from masses and stiffnesses that several share.

    Parameters
    ----------
    names : of the constants and gains
    covariance : (n, n) of their coordinates
    gains : the channel of every name that is a gain's
    """

    names: tuple[str, ...] = ()
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    gains: Mapping[str, str] = field(default_factory=dict)


class Prior:
    """
    The prior of the shared numbers: each alone, and the declared constants together with long tails.

    Parameters
    ----------
    numbers : in the order of a fit's vector
    declared : of the constants among them
    tail : degrees of freedom of Student's t, in the coordinates in which the constants are independent
    """

    def __init__(self, numbers: Sequence[SharedNumber], declared: Declared, tail: float) -> None:
        self.tail = tail
        self.centre = np.array([n.centre for n in numbers])
        sd = np.array([n.sd for n in numbers])
        self.alone = np.where(np.isfinite(sd), 1.0 / sd**2, 0.0)
        places = {n.name: i for i, n in enumerate(numbers)}
        kept = [i for i, name in enumerate(declared.names) if name in places]
        self.group = np.array([places[declared.names[i]] for i in kept], dtype=np.int64)
        self.alone[self.group] = 0.0
        covariance = declared.covariance[np.ix_(kept, kept)]
        # independent coordinates: a number that follows from others adds none
        root = np.linalg.cholesky(covariance + np.diag(JITTER + 1e-9 * np.diag(covariance)))
        self.whiten = np.linalg.inv(root)
        self.uncertainty = np.sqrt(np.diag(covariance))

    def _away(self, at: Floats) -> Floats:
        away = self.centre - at
        held = self.alone > 0
        held[self.group] = True
        return np.where(held, away, 0.0)

    def at(self, at: Floats) -> tuple[Floats, Floats]:
        """
        Return how far the centre lies from `at`, (p,), and the precision there, (p, p).

        A long tail is a Gaussian whose precision falls with the distance.
        """
        away = self._away(at)
        return away, self._precision(self.whiten @ away[self.group])

    def tight(self, at: Floats) -> tuple[Floats, Floats]:
        """Return the same for constants that stay where they are, as well known as declared however far off."""
        away = self._away(at)
        away[self.group] = 0.0
        return away, self._precision(np.zeros(len(self.group)))

    def _precision(self, z: Floats) -> Floats:
        weight = (self.tail + 1) / (self.tail + z**2)
        precision = np.diag(self.alone)
        precision[np.ix_(self.group, self.group)] = self.whiten.T @ (weight[:, None] * self.whiten)
        return precision

    def farthest(self, at: Floats) -> float:
        """Return by how many of its standard uncertainties the constant that is farthest off is off; 0 without any."""
        away = self._away(at)[self.group]
        return float(np.max(np.abs(away) / self.uncertainty, initial=0.0, where=self.uncertainty > 0))

    def as_declared(self, at: Floats) -> Floats:
        """Return `at` with every constant as declared, (p,)."""
        out = at.copy()
        out[self.group] = self.centre[self.group]
        return out

    def penalty(self, at: Floats) -> float:
        """Return -2 log prior at `at`, without constants."""
        away = self._away(at)
        z = self.whiten @ away[self.group]
        return float(self.alone @ away**2 + self._tails(z))

    def forgiven(self, at: Floats) -> float:
        """Return by how much the tails lower -2 log prior at `at`: what they forgive constants that are far off."""
        z = self.whiten @ self._away(at)[self.group]
        return float(z @ z - self._tails(z))

    def _tails(self, z: Floats) -> float:
        return float((self.tail + 1) * np.log1p(z**2 / self.tail).sum())
