"""What unknowns promise that are not fitted yet: chi-squared to first order, everything else refitted."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.search import Trial

Floats = NDArray[np.float64]


def rest(base: Trial, more: Sequence[Floats | None], own: bool = False, spread: float = math.inf) -> float:
    """Chi-squared that is left to first order with unknowns added, the base refitted and bad windows held back.

    Parameters
    ----------
    base : Trial
    more : sequence of (n, k) arrays
        Derivatives of each window's residuals by the unknowns; a window of None is left out.
    own : bool
        Each window has the unknowns for itself; else they are common to all.
    spread : float
        Of the weak Gaussian on unknowns that are common.
    """
    fit = base.fit
    p, k = len(fit.vector), 0 if own else next((one.shape[1] for one in more if one is not None), 0)
    A, g, left = np.zeros((p + k, p + k)), np.zeros(p + k), 0.0
    A[:p, :p] = np.diag(fit.engine.precision)
    A[p:, p:] = np.eye(k) / spread**2
    for w, b, new in zip(fit.windows, fit.blocks, more, strict=True):
        if new is None:
            continue
        D = np.zeros((len(b.r), p + k))
        D[:, fit.engine.columns[w.run]] = b.J
        if not own:
            D[:, p:] = new
        r = _beside(b.K, b.r)
        size = max(1.0, float(r @ r) / len(r))
        local = np.column_stack([b.K, new]) if own else b.K
        D, r = _beside(local, D), _beside(local, b.r)
        A += D.T @ D / size
        g += D.T @ r / size
        left += float(r @ r) / size
    return left - float(g @ np.linalg.lstsq(A, g, rcond=1e-12)[0])


def _beside(K: Floats, x: Floats) -> Floats:
    """What of x is not in the columns of K."""
    q = np.linalg.qr(K)[0]
    return np.asarray(x - q @ (q.T @ x))
