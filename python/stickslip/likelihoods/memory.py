"""How friction of one event is like that of the event before, which makes slow waves of scatter the larger ones."""

from __future__ import annotations

import math

import numpy as np

from stickslip.likelihoods.fit_state import Fit

MOST = 0.95
STATIC, KINETIC = 0, 1
FEWEST = 4  # events of a run that a correlation can be had from


def memory(fit: Fit, which: int) -> tuple[float, float]:
    """
    Return the correlation from one event to the next, and its standard error.

    Parameters
    ----------
    fit : with the events' own friction
    which : STATIC, the static limit, or KINETIC, the mean of the curve

    All runs together. The mean of a short run takes (1 + 3 m)/n of it (Kendall, Biometrika 41, 1954).
    """
    along = square = 0.0
    count = runs = 0
    for members in fit.windows.by_run:
        u = fit.random[members, 0] if which == STATIC else fit.random[members, 1:-1].mean(axis=1)
        if len(u) < FEWEST:
            continue
        u = u - u.mean()
        along, square = along + float(u[1:] @ u[:-1]), square + float(u @ u)
        count, runs = count + len(u), runs + 1
    if square == 0:
        return 0.0, 0.0
    each = count / runs
    found = (along / square + 1 / each) / (1 - 3 / each)
    found = min(max(found, 0.0), MOST)
    return found, math.sqrt((1 - found**2) / count)


def slowness(found: float, turn: float) -> float:
    """Return the power that memory gives to a wave of `turn` radians an event, over that without."""
    return (1 - found**2) / (1 - 2 * found * float(np.cos(turn)) + found**2)
