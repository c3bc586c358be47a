"""What a fit gains where friction of one event may be like that of the event before.

A fit takes its windows for independent. Friction that follows a field along the belt is alike from one event to the
next, and a hypothesis that lacks nothing but the field leaves levels that look like a wave or a drift. So each
hypothesis is held against the others with the memory that its own levels have.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded
from scipy.optimize import minimize

from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.memory import MOST as MOST_ALIKE
from stickslip.likelihoods.population import LEAST, MOST, factor

Floats = NDArray[np.float64]
SOME = 0.5  # correlation that is sought from


def remembered(fit: Fit) -> float:
    """
    Return the fall of -2 log marginal likelihood with events that remember, their scatter estimated anew.

    Levels of friction of a run, kinetic and static of each contact, are stationary first-order recurrences, as
    `memory` has them; shared numbers, and what else differs from event to event, stay as they are.
    """
    return sum(
        _gained(told, pull, starts, scatter)
        for which in (fit.windows.kinetics, [[one] for one in fit.windows.statics])
        for told, pull, starts, scatter in _levels(fit, which)
    )


def _levels(
    fit: Fit, which: Sequence[Sequence[int]]
) -> list[tuple[Floats, Floats, NDArray[np.bool_], float]]:
    """
    Return what the windows say of each level by themselves, run after run; of one that is nothing it is left out.

    That is precision and precision times mean, (w,) each; which windows begin a run; and the level's own scatter.
    """
    assert fit.linear is not None
    assert fit.solution is not None
    order = np.concatenate([one for one in fit.windows.by_run if len(one)])
    starts = np.concatenate([np.arange(len(one)) == 0 for one in fit.windows.by_run if len(one)])
    roots = factor(fit.population, fit.windows.places)[fit.linear.run]
    covariance = fit.solution.inverse[:, fit.linear.own :, fit.linear.own :]
    out = []
    for effects in which:
        row = roots[:, list(effects)].mean(axis=1)
        before = (row**2).sum(axis=1)
        scatter = float(np.sqrt(before.mean()))
        if scatter <= 2 * LEAST:
            continue
        after = np.einsum("wi,wij,wj->w", row, covariance, row)
        told = np.where(fit.linear.weight > 0, np.maximum(1 / after - 1 / before, 0.0), 0.0)
        pull = np.where(told > 0, (row * fit.solution.white).sum(axis=1) / after, 0.0)
        out.append((told[order], pull[order], starts, scatter))
    return out


def _gained(told: Floats, pull: Floats, starts: NDArray[np.bool_], scatter: float) -> float:
    """The fall of a level's deviance where its events remember."""
    free = _deviance(told, pull, starts)
    sizes, alike = (np.log(LEAST), np.log(MOST)), (0.0, MOST_ALIKE)
    alone = minimize(free, [np.log(scatter), 0.0], bounds=[sizes, (0.0, 0.0)])
    found = minimize(free, [alone.x[0], SOME], bounds=[sizes, alike])
    return max(float(alone.fun - found.fun), 0.0)


def _deviance(told: Floats, pull: Floats, starts: NDArray[np.bool_]) -> Callable[[Floats], float]:
    """Return -2 log marginal likelihood by the logarithm of the scatter and the correlation, but for a constant."""

    def at(x: Floats) -> float:
        size, like = x
        # the precision of a recurrence has three diagonals
        along = np.where(starts, 0.0, like)
        news = 1.0 / (1.0 - along**2)
        band = np.zeros((2, len(told)))
        band[1] = news
        band[1, :-1] += (along**2 * news)[1:]
        band[0, 1:] = -(along * news)[1:]
        band *= np.exp(-2.0 * size)
        band[1] += told
        try:
            root = cholesky_banded(band)
        except LinAlgError:
            return np.inf
        volume = 2 * np.log(root[1]).sum() - np.log(news).sum() + 2 * len(told) * size
        return float(volume - pull @ cho_solve_banded((root, False), pull))

    return at
