"""Process noise: its colour as an autoregression, and what is left when that is taken out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HIGHEST = 40  # order of the autoregression


@dataclass(frozen=True, eq=False)
class Noise:
    """A noise e[k] = -h[1] e[k-1] - ... - h[p] e[k-p] + sigma w[k], w white with variance 1.

    `filter` is (1, h[1], ..., h[p]), `sigma` in the unit of e.
    """

    filter: Floats
    sigma: float

    @property
    def order(self) -> int:
        """Samples at the head of a run that have too short a past."""
        return len(self.filter) - 1

    def matrix(self, lengths: Sequence[int]) -> scipy.sparse.csr_array:
        """The matrix that whitens columns, run by run, to units of sigma; each run loses `order` rows."""
        blocks = []
        for n in lengths:
            diagonals = [[float(h / self.sigma)] * (n - self.order) for h in self.filter]
            offsets = [self.order - i for i in range(self.order + 1)]
            blocks.append(scipy.sparse.diags_array(diagonals, offsets=offsets, shape=(n - self.order, n)))
        return scipy.sparse.csr_array(scipy.sparse.block_diag(blocks, format="csr"))

    def drawn(self, n: int, generator: np.random.Generator) -> Floats:
        """A realisation (n,) with Gaussian w."""
        w = generator.standard_normal(n + 20 * len(self.filter))
        return np.asarray(self.sigma * scipy.signal.lfilter([1.0], self.filter, w)[-n:], dtype=np.float64)

    @property
    def std(self) -> float:
        """Standard deviation of e."""
        _, response = scipy.signal.freqz([1.0], self.filter, worN=4096)
        return float(self.sigma * np.sqrt(np.mean(np.abs(response) ** 2)))


def autoregression(residual: Floats, lengths: Sequence[int], *, freedom: int = 0) -> Noise:
    """Fit an autoregression to residuals (n,) of one or several runs; the order by Akaike's criterion.

    Parameters
    ----------
    residual, lengths
        The runs one below the other, and how long each is.
    freedom
        Numbers already fitted to the residuals, for an honest sigma.
    """
    at = np.concatenate([[0], np.cumsum(lengths)])
    runs = [residual[a:b] for a, b in zip(at[:-1], at[1:], strict=True)]
    n = len(residual)
    highest = min(HIGHEST, min(lengths) // 8)
    lags = [np.correlate(one, one, "full")[len(one) - 1 : len(one) + highest] for one in runs]
    r = np.sum(lags, axis=0) / n
    r[0] *= 1 + 1e-10
    best, chosen = np.inf, (np.ones(1), float(r[0]))
    for order in range(highest + 1):
        h = np.ones(1)
        if order:
            h = np.concatenate([[1.0], -scipy.linalg.solve_toeplitz(r[:order], r[1 : order + 1])])
        power = float(h @ r[: order + 1])
        score = n * np.log(power) + 2 * order
        if score < best:
            best, chosen = score, (h, power)
    h, power = chosen
    return Noise(h, float(np.sqrt(power * n / max(n - freedom - len(h) + 1, 1))))
