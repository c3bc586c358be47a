"""The band of a forecast: quantiles of an ensemble's readings, their noise included."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SHOWN = 3  # windows, at least, that show how friction scatters
MEMBERS = 200  # runs of an ensemble: its mean is then known to a fourteenth of its spread
FRESH = 10  # draws of noise for each member: the quantiles of so few members alone are rough
TAILS = (0.025, 0.975)  # of the band


def standing(whole: Floats) -> Floats | None:
    """Return the members (m, n, channels) that reach the horizon; None where fewer than half of them do."""
    good = np.isfinite(whole).all(axis=(1, 2))
    return whole[good] if good.sum() >= MEMBERS // 2 else None


def band(whole: Floats, noise: Floats, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """
    Return the ends of the band that holds 95 % of the readings to come, (n, channels) each.

    Parameters
    ----------
    whole : (members, n, channels) readings without noise
    noise : (channels,) its standard deviations
    rng : draws it
    """
    sides = []
    middle = whole.mean(axis=0)
    whole = middle + _outward(len(whole)) * (whole - middle)
    for channel in range(whole.shape[2]):
        draws = rng.standard_normal((FRESH, *whole.shape[:2])) * noise[channel] + whole[None, :, :, channel]
        sides.append(np.quantile(draws.reshape(-1, whole.shape[1]), TAILS, axis=0))
    low, high = np.stack(sides, axis=-1)
    return low, high


def _outward(members: int) -> float:
    """
    Return how much wider than so few members what they stand for is.

    A further member lies beyond the quantiles of `members` of them more often than beyond those of the distribution:
    between the ends, each the rth from outside, it is with probability 1 - 2 r/(members + 1).
    """
    normal, rank = NormalDist(), math.floor(TAILS[0] * members) + 1
    return normal.inv_cdf(TAILS[1]) / normal.inv_cdf(1 - rank / (members + 1))
