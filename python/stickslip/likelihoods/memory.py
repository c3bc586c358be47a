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
FEWEST = 4  # events of a run that a correlation can be had from


def memory(fit: Fit, which: int) -> tuple[float, float]:
    """
    Return the correlation from one event to the next, and its standard error.

    Parameters
    ----------
    fit : with the events' own friction
    which : STATIC, the static limit, KINETIC, the mean of the curve, or BELT, the mean speed of the window's own belt

    All runs and contacts together. The mean of a short run takes (1 + 3 m)/n of it (Kendall, Biometrika 41, 1954).
    """
    belt = () if fit.windows.belt is None else (fit.windows.belt,)
    every = (fit.windows.statics, fit.windows.kinetics, belt)[which]
    series = [fit.random[:, one].mean(axis=1) for one in map(np.atleast_1d, every)]
    return correlation([u[members] for u in series for members in fit.windows.by_run])


def correlation(runs: Sequence[Floats]) -> tuple[float, float]:
    """Return the same of numbers of events, (n,) of each run."""
    along = square = 0.0
    count = used = 0
    for one in runs:
        if len(one) < FEWEST:
            continue
        u = one - one.mean()
        along, square = along + float(u[1:] @ u[:-1]), square + float(u @ u)
        count, used = count + len(u), used + 1
    if square == 0:
        return 0.0, 0.0
    each = count / used
    found = (along / square + 1 / each) / (1 - 3 / each)
    found = min(max(found, 0.0), MOST)
    return found, math.sqrt((1 - found**2) / count)


def slowness(found: float, turn: float) -> float:
    """Return the power that memory gives to a wave of `turn` radians an event, over that without."""
    return (1 - found**2) / (1 - 2 * found * float(np.cos(turn)) + found**2)
