"""Where a condition holds for a while: runs of True in a mask."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def intervals(mask: NDArray[np.bool_], apart: int = 1) -> NDArray[np.intp]:
    """First and last index of each run of True, shape (k, 2); places at most `apart` from each other are in one run."""
    at = np.flatnonzero(mask)
    if not len(at):
        return np.zeros((0, 2), dtype=np.intp)
    breaks = np.flatnonzero(np.diff(at) > apart)
    return np.column_stack([at[np.r_[0, breaks + 1]], at[np.r_[breaks, len(at) - 1]]])
