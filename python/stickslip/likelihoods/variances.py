"""Scatter and noise by the largest marginal likelihood; each scatter may be as good as 0."""

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from scipy.optimize import minimize

from stickslip.likelihoods.mixed import Bounds, Floats, Solution, WindowProducts, solve, taken
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import AnyScatter

NEARBY = 1e-4  # step of the length's logarithm
NOISE = (0.3, 1e4)  # factors of the noise's variance sought


P = TypeVar("P", bound=AnyScatter)


@dataclass(frozen=True)
class PopulationEstimate(Generic[P]):
    """
    The population that makes the readings most likely.

    Parameters
    ----------
    population, noise : what was estimated; variances of the channels
    solution : what the windows say there
    deviance : -2 log marginal likelihood with the population's prior, of the linearised windows
    held : the prior's part of it
    """

    population: P
    noise: Floats
    solution: Solution
    deviance: float
    held: float


def estimate(
    windows: WindowProducts,
    places: list[Floats],
    population: P,
    noise: Floats,
    prior: tuple[Floats, Floats],
    at: Floats,
    policy: Policy,
    turns: int,
    bounds: Bounds | None = None,
) -> PopulationEstimate[P]:
    """
    Estimate scatter and noise from where they are.

    Parameters
    ----------
    windows : the linearised windows, weighted so that the declared noise is 1
    places : of the runs' curves
    population, noise : where to start
    prior : mean and precision of the shared step
    at : random effects that the windows are linearised at
    policy : what steers the estimate
    turns : steps of the optimiser, at most
    bounds : least and largest shared step
    """
    k = len(population.coordinates())
    low, high = population.bounds(policy)
    free = Deviance(windows, places, prior, at, population, *population.usual(policy), bounds)
    first = np.concatenate([np.clip(population.coordinates(), low, high), np.log(noise)])
    limits = [*zip(low, high, strict=True), *[tuple(np.log(NOISE))] * len(noise)]
    x = first
    if turns:
        best = minimize(free, first, method="L-BFGS-B", jac=True, bounds=limits, options={"maxiter": turns})
        x = np.asarray(best.x)
    solved = free.solved(x)
    held = free.held(x)
    return PopulationEstimate(population.moved(x[:k]), np.exp(x[k:]), solved, solved.deviance + held, held)


@dataclass
class Deviance:
    """The deviance of population and noise with its slopes; shared and own numbers at their best."""

    windows: WindowProducts
    places: list[Floats]
    prior: tuple[Floats, Floats]
    at: Floats
    like: AnyScatter
    centre: Floats
    spread: Floats
    bounds: Bounds | None = None

    def solved(self, x: Floats) -> Solution:
        """Return the windows solved at a population and a noise."""
        population, noise = self._split(x)
        return solve(
            self.windows, population.factor(self.places), noise, *self.prior, self.at, bounds=self.bounds
        )

    def _split(self, x: Floats) -> tuple[AnyScatter, Floats]:
        k = len(self.centre)
        return self.like.moved(x[:k]), np.exp(x[k:])

    def __call__(self, x: Floats) -> tuple[float, Floats]:
        """Return the deviance and its slopes."""
        k = len(self.centre)
        population, noise = self._split(x)
        roots = population.factor(self.places)
        found = solve(self.windows, roots, noise, *self.prior, self.at, bounds=self.bounds)
        away = (x[:k] - self.centre) / self.spread
        slope = np.zeros(len(x))
        white = np.diagonal(found.inverse, axis1=1, axis2=2)[:, self.windows.own :]
        # a factor's columns scale with their standard deviation, and the white numbers are at their best
        each = 2 * (1 - white - found.white**2).sum(axis=0)
        parts = population.parts(self.places)
        for part, columns in parts.items():
            slope[part] = each[columns].sum()
        for one in set(range(k)) - parts.keys():
            slope[one] = self._of_length(x[:k], roots, found, one)
        slope[:k] += 2 * away / self.spread
        count = (self.windows.count * self.windows.weight[:, None]).sum(axis=0)
        slope[k:] = count - found.misfit.sum(axis=0) / noise - taken(self.windows, roots, found, noise)
        return found.deviance + float(away @ away), slope

    def held(self, x: Floats) -> float:
        """Return -2 log prior of a population."""
        k = len(self.centre)
        return float((((x[:k] - self.centre) / self.spread) ** 2).sum())

    def _of_length(self, x: Floats, roots: Floats, found: Solution, one: int) -> float:
        """The slope by a number that turns a factor's columns among themselves; no window is solved again."""
        away = NEARBY * (np.arange(len(x)) == one)
        ahead, behind = (self.like.moved(x + step).factor(self.places) for step in (away, -away))
        changed = (ahead - behind) / (2 * NEARBY)
        moved = changed.any(axis=(0, 1))
        turn = (np.linalg.pinv(roots[:, :, moved]) @ changed[:, :, moved])[self.windows.run]
        own = self.windows.own
        known = np.eye(int(moved.sum())) - found.inverse[:, own:, own:][:, moved][:, :, moved]
        white = found.white[:, moved]
        return 2 * float(np.einsum("wij,wji->", known, turn) - np.einsum("wi,wij,wj->", white, turn, white))
