"""How friction of one event is like that of the event before, which makes slow waves of scatter the larger ones."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.fit_state import Fit

Floats = NDArray[np.float64]
MOST = 0.95
STATIC, KINETIC, BELT = 0, 1, 2
FEWEST = 3  # events of a run that say anything of a correlation beside their mean
GRID = np.linspace(0.0, MOST, 96)  # correlations that are weighed


def memory(fit: Fit, which: int) -> tuple[float, float]:
    """
    Return the correlation from one event to the next, and its standard error.

    Parameters
    ----------
    fit : with the events' own friction
    which : STATIC, the static limit, KINETIC, the mean of the curve, or BELT, the mean speed of the window's own belt

    All runs and contacts together.
    """
    belt = () if fit.windows.belt is None else (fit.windows.belt,)
    every = (fit.windows.statics, fit.windows.kinetics, belt)[which]
    series = [fit.random[:, one].mean(axis=1) for one in map(np.atleast_1d, every)]
    return correlation([u[members] for u in series for members in fit.windows.by_run])


def of_effects(fit: Fit, draws: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """
    Return the correlation of every random effect with itself an event before, and draws of what it may be instead.

    Parameters
    ----------
    fit : with the events' own friction
    draws : how many
    rng : draws

    Returns
    -------
    expected : (effects,)
    drawn : (draws, effects) the same of all effects of a kind
    """
    expected, drawn = np.zeros(fit.windows.effects), np.zeros((draws, fit.windows.effects))
    belt = () if fit.windows.belt is None else (fit.windows.belt,)
    for which, effects in ((STATIC, fit.windows.statics), (KINETIC, fit.windows.kinetics), (BELT, belt)):
        found, error = memory(fit, which)
        at = [i for one in effects for i in np.atleast_1d(one)]
        expected[at] = found
        drawn[:, at] = np.clip(found + error * rng.standard_normal(draws), 0.0, MOST)[:, None]
    return expected, drawn


def correlation(runs: Sequence[Floats]) -> tuple[float, float]:
    """
    Return the same of numbers of events, (n,) of each run.

    They are a stationary first-order recurrence about a mean of each run, of one variance. The correlation has the mean
    and the standard deviation of its posterior: its restricted likelihood, in which the means are no estimates, and as
    likely anything from 0 to `MOST` before. What so few events as a run of a block has do not say stays open.
    """
    found = [one for one in runs if len(one) >= FEWEST]
    if not any(np.ptp(one) for one in found):
        return 0.0, 0.0
    size, spread, left = np.zeros_like(GRID), np.zeros_like(GRID), 0
    for one in found:
        n, ends = len(one), one[0] + one[-1]
        ones = ((n - 2) * (1 - GRID) + 2) / (
            1 + GRID
        )  # the inverse of a recurrence's correlations is tridiagonal
        mean = (ends + (1 - GRID) * one[1:-1].sum()) / (1 + GRID) / ones
        off = one[:, None] - mean
        square = (
            (off**2).sum(axis=0)
            + GRID**2 * (off[1:-1] ** 2).sum(axis=0)
            - 2 * GRID * (off[1:] * off[:-1]).sum(axis=0)
        )
        spread += square / (1 - GRID**2)
        size += (n - 1) * np.log(1 - GRID**2) + np.log(ones)
        left += n - 1
    deviance = size + left * np.log(spread)
    weight = np.exp(-0.5 * (deviance - deviance.min()))
    weight /= weight.sum()
    mean_of = float(weight @ GRID)
    return mean_of, math.sqrt(float(weight @ (GRID - mean_of) ** 2))


def slowness(found: float, turn: float) -> float:
    """Return the power that memory gives to a wave of `turn` radians an event, over that without."""
    return (1 - found**2) / (1 - 2 * found * float(np.cos(turn)) + found**2)
