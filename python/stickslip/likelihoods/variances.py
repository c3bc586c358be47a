"""Scatter and noise by the largest marginal likelihood; each scatter may be 0."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from stickslip.likelihoods.mixed import Floats, Solution, Windows, solve
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.likelihoods.population import Part, factor


@dataclass(frozen=True)
class Estimate:
    """
    The population that makes the readings most likely.

    Parameters
    ----------
    sd : standard deviation of each part
    noise : variance of each channel
    solution : what the windows say there
    """

    sd: Floats
    noise: Floats
    solution: Solution


def estimate(
    windows: Windows, parts: Sequence[Part], mean: Floats, precision: Floats, policy: Policy = POLICY
) -> Estimate:
    """
    Estimate scatter and noise.

    Parameters
    ----------
    windows : the linearised windows, weighted so that the declared noise is 1
    parts : sources of scatter
    mean, precision : prior of the shared step
    policy : what steers the estimate
    """
    k = len(parts)

    def at(x: Floats) -> tuple[Floats, Floats]:
        return policy.start_sd * x[:k], np.exp(x[k:])

    def deviance(x: Floats) -> float:
        sd, noise = at(x)
        return solve(windows, factor(parts, sd), noise, mean, precision).deviance

    channels = windows.gram.shape[1]
    best = minimize(
        deviance,
        np.concatenate([np.ones(k), np.zeros(channels)]),
        method="L-BFGS-B",
        bounds=[(0.0, None)] * k + [(None, None)] * channels,
        options={"maxiter": policy.most_turns, "gtol": policy.gradient_tolerance},
    )
    sd, noise = at(best.x)
    return Estimate(sd, noise, solve(windows, factor(parts, sd), noise, mean, precision))
