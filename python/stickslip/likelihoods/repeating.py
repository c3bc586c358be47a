"""Whether events differ at all, and whether a fit with events of their own is a model of the windows."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.fit_state import Fit, unexplained
from stickslip.likelihoods.population import MOST
from stickslip.likelihoods.shown_levels import shown_levels, shown_scatter

ENOUGH = 3  # windows of a run that may differ
FENCE = 3.0  # quartiles' distances from the quartiles to Tukey's outer fences


def lost(fit: Fit) -> bool:
    """Return whether a fit is no model of its windows: many do not count, or scatter ends at its bound."""
    assert fit.linear is not None
    weight = fit.linear.weight
    if weight.sum() < (1 - fit.windows.policy.lost_windows) * len(weight):
        return True
    return bool(max(fit.population.friction) >= 0.99 * MOST)


def explained(fit: Fit) -> bool:
    """Return whether a fit is a model of its windows, their readings' noise included."""
    return not lost(fit) and unexplained(fit) < fit.windows.policy.noise_left


def swollen(fit: Fit) -> bool:
    """Return whether friction scatters by more than the prior's width: what is lacking may pose as scatter."""
    policy = fit.windows.policy
    usual = max(policy.level_sd, policy.curve_sd, policy.static_sd)
    return bool(max(fit.population.friction) > usual * math.exp(policy.scatter_spread))


def wild(fit: Fit) -> bool:
    """Return whether friction on a belt scatters by more than it can, or the belt's speed by all it may."""
    return beyond_shown(fit) or bool(fit.population.belt >= 0.99 * fit.windows.policy.wildest_belt)


def beyond_shown(fit: Fit) -> bool:
    """
    Return whether friction scatters by more than the prior's width, and by more than events show by themselves.

    What they show needs no model; so many of them show it but for what chance makes of that.
    """
    if not swollen(fit):
        return False
    if (own := shown_levels(fit.windows, fit.at)) is None:
        return True
    shown, chance = shown_scatter(fit.windows, own), 1 + 2 / math.sqrt(2 * len(own))
    return bool(max(fit.population.friction) > chance * max(shown.friction))


def unlike(fit: Fit) -> NDArray[np.bool_]:
    """
    Return which windows have friction or a belt like no other's, (w,): what is no stick was taken for one.

    They are beyond Tukey's outer fences, where chance has one of 400,000.
    """
    u = fit.random
    each = [u[:, list(fit.windows.statics)], u[:, fit.windows.kinetic].mean(axis=1, keepdims=True)]
    if fit.windows.belt is not None:
        each.append(u[:, [fit.windows.belt]])
    numbers = np.concatenate(each, axis=1)
    low, high = np.quantile(numbers, [0.25, 0.75], axis=0)
    beyond = FENCE * (high - low)
    return np.asarray(((numbers < low - beyond) | (numbers > high + beyond)).any(axis=1))


def repeats(fit: Fit) -> bool:
    """
    Return whether every event of a run is like every other, so that what is left is noise of the readings alone.

    What no name explains also swells the population, but alike in all events of a run.
    """
    apart = []
    for members in fit.windows.by_run:
        if len(members) < ENOUGH:
            continue
        u = fit.random[members]
        whole = u[:, fit.windows.kinetic].mean(axis=1)
        apart.append((np.var(whole, ddof=1), np.var(whole + u[:, 0], ddof=1)))
    return not apart or float(np.sqrt(np.mean(apart, axis=0)).max()) < fit.windows.policy.repeats
