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
    gram : (windows, channels, m, m) products of the columns [J, S, K, r]; 0 for a window that failed
    count : (windows, channels) readings
    weight : (windows,) share by which a window counts
    run : (windows,) run of each
    shared, own, effects : numbers of columns of J, S and K
    """

    gram: Floats
    count: Floats
    weight: Floats
    run: NDArray[np.int64]
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
    own : (windows, own) steps of the initial states
    effects : (windows, effects) random effects, as expected given the readings
    misfit : (windows, channels) sums of squares that are left
    freedom : (channels,) share of the readings' number that the windows' own numbers take
    """

    deviance: float
    shared: Floats
    covariance: Floats
    own: Floats
    effects: Floats
    misfit: Floats
    freedom: Floats


def products(
    blocks: Sequence[Floats | None], run: Sequence[int], shared: int, own: int, channels: int
) -> Windows:
    """
    Return the windows of `blocks`.

    Parameters
    ----------
    blocks : for each window a (readings, channels, m) array of the columns [J, S, K, r]; None where it failed
    run : of each window
    shared, own : numbers of columns of J and S
    channels : number of channels
    """
    good = next(one for one in blocks if one is not None)
    m = good.shape[2]
    gram, count = np.zeros((len(blocks), channels, m, m)), np.zeros((len(blocks), channels))
    for w, block in enumerate(blocks):
        if block is None:
            continue
        for c in range(channels):
            column = np.ascontiguousarray(block[:, c])
            gram[w, c] = column.T @ column
            count[w, c] = np.count_nonzero(column[:, -1])
    weight = np.array([0.0 if one is None else 1.0 for one in blocks])
    return Windows(gram, count, weight, np.asarray(run, dtype=np.int64), shared, own, m - shared - own - 1)


def solve(
    windows: Windows,
    factor: Floats,
    noise: Floats,
    mean: Floats,
    precision: Floats,
    at: Floats,
    damping: float = 0.0,
) -> Solution:
    """
    Solve for all numbers, each window's own eliminated first.

    Parameters
    ----------
    windows : the linearised windows
    factor : (runs, effects, white) factor of the random effects' covariance
    noise : (channels,) variances of the readings
    mean, precision : (shared,) prior of the shared step, precision 0 where it is flat
    at : (windows, effects) random effects that the windows are linearised at
    damping : Levenberg's, of the shared numbers and the initial states
    """
    p, q, white = windows.shared, windows.own, factor.shape[2]
    scaled = np.einsum("wcij,c->wij", windows.gram, (1.0 / noise)) * windows.weight[:, None, None]
    a = _turned(scaled, factor[windows.run], at, p + q)
    local = slice(p, p + q + white)
    inner = a[:, local, local].copy()
    # The white numbers have the prior N(0, 1); the initial state has none.
    diagonal = np.arange(q)
    inner[:, diagonal, diagonal] *= 1.0 + damping + 1e-9
    inner[:, diagonal, diagonal] += 1e-12
    inner[:, range(q, q + white), range(q, q + white)] += 1.0
    cross, right = a[:, :p, local], a[:, local, -1]
    both = np.concatenate([cross.transpose(0, 2, 1), right[:, :, None]], axis=2)
    back = np.linalg.solve(inner, both)
    schur = (a[:, :p, :p] - cross @ back[:, :, :p]).sum(0) + np.diag(precision)
    schur[range(p), range(p)] *= 1.0 + damping + 1e-9
    schur[range(p), range(p)] += 1e-10
    pull = (a[:, :p, -1] - np.einsum("wpl,wl->wp", cross, back[:, :, p])).sum(0) + precision * mean
    covariance = np.linalg.inv(schur) if p else np.zeros((0, 0))
    step = covariance @ pull
    numbers = back[:, :, p] - back[:, :, :p] @ step
    effects = np.einsum("wek,wk->we", factor[windows.run], numbers[:, q:])
    moved = np.concatenate([np.tile(step, (len(a), 1)), numbers[:, :q], effects - at, -np.ones((len(a), 1))], 1)
    misfit = np.einsum("wi,wcij,wj->wc", moved, windows.gram, moved)
    deviance = float((misfit @ (1.0 / noise) * windows.weight).sum())
    deviance += float((numbers[:, q:] ** 2).sum() + precision @ (step - mean) ** 2)
    deviance += float(np.linalg.slogdet(inner)[1].sum())
    deviance += float((windows.count * windows.weight[:, None]).sum(0) @ np.log(noise))
    taken = _taken(windows, factor, inner, p, q, noise)
    return Solution(deviance, step, covariance, numbers[:, :q], effects, misfit, taken)


def _turned(a: Floats, factor: Floats, at: Floats, first: int) -> Floats:
    """Return products of [J, S, K factor, r + K at] from those of [J, S, K, r]."""
    w, e, white = factor.shape
    turn = np.zeros((w, a.shape[1], first + white + 1))
    turn[:, range(first), range(first)] = 1.0
    turn[:, first : first + e, first : first + white] = factor
    turn[:, first : first + e, -1] = at
    turn[:, -1, -1] = 1.0
    return np.asarray(turn.transpose(0, 2, 1) @ a @ turn)


def _taken(windows: Windows, factor: Floats, inner: Floats, p: int, q: int, noise: Floats) -> Floats:
    """Return by channel how many readings' worth of noise the windows' own numbers explain."""
    inverse = np.linalg.inv(inner)
    turn = factor[windows.run]
    out = []
    for c in range(windows.gram.shape[1]):
        g = windows.gram[:, c, p:-1, p:-1] * windows.weight[:, None, None] / noise[c]
        states, effects = g[:, :q, :q], turn.transpose(0, 2, 1) @ g[:, q:, q:] @ turn
        mixed = g[:, :q, q:] @ turn
        out.append(
            np.einsum("wij,wji->", states, inverse[:, :q, :q])
            + np.einsum("wij,wji->", effects, inverse[:, q:, q:])
            + 2 * np.einsum("wij,wji->", mixed, inverse[:, q:, :q])
        )
    return np.array(out)
