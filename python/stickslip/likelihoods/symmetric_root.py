"""Symmetric roots of covariances: what is drawn with them does not depend on the signs of eigenvectors."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def symmetric_root(covariance: Floats, most: float = math.inf) -> Floats:
    """
    Return the symmetric matrix whose square is a covariance (n, n), which may be singular.

    Rounding decides the signs of eigenvectors; a root that keeps them would give other draws on another machine.

    Parameters
    ----------
    covariance : (n, n)
    most : variance of a direction from which nothing is known of it, so that it is left where it is
    """
    sizes, turn = np.linalg.eigh(covariance)
    return np.asarray((turn * np.sqrt(np.where(sizes < most, np.maximum(sizes, 0.0), 0.0))) @ turn.T)
