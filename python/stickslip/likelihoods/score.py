"""The score test: what further columns would gain, by one linear solve, everything else refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.mixed import WindowProducts, products, solve
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import factor
from stickslip.likelihoods.variances import estimate

Floats = NDArray[np.float64]
Columns = Sequence[Floats | None]  # of each window, (readings, channels, k), over the noise
TURNS = 12  # of the population's optimiser beside new columns


@dataclass(frozen=True)
class Score:
    """
    What columns would gain.

    Parameters
    ----------
    gain : fall of -2 log marginal likelihood
    size, covariance : of the columns' numbers, (k,), (k, k)
    step : of the shared numbers beside them, (p,)
    """

    gain: float
    size: Floats
    covariance: Floats
    step: Floats


def score(
    fit: Fit,
    columns: Columns,
    policy: Policy,
    *,
    place: Sequence[Sequence[int]] | None = None,
    count: int | None = None,
    precision: float = 0.0,
    refit: bool = True,
    tight: bool = False,
) -> Score:
    """
    Return what columns gain.

    Parameters
    ----------
    fit : the null, linearised
    columns : derivatives of the readings by the new numbers
    policy : what steers the estimate of the population
    place : for each window which of the `count` numbers its columns belong to; all by default
    count : how many numbers there are; as many as columns by default
    precision : of a Gaussian prior about 0 of the new numbers
    refit : whether the population is estimated anew beside them
    tight : whether the constants stay where they are, as well known as declared
    """
    k = count if count is not None else next(c.shape[2] for c in columns if c is not None)
    windows = beside(fit, columns, place, k)
    prior_of = fit.windows.prior
    away, held = prior_of.tight(fit.at) if tight else prior_of.at(fit.at)
    p = len(away)
    wide = np.zeros((p + k, p + k))
    wide[:p, :p], wide[range(p, p + k), range(p, p + k)] = held, precision
    prior = np.concatenate([away, np.zeros(k)]), wide
    bounds = fit.windows.steps(fit.at)
    beyond = np.full(k, np.inf)
    wider = np.concatenate([bounds[0], -beyond]), np.concatenate([bounds[1], beyond])
    if not refit:
        roots = factor(fit.population, fit.windows.places)
        there = solve(windows, roots, fit.noise, *prior, fit.random, bounds=wider)
        without = solve(plain(windows, p, k), roots, fit.noise, away, held, fit.random, bounds=bounds)
        gain, found = without.deviance - there.deviance, there
    else:
        # the null is at its best already
        best = estimate(
            windows, fit.windows.places, fit.population, fit.noise, prior, fit.random, policy, TURNS, wider
        )
        null = estimate(
            plain(windows, p, k),
            fit.windows.places,
            fit.population,
            fit.noise,
            (away, held),
            fit.random,
            policy,
            0,
            bounds,
        )
        gain, found = null.deviance - best.deviance, best.solution
    return Score(float(gain), found.shared[p:], found.covariance[p:, p:], found.shared[:p])


def beside(fit: Fit, columns: Columns, place: Sequence[Sequence[int]] | None, k: int) -> WindowProducts:
    """Return the fit's windows with `k` further shared numbers, the last ones."""
    assert fit.linear is not None
    p = len(fit.windows.numbers)
    blocks: list[Floats | None] = []
    for i, (block, column) in enumerate(zip(fit.blocks, columns, strict=True)):
        if block is None or column is None:
            blocks.append(None)
            continue
        wide = np.zeros((*block.shape[:2], k))
        wide[:, :, list(range(k)) if place is None else list(place[i])] = column
        blocks.append(np.concatenate([block[:, :, :p], wide, block[:, :, p:]], axis=2))
    made = products(blocks, fit.windows.runs, p + k, fit.windows.begins, fit.windows.channels)
    return replace(made, weight=made.weight * fit.linear.weight)


def plain(windows: WindowProducts, p: int, k: int) -> WindowProducts:
    """Return windows without the last `k` of their shared numbers."""
    kept = [i for i in range(windows.gram.shape[-1]) if not p <= i < p + k]
    return replace(windows, gram=windows.gram[:, :, kept][:, :, :, kept], shared=p)
