"""Friction of single events as their readings show it, where a fit may start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit_state import Windowed

Floats = NDArray[np.float64]


def shown_levels(windows: Windowed) -> Floats | None:
    """
    Return the windows' own numbers with the friction that each shows by itself, (w, own).

    None where the readings of a rig do not show it.
    """
    if not isinstance(windows, BeltWindows):
        return None
    own, q = windows.first(), windows.begins
    stiffness = windows.fixed.get("stiffness", 0.0)
    for row, w in zip(own, windows.stretches, strict=True):
        run = windows.data[w.run]
        shown = windows.sensors.levels(run.readings[w.start : w.stop], run.belt_speed > 0, stiffness)
        if shown is None:
            return None
        static, kinetic = shown
        level = kinetic / float(windows.model.friction.magnitude(-run.belt_speed)) - 1
        row[q:][windows.kinetic] = level
        row[q] = static / windows.limits[1 if run.belt_speed > 0 else -1].declared - 1 - level
    return own
