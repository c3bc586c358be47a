"""The population of a window's random effects, as a factor: effects are ``factor @ b`` with b white.

A factor instead of a covariance has no inverse, so a variance of 0 is a point like any other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Part:
    """
    One independent source of scatter.

    Parameters
    ----------
    name : what scatters
    spread : (effects, white) array; the source adds ``sd * spread @ b`` to the effects of a window
    """

    name: str
    spread: Floats


def level(name: str, which: Sequence[int], effects: int) -> Part:
    """Return a level that all the effects `which` share."""
    shape = np.zeros((effects, 1))
    shape[list(which), 0] = 1.0
    return Part(name, shape)


def curve(name: str, which: Sequence[int], effects: int, places: Floats, length: float) -> Part:
    """
    Return a smooth curve over the way slipped: a Gaussian process with a squared-exponential kernel.

    Parameters
    ----------
    name : what scatters
    which : the effects that are the curve's values at `places`
    effects : number of effects of a window
    places : places along the way slipped
    length : correlation length, in the unit of `places`
    """
    gap = (places[:, None] - places[None]) / length
    # A smooth kernel is singular to rounding; the symmetric root needs no jitter.
    values, vectors = np.linalg.eigh(np.exp(-0.5 * gap**2))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    shape = np.zeros((effects, len(places)))
    shape[list(which)] = root
    return Part(name, shape)


def factor(parts: Sequence[Part], sd: Floats) -> Floats:
    """Return the factor of all parts at their standard deviations; a part of sd 0 has no columns."""
    kept = [s * part.spread for part, s in zip(parts, sd, strict=True) if s != 0.0]
    effects = parts[0].spread.shape[0] if parts else 0
    return np.concatenate(kept, axis=1) if kept else np.zeros((effects, 0))
