"""Windows of a run never fitted, with all known that is not its own, and how likely they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit import ALONE, fitted
from stickslip.likelihoods.fit_state import Fit, begin
from stickslip.likelihoods.held_out import Unseen, deviances
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.single_windows import settled
from stickslip.likelihoods.stretches import Stretch, stretches

EXACT = 1e-6  # standard deviation of what is known
PHASES = 12  # of a turn, tried for a phase that is another in every run


def of_run(fit: Fit, run: Data, cut: Sequence[Stretch]) -> Fit | None:
    """
    Return the windows of a run fitted with all known that is not its own; None where they cannot be.

    A phase that is another in every run is its own, and so is what differs from window to window.

    Parameters
    ----------
    fit : of other runs
    run, cut : never fitted, and its windows
    """
    windows = fit.windows
    assert isinstance(windows, BeltWindows)
    if not cut:
        return None
    shared = {n.name: float(x) for n, x in zip(windows.numbers, fit.at, strict=True)}
    numbers = []
    for n in windows.numbers:
        if n.run in (None, 0):
            held = replace(n, start=shared[n.name], centre=shared[n.name], sd=EXACT)
            numbers.append(held if n.run is None else replace(n, centre=0.0, sd=math.inf))
    own = BeltWindows(windows.model, [run], cut, numbers, Declared(), windows.sensors, windows.policy)
    turns = [i for i, n in enumerate(numbers) if n.run is not None]
    best, least = None, np.inf
    for phase in np.arange(PHASES) * 2 * math.pi / PHASES if turns else [0.0]:
        first = begin(own)
        first = replace(first, population=fit.population, noise=fit.noise)
        first.at[turns] = phase
        numbers_of_own, _, cost = settled(first, ALONE)
        if cost.sum() < least:
            best, least = replace(first, own=numbers_of_own), float(cost.sum())
    return best if best is None or not turns else _at_best(best)


def likely(fit: Fit, run: Data) -> Unseen | None:
    """
    Return how likely the windows of a run never fitted are, None where they cannot be fitted.

    Each is weighed as windows of the fit are, so that both sorts say as much by as much; an ensemble of forecasts has
    the next event's friction in it, beside which most of what a model lacks is not seen.

    Parameters
    ----------
    fit : of other runs
    run : never fitted
    """
    held = of_run(fit, run, stretches([run], fit.windows.policy))
    if held is not None and held.linear is None:
        held = _at_best(held)
    return None if held is None else deviances(held, fit.population, fit.noise)


def _at_best(there: Fit) -> Fit | None:
    """A fit of a run's own numbers, population and noise as they are."""
    policy = there.windows.policy
    try:
        return fitted(there, policy, held=policy.most_steps)
    except (FloatingPointError, np.linalg.LinAlgError):
        return None
