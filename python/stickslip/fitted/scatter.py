"""Statistics of what scatters: correlated residuals and correlated events."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy

from stickslip.measured.fit_window import Array

RESAMPLES = 2000


def effective_readings(residuals: Sequence[Array]) -> float:
    """Number of independent readings: misfit is correlated from sample to sample, noise is not.

    Parameters
    ----------
    residuals : sequence of (n, c) arrays
        The first channel counts.
    """
    total = 0.0
    for r in residuals:
        x = r[:, 0] - r[:, 0].mean()
        power = float(x @ x)
        rho = float(np.clip(x[1:] @ x[:-1] / power, 0.0, 0.999)) if power > 0 else 0.0
        total += max(len(x) * (1 - rho) / (1 + rho), 1.0)
    return total


def correlation_length(x: Array) -> float:
    """Integrated autocorrelation of a sequence, in events, summed to the first negative lag; 0.5 if white."""
    d = x - x.mean()
    power = float(d @ d)
    total = 0.5
    for k in range(1, len(d) // 2):
        rho = float(d[k:] @ d[:-k]) / power if power > 0 else 0.0
        if rho <= 0:
            break
        total += rho
    return total


def few(n: int) -> float:
    """By how much an interval from a bootstrap over n events is too narrow: Student's t for the normal, n - 1 for n."""
    return float(scipy.stats.t.ppf(0.975, n - 1) / scipy.stats.norm.ppf(0.975) * np.sqrt(n / (n - 1)))


def block_bootstrap(level: Array, refit: Callable[[Array], Array] | None = None) -> Array:
    """Means over events of resampled records.

    Parameters
    ----------
    level : (k, p) array
        Numbers of each event, in time order. Circular blocks of twice the correlation length are drawn, so that
        neighbours keep their correlation.
    refit : callable, optional
        Gives the numbers (q,) of a resampled record from how often each event was drawn, (k,); the means if absent.

    Returns
    -------
    (RESAMPLES, p) or (RESAMPLES, q) array
    """
    n = len(level)
    size = int(min(max(np.ceil(2 * max(correlation_length(c) for c in level.T)), 1), max(n // 4, 1)))
    rng = np.random.default_rng(0)
    starts = rng.integers(0, n, size=(RESAMPLES, -(-n // size)))
    index = ((starts[:, :, None] + np.arange(size)) % n).reshape(RESAMPLES, -1)[:, :n]
    if refit is None:
        return np.asarray(level[index].mean(axis=1), dtype=float)
    return np.array([refit(np.bincount(i, minlength=n).astype(float)) for i in index])
