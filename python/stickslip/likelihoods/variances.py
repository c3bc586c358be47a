"""Scatter and noise by the largest marginal likelihood; each scatter may be as good as 0."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from stickslip.likelihoods.mixed import Floats, Solution, Windows, solve, taken
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import LENGTH, Population, factor, parts, spreads, start

LEAST, MOST = 1e-5, 0.5  # standard deviations sought; the least is nothing
SHORTEST, LONGEST = 0.03, 5.0  # correlation lengths sought, over the way slipped
NEARBY = 1e-4  # step of the length's logarithm
NOISE = (0.3, 1e4)  # factors of the noise's variance sought


@dataclass(frozen=True)
class Estimate:
    """
    The population that makes the readings most likely.

    Parameters
    ----------
    population, noise : what was estimated; variances of the channels
    solution : what the windows say there
    deviance : -2 log marginal likelihood with the population's prior, of the linearised windows
    held : the prior's part of it
    """

    population: Population
    noise: Floats
    solution: Solution
    deviance: float
    held: float


def estimate(
    windows: Windows,
    places: list[Floats],
    population: Population,
    noise: Floats,
    prior: tuple[Floats, Floats],
    at: Floats,
    policy: Policy,
    turns: int,
) -> Estimate:
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
    """
    centre, spread = start(policy).coordinates(), spreads(policy)
    low = np.log([LEAST, LEAST, SHORTEST, LEAST, LEAST])
    high = np.log([MOST, MOST, LONGEST, MOST, MOST])
    free = Deviance(windows, places, prior, at, centre, spread)
    first = np.concatenate([np.clip(population.coordinates(), low, high), np.log(noise)])
    bounds = [*zip(low, high, strict=True), *[tuple(np.log(NOISE))] * len(noise)]
    x = first
    if turns:
        best = minimize(free, first, method="L-BFGS-B", jac=True, bounds=bounds, options={"maxiter": turns})
        x = np.asarray(best.x)
    solved = free.solved(x)
    held = free.held(x)
    return Estimate(Population.at(x[:5]), np.exp(x[5:]), solved, solved.deviance + held, held)


@dataclass
class Deviance:
    """The deviance of population and noise with its slopes; shared and own numbers at their best."""

    windows: Windows
    places: list[Floats]
    prior: tuple[Floats, Floats]
    at: Floats
    centre: Floats
    spread: Floats

    def solved(self, x: Floats) -> Solution:
        """Return the windows solved at a population and a noise."""
        return solve(
            self.windows, factor(Population.at(x[:5]), self.places), np.exp(x[5:]), *self.prior, self.at
        )

    def __call__(self, x: Floats) -> tuple[float, Floats]:
        """Return the deviance and its slopes."""
        roots, noise = factor(Population.at(x[:5]), self.places), np.exp(x[5:])
        found = solve(self.windows, roots, noise, *self.prior, self.at)
        away = (x[:5] - self.centre) / self.spread
        slope = np.zeros(len(x))
        white = np.diagonal(found.inverse, axis1=1, axis2=2)[:, self.windows.own :]
        # a factor's columns scale with their standard deviation, and the white numbers are at their best
        each = 2 * (1 - white - found.white**2).sum(axis=0)
        for part, columns in parts(len(self.places[0])).items():
            slope[part] = each[columns].sum()
        slope[LENGTH] = self._of_length(x, found.deviance)
        slope[:5] += 2 * away / self.spread
        count = (self.windows.count * self.windows.weight[:, None]).sum(axis=0)
        slope[5:] = count - found.misfit.sum(axis=0) / noise - taken(self.windows, roots, found, noise)
        return found.deviance + float(away @ away), slope

    def held(self, x: Floats) -> float:
        """Return -2 log prior of a population."""
        return float((((x[:5] - self.centre) / self.spread) ** 2).sum())

    def _of_length(self, x: Floats, here: float) -> float:
        moved = x.copy()
        moved[LENGTH] += NEARBY
        return (self.solved(moved).deviance - here) / NEARBY
