"""Scatter and noise by the largest marginal likelihood; each scatter may be as good as 0."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from stickslip.likelihoods.mixed import Floats, Solution, Windows, solve
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import Population, factor, spreads, start

LEAST, MOST = 1e-5, 0.5  # standard deviations sought; the least is nothing
SHORTEST, LONGEST = 0.03, 5.0  # correlation lengths sought, over the way slipped
NOISE = (0.3, 1e4)  # factors of the noise's variance sought


@dataclass(frozen=True)
class Estimate:
    """
    The population that makes the readings most likely.

    Parameters
    ----------
    population, noise : what was estimated; variances of the channels
    solution : what the windows say there
    deviance : -2 log marginal likelihood with the population's prior
    """

    population: Population
    noise: Floats
    solution: Solution
    deviance: float


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
    channels = len(noise)

    def solved(x: Floats) -> Solution:
        return solve(windows, factor(Population.at(x[:5]), places), np.exp(x[5:]), *prior, at)

    def deviance(x: Floats) -> float:
        return solved(x).deviance + float((((x[:5] - centre) / spread) ** 2).sum())

    first = np.concatenate([np.clip(population.coordinates(), low, high), np.log(noise)])
    bounds = [*zip(low, high, strict=True), *[tuple(np.log(NOISE))] * channels]
    if turns:
        best = minimize(deviance, first, method="L-BFGS-B", bounds=bounds, options={"maxiter": turns, "eps": 1e-4})
        x = best.x
    else:
        x = first
    return Estimate(Population.at(x[:5]), np.exp(x[5:]), solved(x), deviance(x))
