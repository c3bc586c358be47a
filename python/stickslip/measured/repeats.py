"""Readings that only repeat the one before: a channel that was held, not measured."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stickslip.measured.intervals import intervals
from stickslip.measured.signals import quantisation

Floats = NDArray[np.float64]
SAME = 5  # readings in a row that are one and the same, at least, to be no noise
CHANCE = 1e-3  # how often noise may make so many in a run


def held(values: Floats, noise: float) -> NDArray[np.bool_]:
    """Readings that repeat the one before, in a row too long for noise: a channel that was held, not measured."""
    out = np.zeros(len(values), dtype=bool)
    alike = quantisation(values).noise / noise  # at most the chance of two neighbours
    if not alike < 0.5:
        return out
    least = max(SAME, 2 + math.ceil(math.log(CHANCE / len(values)) / math.log(max(alike, 1e-9))))
    for a, b in intervals(np.diff(values) == 0):  # of a reading like the one before
        if b - a + 2 >= least:
            out[a + 1 : b + 2] = True
    return out


def held_sentence(run: str, channel: str, t: Floats, mask: NDArray[np.bool_]) -> str:
    """What was found held in a channel, `mask` (n,) not empty, at times `t` (n,) from the run's start."""
    return (
        f"{run}: {channel} repeats one reading over {int(mask.sum())} samples, first at t = "
        f"{t[np.argmax(mask)]:.4g} (model units): held, not measured, and left out"
    )
