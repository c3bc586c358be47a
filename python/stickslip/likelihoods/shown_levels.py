"""Friction of single events as their readings show it, where a fit may start."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.block_windows import largest_drop
from stickslip.likelihoods.declared_numbers import inside
from stickslip.likelihoods.fit_state import Windowed
from stickslip.likelihoods.population import STATIC, Population
from stickslip.likelihoods.stretches import Stretch

Floats = NDArray[np.float64]


def shown_levels(windows: Windowed, at: Floats) -> Floats | None:
    """
    Return the windows' own numbers with the friction that each shows by itself, (w, own).

    None where the readings of a rig do not show it.

    Parameters
    ----------
    windows : and
    at : (p,) coordinates of the shared numbers: friction is relative to that law, and readings have these gains
    """
    if not isinstance(windows, BeltWindows):
        return None
    own, q = windows.first(), windows.begins
    for row, w in zip(own, windows.stretches, strict=True):
        run, values = windows.data[w.run], windows.values(at, w.run)
        scale, stiffness = windows.sensors.on(run.constants).scale(values), values.get("stiffness", 0.0)
        levels = windows.sensors.levels(run.readings[w.start : w.stop] / scale, run.belt_speed > 0, stiffness)
        if levels is None:
            return None
        static, kinetic = levels
        if not w.stuck:
            swing = run.readings[w.start : w.stop, 0] / scale
            kinetic = 0.5 * stiffness * float(swing.max() + swing.min())
        elif abs(run.belt_speed) < run.noise[0]:
            begun, away = _by_time(windows, w, run.readings[w.start : w.stop, 0] / scale)
            row[0], static = scale * begun, stiffness * away
        law = windows.model.friction
        law = law.with_numbers(inside({n: values[n] for n in law.numbers if n in values}))
        level = kinetic / float(law.magnitude(-run.belt_speed)) - 1
        row[:q] /= scale
        row[q:][windows.kinetic] = level
        if w.stuck:  # the level is of all friction, that at rest included
            row[q] = static / (windows.limits[1 if run.belt_speed > 0 else -1].at(values) * (1 + level)) - 1
    return own


def _by_time(windows: BeltWindows, w: Stretch, x: Floats) -> tuple[float, float]:
    """
    Return where a stick begins, and how far it has come when it breaks away, by when the slip is half over.

    Of a belt that noise hides for a radian of the block's, the largest reading says little of when it broke away.
    """
    run = windows.data[w.run]
    good = run.weight[w.start : w.stop, 0] > 0
    t, x, v = run.t[w.start : w.stop][good], np.sign(run.belt_speed) * x[good], abs(run.belt_speed)
    top, low = largest_drop(x)
    half = int(np.flatnonzero(x[: low + 1] >= 0.5 * (top + x[low]))[-1])
    since = float(t[half] - t[0]) - 0.5 * math.pi
    stuck = t - t[0] < max(since, float(t[1] - t[0]))
    start = float(np.mean(x[stuck] - v * (t[stuck] - t[0])))
    return float(np.sign(run.belt_speed)) * start, start + v * since


def shown_scatter(windows: Windowed, own: Floats) -> Population:
    """
    Return how the friction that windows show differs from one to the next; along a slip as usual.

    Parameters
    ----------
    windows, own : and their own numbers, as of `shown_levels`
    """
    usual = windows.scatter()
    assert isinstance(usual, Population)
    u = own[:, windows.begins :]
    level, static = float(np.std(u[:, windows.kinetic].mean(axis=1))), float(np.std(u[:, STATIC]))
    return replace(usual, level=max(level, usual.level), static=max(static, usual.static))
