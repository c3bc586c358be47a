"""What a channel reads as straight pieces, as few as its noise leaves anything to be told by.

Noise must not become a belt's acceleration, and each piece is a restart of the simulation. Pieces are halved where what
is left of the readings is no noise; then bends that the readings do not need are taken out again. A step of the speed
stays as sharp as its samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.measured.signals import noise_std, quantisation

Floats = NDArray[np.float64]
FINE = 1e-3  # of the largest reading: what is told finer than that moves nothing
ENOUGH = 12  # samples that tell their noise
RUNS_OFF = 0.9  # sum of what is left over that of noise where a piece is halved
STANDS_OUT = 4.5  # the same of one reading; one that stands out so far of its neighbours is a glitch
AROUND = 5  # samples whose median a glitch is held against
AT_REST = 3.0  # standard deviations from 0 of both ends of a piece within which nothing moves
PLACES = 4000  # samples at which a way is looked at, at most
MOST = 2000  # pieces; beyond them a channel shows its noise, or what no rig follows


@dataclass(frozen=True)
class Pieces:
    """Times (k,) and values (k,) between which a channel goes straight, and the covariance of these (k, k)."""

    t: Floats
    values: Floats
    covariance: Floats

    def by_way(self, t: Floats, x: Floats, noise: float | None = None) -> Pieces:
        """Return these pieces of a speed as what it goes tells them too, by positions x (n,) at times t."""
        kept = np.unique(np.linspace(0, len(t) - 1, PLACES).astype(int))
        size = _noise(t, x, noise, fine=0.0) * math.sqrt(len(kept) / len(t))
        ways = np.column_stack([self._ways(t[kept]), np.ones(len(kept))])
        left = x[kept] - ways[:, :-1] @ self.values
        move = np.append(self.values != 0, True)  # what stands still goes nowhere
        known = np.zeros((len(move), len(move)))
        known[:-1, :-1] = np.linalg.inv(self.covariance)
        A, side = ways.T @ ways / size**2 + known, ways.T @ (left - left[0]) / size**2
        values = self.values.copy()
        values[move[:-1]] += np.linalg.solve(A[np.ix_(move, move)], side[move])[:-1]
        return replace(self, values=values)

    def _ways(self, t: Floats) -> Floats:
        """How far each value's share goes until times t, (n, k)."""
        width = np.diff(self.t)
        done = np.clip((t[:, None] - self.t[:-1]) / width, 0.0, 1.0)
        out = np.zeros((len(t), len(self.t)))
        out[:, :-1] += width * (done - 0.5 * done**2)
        out[:, 1:] += width * 0.5 * done**2
        return out


def straight_pieces(t: Floats, x: Floats, noise: float | None = None) -> Pieces:
    """Return what a channel reads in straight pieces; one value where it is constant.

    Parameters
    ----------
    t, x
        Increasing times and finite readings (n,), n >= 3.
    noise
        Standard deviation of one; None: as the readings show it.
    """
    size = _noise(t, x, noise)
    # of one sample or two; a step stays, of which a median of five is no less sharp
    good = np.abs(x - scipy.ndimage.median_filter(x, AROUND, mode="nearest")) <= STANDS_OUT * size
    good[[0, -1]] = True
    t, x = t[good], x[good]
    knots = _halved(t, x, size)
    values, inverse = _fit(t, x, knots, size)
    # what a bend, its time and its size, must be worth of chi-squared (Schwarz 1978)
    least = 2 * math.log(len(t))
    while len(knots) > 2:
        worth = _worth(t[knots], values, inverse)
        beside = np.concatenate([[np.inf], worth, [np.inf]])
        lowest = (worth <= beside[:-2]) & (worth < beside[2:])
        out = lowest & (worth < least)
        if not out.any():
            if len(knots) - 1 <= MOST:
                break
            out = lowest & (worth <= np.quantile(worth, 0.2))
        knots = np.delete(knots, np.flatnonzero(out) + 1)
        values, inverse = _fit(t, x, knots, size)
    rise = np.array([-1.0, 1.0])
    if len(knots) == 2 and float(rise @ values) ** 2 <= least * float(rise @ inverse @ rise):
        mean = float(np.mean(x))
        sd = size / math.sqrt(len(x))
        return Pieces(t[:1], np.array([0.0 if abs(mean) <= AT_REST * sd else mean]), np.array([[sd**2]]))
    still = np.abs(values) < AT_REST * np.sqrt(np.diag(inverse))
    still = np.concatenate([still[:-1] & still[1:], [False]])
    return Pieces(t[knots], np.where(still | np.roll(still, 1), 0.0, values), inverse)


def _noise(t: Floats, x: Floats, given: float | None, fine: float = FINE) -> float:
    seen = given
    if seen is None:
        seen = noise_std(x, t=t) if len(x) >= ENOUGH else 0.0
    return max(seen, quantisation(x).noise, fine * float(np.abs(x).max()), 1e-9 * float(np.ptp(x)), 1e-300)


def _halved(t: Floats, x: Floats, noise: float) -> NDArray[np.intp]:
    """Knots, the first and the last sample among them, between which what is left is noise."""
    knots = np.array([0, len(t) - 1])
    while len(knots) <= 2 * MOST:
        values, _ = _fit(t, x, knots, noise, spread=False)
        left = (x - np.interp(t, t[knots], values)) / noise
        new = []
        for a, b in zip(knots[:-1].tolist(), knots[1:].tolist(), strict=True):
            part = left[a : b + 1]
            off = np.abs(np.cumsum(part)).max() > RUNS_OFF * math.sqrt(len(part))
            if b - a > 1 and (off or np.abs(part).max() > STANDS_OUT):
                new.append((a + b) // 2)
        if not new:
            break
        knots = np.sort(np.concatenate([knots, np.array(new)]))
    return knots


def _fit(
    t: Floats, x: Floats, knots: NDArray[np.intp], noise: float, *, spread: bool = True
) -> tuple[Floats, Floats]:
    """Values (k,) at the knots of the nearest broken line, and their covariance (k, k)."""
    k = len(knots)
    piece = np.minimum(np.searchsorted(knots, np.arange(len(t)), side="right") - 1, k - 2)
    share = (t - t[knots[piece]]) / (t[knots[piece + 1]] - t[knots[piece]])
    band, side = np.zeros((2, k)), np.zeros(k)
    for place, weight in ((piece, 1 - share), (piece + 1, share)):
        band[1] += np.bincount(place, weight**2, k)
        side += np.bincount(place, weight * x, k)
    band[0] = np.bincount(piece + 1, share * (1 - share), k)
    values = scipy.linalg.solveh_banded(band, side)
    inverse = scipy.linalg.solveh_banded(band, np.eye(k)) * noise**2 if spread else np.zeros((0, 0))
    return np.asarray(values), np.asarray(inverse)


def _worth(at: Floats, values: Floats, covariance: Floats) -> Floats:
    """By how much chi-squared rises without each of the inner knots, (k - 2,)."""
    rates = 1 / np.diff(at)
    weights = np.stack([rates[:-1], -rates[:-1] - rates[1:], rates[1:]])
    j = np.arange(len(at) - 2)
    bend = sum(weights[a] * values[j + a] for a in range(3))
    variance = sum(weights[a] * weights[b] * covariance[j + a, j + b] for a in range(3) for b in range(3))
    return np.asarray(bend**2 / variance)
