"""Simulations of means: a reading that is the mean of neighbours is met by two instants (`Window.instants`)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.data import Data

Floats = NDArray[np.float64]


def instants(run: Data, start: int, stop: int) -> Floats:
    """Times at which samples start <= i < stop are simulated: those of single readings, or two for each mean."""
    t = run.t[start:stop]
    return np.column_stack([t - run.half, t + run.half]).ravel() if run.half else t


def pooled(
    raw: Mapping[str, object], twice: NDArray[np.bool_] | bool, lengths: NDArray[np.int64]
) -> Mapping[str, object]:
    """What the core made of windows, those of means (w,) given by pairs of instants, as rows of `lengths` (w,) each."""
    if not np.any(twice):
        return raw
    each = np.repeat(1 + np.broadcast_to(twice, lengths.shape), lengths)  # instants of a row
    first = np.cumsum(each) - each
    state, slopes, mode = (np.asarray(raw[name]) for name in ("state", "slopes", "mode"))
    return {
        **raw,
        "state": np.add.reduceat(state, first, axis=0) / each[:, None],
        "slopes": np.add.reduceat(slopes, first, axis=1) / each[:, None]
        if slopes.size
        else slopes[:, : len(each)],
        "mode": mode[first],
    }
