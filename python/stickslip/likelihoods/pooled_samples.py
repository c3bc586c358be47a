"""The samples of windows of several runs, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.data import Data
from stickslip.fitted.means import instants
from stickslip.likelihoods.stretches import Stretch

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class PooledSamples:
    """
    What windows read, and when.

    Parameters
    ----------
    t, readings, weight : (n,), (n, channels) twice, of all runs
    rows : which of these are a window's, by window
    instants : times at which a window is simulated, by window
    """

    t: Floats
    readings: Floats
    weight: Floats
    rows: list[NDArray[np.int64]]
    instants: list[Floats]

    @classmethod
    def of(cls, data: Sequence[Data], stretches: Sequence[Stretch]) -> PooledSamples:
        """Return those of windows of some runs."""
        before = np.concatenate([[0], np.cumsum([len(run.t) for run in data])])
        return cls(
            np.concatenate([run.t for run in data]),
            np.concatenate([run.readings for run in data]),
            np.concatenate([run.weight for run in data]),
            [before[w.run] + np.arange(w.start, w.stop) for w in stretches],
            [instants(data[w.run], w.start, w.stop) for w in stretches],
        )
