"""The population of a window's random effects: what friction and belt do differently each time.

Effects are ``factor @ b`` with b white. A factor instead of a covariance has no inverse, so a variance of 0 is a
point like any other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.scatter import EventScatter
from stickslip.likelihoods.policy import Policy

Floats = NDArray[np.float64]
STATIC = 0  # among a window's effects: its static friction; the curve, the belt's line and its mean follow
LEAST, MOST = 1e-5, 0.5  # standard deviations sought; the least is nothing
SHORTEST, LONGEST = 0.03, 5.0  # correlation lengths sought, over the way slipped


class AnyScatter(Protocol):
    """What differs from window to window on some rig: numbers whose logarithms are estimated."""

    @property
    def friction(self) -> Sequence[float]:
        """Standard deviations of friction."""

    def coordinates(self) -> Floats:
        """Return the logarithms, (k,)."""

    def moved(self, coordinates: Floats, /) -> Self:
        """Return the same with other numbers."""

    def factor(self, places: Sequence[Floats], /) -> Floats:
        """Return the factor of the random effects' covariance in each run, (runs, effects, white)."""

    def parts(self, places: Sequence[Floats], /) -> Mapping[int, slice | list[int]]:
        """Return the white columns of each coordinate that scales some; the others are correlation lengths."""

    def usual(self, policy: Policy, /) -> tuple[Floats, Floats]:
        """Return centre and width of the prior of the coordinates, (k,) each."""

    def bounds(self, policy: Policy, /) -> tuple[Floats, Floats]:
        """Return the least and the largest coordinates sought, (k,) each."""


@dataclass(frozen=True)
class Population:
    """
    Relative standard deviations of what differs from window to window.

    Parameters
    ----------
    level : of friction as a whole
    curve, length : of friction along the way slipped, and its correlation length over that way
    static : of static friction, beside what it shares with kinetic friction
    belt : of the belt's speed, which wanders slowly
    """

    level: float
    curve: float
    length: float
    static: float
    belt: float

    @property
    def friction(self) -> tuple[float, ...]:
        """Standard deviations of friction."""
        return self.level, self.curve, self.static

    def coordinates(self) -> Floats:
        """Return the logarithms, (5,)."""
        return np.log([self.level, self.curve, self.length, self.static, self.belt])

    def moved(self, coordinates: Floats) -> Population:
        """Return the population at logarithms."""
        return Population(*(float(x) for x in np.exp(coordinates)))

    def factor(self, places: Sequence[Floats]) -> Floats:
        """Return the factor of each run, (runs, effects, white)."""
        return _factors(self, np.stack(places))

    def parts(self, places: Sequence[Floats]) -> dict[int, slice | list[int]]:
        """Return the white columns of each coordinate that scales some."""
        k = places[0].shape[1]
        return {3: slice(0, 1), 0: slice(1, 2), 1: slice(2, k + 2), 4: slice(k + 2, 2 * k + 2)}

    def usual(self, policy: Policy) -> tuple[Floats, Floats]:
        """Return centre and width of the prior of the coordinates, (5,) each."""
        s = policy.scatter_spread
        return start(policy).coordinates(), np.array([s, s, policy.length_spread, s, s])

    def bounds(self, policy: Policy) -> tuple[Floats, Floats]:
        """Return the least and the largest coordinates sought, (5,) each."""
        low = np.log([LEAST, LEAST, SHORTEST, LEAST, LEAST])
        return low, np.log([MOST, MOST, LONGEST, MOST, policy.wildest_belt])

    def wider(self, times: float) -> Population:
        """Return the population whose friction differs so many times as much."""
        return replace(self, level=times * self.level, curve=times * self.curve, static=times * self.static)

    def without(self) -> Population:
        """Return the population in which nothing differs."""
        return replace(self, level=0.0, curve=0.0, static=0.0, belt=0.0)

    def declared(self) -> EventScatter:
        """Return it as a model carries it."""
        return EventScatter(self.level, self.curve, self.length, self.static, self.belt)


def population_of(scatter: EventScatter) -> Population:
    """Return the population that a model carries."""
    return Population(scatter.level, scatter.along, scatter.length, scatter.static, scatter.belt)


def start(policy: Policy) -> Population:
    """Return where an estimate starts."""
    return Population(policy.level_sd, policy.curve_sd, policy.curve_length, policy.static_sd, policy.belt_sd)


def factor(population: AnyScatter, places: Sequence[Floats]) -> Floats:
    """
    Return the factor of each run, (runs, effects, white).

    Parameters
    ----------
    population : its standard deviations
    places : for each run (2 + k, k): places of the curve over the way slipped, 0 to 1, then the belt's factor
    """
    return population.factor(places)


def _factors(p: Population, places: Floats) -> Floats:
    """The factors of runs, (runs, effects, white); places (runs, 2 + k, k)."""
    along, belt = places[:, 0], places[:, 1:]
    k = along.shape[1]
    out = np.zeros((len(places), 2 * k + 2, 2 * k + 2))
    out[:, STATIC, 0] = p.static
    out[:, 1 : k + 1, 1] = p.level
    out[:, 1 : k + 1, 2 : k + 2] = p.curve * _root(along, p.length)
    out[:, k + 1 :, k + 2 :] = p.belt * belt
    return out


def _root(places: Floats, length: float) -> Floats:
    """Return symmetric roots of Matern kernels of order 3/2: once differentiable, as worn surfaces are not more."""
    gap = np.sqrt(3.0) * np.abs(places[:, :, None] - places[:, None]) / length
    values, vectors = np.linalg.eigh((1 + gap) * np.exp(-gap))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0))[:, None] @ vectors.transpose(0, 2, 1))
