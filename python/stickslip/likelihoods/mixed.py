"""The linearised mixed model of windows: an arrow-shaped solve that eliminates what is a window's own.

In window w, channel c, the residual is ``r = J d + S s + K u + e`` with d shared numbers under a Gaussian
prior, s the window's initial state (flat), u its random effects and e white with variance ``noise[c]``.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bounds = tuple[Floats, Floats]
TINY = 1e-9  # share added to a diagonal, against numbers that say the same
FAR_OUT = 50.0  # standard deviations beyond which a Gaussian's tail is an exponential
ROUNDING = 1e-14  # share of a product that sums of many lose
NOTHING = 1e-10  # information of a number that nothing depends on: it stays where it is


@dataclass(frozen=True)
class WindowProducts:
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
    covariance : its covariance; of a number that a bound holds, mean squares of how far inside it may be
    own : (windows, own) steps of the initial states
    effects : (windows, effects) random effects, as expected given the readings
    volume : what integrating a window's own numbers, and the noise's size, add to the deviance
    misfit : (windows, channels) weighted sums of squares that are left
    white : (windows, white) the random effects' white numbers
    inverse : (windows, own + white, own + white) covariance of a window's own numbers, the shared ones held
    """

    deviance: float
    shared: Floats
    covariance: Floats
    own: Floats
    effects: Floats
    volume: float
    misfit: Floats
    white: Floats
    inverse: Floats


def products(
    blocks: Sequence[Floats | None], run: Sequence[int], shared: int, own: int, channels: int
) -> WindowProducts:
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
    return WindowProducts(
        gram, count, weight, np.asarray(run, dtype=np.int64), shared, own, m - shared - own - 1
    )


def solve(
    windows: WindowProducts,
    factor: Floats,
    noise: Floats,
    mean: Floats,
    precision: Floats,
    at: Floats,
    damping: float = 0.0,
    bounds: Bounds | None = None,
) -> Solution:
    """
    Solve for all numbers, each window's own eliminated first.

    A number at its bound stays there, and the others are at their best beside it: to go beyond and be clipped back
    leaves them where they belong to something else.

    Parameters
    ----------
    windows : the linearised windows
    factor : (runs, effects, white) factor of the random effects' covariance
    noise : (channels,) variances of the readings
    mean, precision : (shared,), (shared, shared) prior of the shared step, precision 0 where it is flat
    at : (windows, effects) random effects that the windows are linearised at
    damping : Levenberg's, of the shared numbers and the initial states
    bounds : least and largest shared step, (shared,) each
    """
    p, q = windows.shared, windows.own
    scaled = np.einsum("wcij,c->wij", windows.gram, 1.0 / noise) * windows.weight[:, None, None]
    roots = factor[windows.run]
    a = turned(scaled, roots, at, p + q)
    # The white numbers have the prior N(0, 1); the initial state has none.
    root, seen = eliminated(a, p, q, damping)
    cross, right = seen[:, :, :p], seen[:, :, p]
    schur = (a[:, :p, :p] - cross.transpose(0, 2, 1) @ cross).sum(0) + precision
    schur[range(p), range(p)] *= 1.0 + damping + TINY
    schur[range(p), range(p)] = beyond_rounding(schur, np.diagonal(a[:, :p, :p], axis1=1, axis2=2).sum(0))
    pull = (a[:, :p, -1] - np.einsum("wlp,wl->wp", cross, right)).sum(0) + precision @ mean
    covariance = inverse_of(schur)
    step = covariance @ pull
    if bounds is not None and ((step < bounds[0]) | (step > bounds[1])).any():
        step, held = within(schur, pull, bounds)
        covariance = beside_bounds(schur, pull, step, held)
    numbers = np.einsum("wlk,wl->wk", root, right - cross @ step)
    effects = np.einsum("wek,wk->we", roots, numbers[:, q:])
    moved = np.concatenate(
        [np.tile(step, (len(a), 1)), numbers[:, :q], effects - at, -np.ones((len(a), 1))], 1
    )
    misfit = ((windows.gram @ moved[:, None, :, None])[..., 0] * moved[:, None]).sum(-1)
    misfit *= windows.weight[:, None]
    deviance = float(
        (misfit / noise).sum() + (numbers[:, q:] ** 2).sum() + (step - mean) @ precision @ (step - mean)
    )
    volume = float(-2.0 * np.log(np.diagonal(root, axis1=1, axis2=2)).sum())
    inverse = root.transpose(0, 2, 1) @ root
    volume += float((windows.count * windows.weight[:, None]).sum(0) @ np.log(noise))
    return Solution(
        deviance + volume, step, covariance, numbers[:, :q], effects, volume, misfit, numbers[:, q:], inverse
    )


def beyond_rounding(schur: Floats, whole: Floats) -> Floats:
    """
    Return the diagonal of products from which others were taken, (n,), where that left more than rounding.

    Where windows' own numbers explain a number whole, rounding is left, which may be less than nothing. What is added
    is a share of what there was: a number may be in any unit, and known to 1e-6 of one or to 1e6.

    Parameters
    ----------
    schur, whole : (n, n) what is left, and (n,) the diagonal that there was
    """
    left = np.maximum(np.diag(schur), ROUNDING * whole)
    return np.where(left > 0, left, NOTHING)


def inverse_of(products: Floats) -> Floats:
    """Return the inverse of products of numbers in whatever units, (n, n)."""
    scale = 1.0 / np.sqrt(np.diag(products))
    return np.asarray(np.linalg.inv(products * scale * scale[:, None]) * scale * scale[:, None])


def within(schur: Floats, pull: Floats, bounds: Bounds) -> tuple[Floats, NDArray[np.bool_]]:
    """
    Return the step that is best within its bounds, (shared,), and which of its numbers a bound holds.

    Parameters
    ----------
    schur, pull : products of the shared numbers, and what they are to explain
    bounds : least and largest step
    """
    scale = 1.0 / np.sqrt(np.diag(schur))
    upper = np.linalg.cholesky(schur * scale * scale[:, None]).T
    right = scipy.linalg.solve_triangular(upper, pull * scale, trans="T")
    low, high = (one / scale for one in bounds)
    found = scipy.optimize.lsq_linear(upper, right, (low, high), method="bvls")
    return np.asarray(found.x * scale, dtype=np.float64), found.active_mask != 0


def beside_bounds(schur: Floats, pull: Floats, step: Floats, held: NDArray[np.bool_]) -> Floats:
    """
    Return the covariance of a step, (n, n), where bounds hold some of its numbers.

    Such a number need not be at its bound: how far inside it is has a Gaussian's tail, cut off there, and the others
    move with it. Counted are mean squares from the bound, as the step is there: those of a number whose best is at the
    bound are what they were without it, those of one that is driven against it nearly nothing.

    Parameters
    ----------
    schur, pull : products of the shared numbers, and what they are to explain
    step : the best within the bounds
    held : which of the numbers a bound holds
    """
    free = ~held
    out = np.zeros_like(schur)
    out[np.ix_(free, free)] = inner = inverse_of(schur[np.ix_(free, free)])
    across = schur[np.ix_(free, held)]
    whole = schur[np.ix_(held, held)]
    stiff = beyond_rounding(whole - across.T @ inner @ across, np.diag(whole))  # of each, the others held
    alpha = np.abs(pull - schur @ step)[held] / np.sqrt(stiff)
    square = np.where(
        alpha < FAR_OUT, _square_beyond(np.minimum(alpha, FAR_OUT)), 2.0 / np.maximum(alpha, 1.0) ** 2
    )
    moves = np.zeros((len(schur), int(held.sum())))
    moves[free], moves[held] = -inner @ across, np.eye(int(held.sum()))
    return np.asarray(out + moves * (square / stiff) @ moves.T, dtype=np.float64)


def _square_beyond(alpha: Floats) -> Floats:
    """Mean square of what of a Gaussian about -alpha, of standard deviation 1, is above 0."""
    hazard = np.exp(-0.5 * alpha**2 - 0.5 * math.log(2 * math.pi) - scipy.special.log_ndtr(-alpha))
    return 1.0 + alpha**2 - alpha * hazard


def eliminated(a: Floats, shared: int, own: int, damping: float = 0.0) -> tuple[Floats, Floats]:
    """
    Return what eliminates a window's own numbers: the inverse of a Cholesky root, and it times the other columns.

    Products of readings that are far above their noise differ from those of what is eliminated in their last digits
    alone. A root has half of those digits to lose: with an inverse the rest was not even symmetric.

    Parameters
    ----------
    a : (windows, m, m) products as of `turned`
    shared, own : numbers of columns of J and S
    damping : Levenberg's, of the initial states

    Returns
    -------
    root : (windows, own + white, own + white), lower triangular; the inverse is root' root
    seen : (windows, own + white, shared + 1) root times the products with J and r
    """
    local = slice(shared, a.shape[1] - 1)
    inner = a[:, local, local].copy()
    n = inner.shape[1]
    states, random = np.arange(own), np.arange(own, n)
    inner[:, states, states] = inner[:, states, states] * (1.0 + damping + TINY) + 1e-12
    inner[:, random, random] += 1.0 + ROUNDING * inner[:, random, random]  # a motion that grows drowns the 1
    lower = np.linalg.cholesky(inner)
    out = np.concatenate(
        [np.broadcast_to(np.eye(n), inner.shape), a[:, local, :shared], a[:, local, -1:]], axis=2
    )
    for i in range(n):
        out[:, i] -= (lower[:, i, None, :i] @ out[:, :i])[:, 0]
        out[:, i] /= lower[:, i, i, None]
    return out[:, :, :n], out[:, :, n:]


def turned(a: Floats, factor: Floats, at: Floats, first: int) -> Floats:
    """
    Return products of [J, S, K factor, r + K at] from those of [J, S, K, r].

    Parameters
    ----------
    a : (windows, m, m) products
    factor : (windows, effects, white) of each window
    at : (windows, effects) random effects that the windows are linearised at
    first : columns of J and S
    """
    e, white = factor.shape[1:]
    effects, last = slice(first, first + e), first + white
    turn = np.concatenate([factor, at[:, :, None]], axis=2)  # of K and r; all else stays
    columns = a[:, :, effects] @ turn
    columns[:, :, -1] += a[:, :, -1]
    corner = turn.transpose(0, 2, 1) @ columns[:, effects]
    corner[:, -1] += columns[:, -1]
    out = np.empty((len(a), last + 1, last + 1))
    out[:, :first, :first] = a[:, :first, :first]
    out[:, :first, first:] = columns[:, :first]
    out[:, first:, :first] = columns[:, :first].transpose(0, 2, 1)
    out[:, first:, first:] = corner
    return out


def taken(windows: WindowProducts, factor: Floats, found: Solution, noise: Floats) -> Floats:
    """
    Return by channel how many readings' worth of noise the windows' own numbers explain.

    Parameters
    ----------
    windows, factor, noise : what was solved
    found : its solution
    """
    p, q = windows.shared, windows.own
    turn = np.zeros((len(factor), q + factor.shape[1], q + factor.shape[2]))
    turn[:, range(q), range(q)] = 1.0
    turn[:, q:, q:] = factor
    turn = turn[windows.run]
    known = turn @ found.inverse @ turn.transpose(0, 2, 1) * windows.weight[:, None, None]
    return np.asarray(np.einsum("wcij,wij->c", windows.gram[:, :, p:-1, p:-1], known) / noise)
