"""What a fit leaves of windows that it has not seen: every third is left out in turn, what it shares is solved anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.fit_state import Fit, soft
from stickslip.likelihoods.mixed import solve
from stickslip.likelihoods.population import AnyScatter, Population, factor

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Unseen = tuple[Floats, Mask]
FOLDS = 3
EXACT = 1e12  # precision of what is known from the other windows


def deviances(fit: Fit, population: AnyScatter, noise: Floats) -> Unseen:
    """
    Return -2 log marginal likelihood of each window, (w,), to first order about a fit without shared numbers.

    A window counts by its logarithm beyond the knee, as in a fit: one that goes astray says no more than that. NaN of
    one that cannot be simulated. The second says which windows are explained, (w,): what no hypothesis explains speaks
    for none.

    Parameters
    ----------
    fit : of windows that a model was not fitted to
    population, noise : what scatter and noise are, as the model has them
    """
    assert fit.linear is not None
    windows, good = fit.windows, fit.linear.weight > 0
    linear = replace(fit.linear, weight=good.astype(np.float64))
    none = np.zeros(len(windows.numbers))
    known = none, EXACT * np.eye(len(none))
    found = solve(linear, factor(population, windows.places), noise, *known, fit.random)
    left, count = (found.misfit / noise).sum(axis=1), windows.sizes * windows.channels
    chi = soft(left, windows.policy.knee * count)
    volume = linear.count @ np.log(noise) - np.linalg.slogdet(found.inverse)[1]
    out = np.where(good, chi + (found.white**2).sum(axis=1) + volume, np.nan)
    return out, good & (left <= windows.policy.noise_left * count)


def falls(was: Unseen, now: Unseen) -> list[float]:
    """
    Return by how much -2 log likelihood of windows falls which both can simulate, and one of them explains.

    Parameters
    ----------
    was, now : of the same windows, as of `deviances`
    """
    fell = was[0] - now[0]
    return [float(one) for one in fell[np.isfinite(fell) & (was[1] | now[1])]]


def held_out(fit: Fit, population: Population, noise: Floats) -> float:
    """
    Return what is left of all windows, each predicted from the others: squares over the noise and over the scatter.

    A window's own numbers (its start, its friction) are its own here too, so scatter that takes what is lacking must
    cost. To first order about the fit: nothing is simulated.

    Parameters
    ----------
    fit : linearised, at its best
    population, noise : what scatter and noise are taken to be; the same for fits that are held against each other

    Examples
    --------
    ``held_out(beside, p, noise) / held_out(null, p, noise)`` is the square of an effect's error over that without it.
    """
    assert fit.linear is not None
    linear, count = fit.linear, len(fit.windows.numbers)
    roots = factor(population, fit.windows.places)
    every, left = np.arange(len(linear.weight)), 0.0
    for fold in range(FOLDS):
        out = every % FOLDS == fold
        seen = replace(linear, weight=np.where(out, 0.0, linear.weight))
        bounds = fit.windows.steps(fit.at)
        rest = solve(seen, roots, noise, *fit.windows.prior.at(fit.at), fit.random, bounds=bounds)
        unseen = replace(linear, weight=np.where(out, linear.weight, 0.0))
        known = rest.shared, EXACT * np.eye(count)
        there = solve(unseen, roots, noise, *known, fit.random)
        left += float((there.misfit / noise).sum() + (there.white[out] ** 2).sum())
    return left
