"""The linearised mixed model of windows: an arrow-shaped solve that eliminates what is a window's own.

In window w, channel c, the residual is ``r = J d + S s + K u + e`` with d shared numbers under a Gaussian
prior, s the window's initial state (flat), u its random effects and e white with variance ``noise[c]``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Windows:
    """
    Windows as products, so that a change of variances never looks at the readings again.

    Parameters
    ----------
    gram : (windows, channels, m, m) products of the columns [J, S, K, r]
    count : (windows, channels) readings
    shared, own, effects : numbers of columns of J, S and K
    """

    gram: Floats
    count: Floats
    shared: int
    own: int
    effects: int


@dataclass(frozen=True)
class Solution:
    """
    What the windows say at given variances.

    Parameters
    ----------
    deviance : -2 log marginal likelihood without constants, own numbers integrated, shared ones at their best
    shared : step of the shared numbers
    covariance : its covariance
    own : (windows, own) initial states
    effects : (windows, effects) random effects, as expected given the readings
    """

    deviance: float
    shared: Floats
    covariance: Floats
    own: Floats
    effects: Floats


def products(blocks: Sequence[Floats], shared: int, own: int) -> Windows:
    """
    Return the windows of `blocks`.

    Parameters
    ----------
    blocks : for each window a (readings, channels, m) array of the columns [J, S, K, r]
    shared, own : numbers of columns of J and S
    """
    gram = np.array([np.einsum("tci,tcj->cij", block, block) for block in blocks])
    count = np.array([[block.shape[0]] * block.shape[1] for block in blocks], dtype=float)
    return Windows(gram, count, shared, own, gram.shape[-1] - shared - own - 1)


def solve(windows: Windows, factor: Floats, noise: Floats, mean: Floats, precision: Floats) -> Solution:
    """
    Solve for all numbers, each window's own eliminated first.

    Parameters
    ----------
    windows : the linearised windows
    factor : (effects, white) factor of the random effects' covariance
    noise : (channels,) variances of the readings
    mean, precision : (shared,) prior of the shared step, precision 0 where it is flat
    """
    p, q, white = windows.shared, windows.own, factor.shape[1]
    turn = _turn(windows, factor)
    scaled = np.einsum("wcij,c->wij", windows.gram, 1.0 / noise)
    a = turn.T @ scaled @ turn
    local = slice(p, p + q + white)
    inner = a[:, local, local].copy()
    # The white numbers have the prior N(0, 1); the initial state has none.
    inner[:, range(q, q + white), range(q, q + white)] += 1.0
    cross, right = a[:, :p, local], a[:, local, -1]
    back = np.linalg.solve(inner, np.concatenate([cross.transpose(0, 2, 1), right[:, :, None]], axis=2))
    schur = (a[:, :p, :p] - cross @ back[:, :, :p]).sum(0) + np.diag(precision)
    pull = (a[:, :p, -1] - np.einsum("wpl,wl->wp", cross, back[:, :, p])).sum(0) + precision * mean
    covariance = np.linalg.inv(schur) if p else np.zeros((0, 0))
    step = covariance @ pull
    locals_ = back[:, :, p] - back[:, :, :p] @ step
    quadratic = a[:, -1, -1].sum() - np.einsum("wl,wl->", right, back[:, :, p])
    quadratic += precision @ mean**2 - pull @ step
    size = np.linalg.slogdet(inner)[1].sum() + windows.count.sum(0) @ np.log(noise)
    return Solution(float(quadratic + size), step, covariance, locals_[:, :q], locals_[:, q:] @ factor.T)


def _turn(windows: Windows, factor: Floats) -> Floats:
    """Return the matrix from [J, S, K factor, r] to [J, S, K, r]."""
    first, white = windows.shared + windows.own, factor.shape[1]
    turn = np.zeros((windows.gram.shape[-1], first + white + 1))
    turn[:first, :first] = np.eye(first)
    turn[first:-1, first:-1] = factor
    turn[-1, -1] = 1.0
    return turn
