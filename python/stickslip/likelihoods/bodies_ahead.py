"""A model of a rig of bodies or matrices ahead of its readings, friction that of the mean event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.errors import StickslipError
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.bodies_starts import resolved
from stickslip.likelihoods.bodies_windows import BodiesWindows, RunWindows
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.policy import POLICY

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class WindowForecasts:
    """
    What a model makes of each window from where the one before ends.

    Parameters
    ----------
    error, floor : of all readings, and what their noise alone leaves, over how far they move in a window
    off : (channels,) rms error in the channels' units
    readings : (n, channels) as forecast; NaN where nothing was
    """

    error: float
    floor: float
    off: Floats
    readings: Floats


def _core_run(point: RunWindows, values: Floats, modes: Sequence[int], t: Floats) -> dict[str, Any] | None:
    raw: dict[str, Any] = _core.simulate_bodies(
        **point.lowered.arguments,
        values=values,
        modes=point.lowered.own.modes(modes),
        t_start=float(t[0]),
        t_end=float(t[-1]),
        t_eval=t,
        rtol=POLICY.tolerance,
        atol=resolved(point.of.scales[point.run], POLICY),
        locator=_core.Locator.henon,
        seeds=np.zeros((0, len(values))),
        max_transitions=1_000_000,
        sensed=bool(point.of.sensed),
    )
    return raw if raw["outcome"] == _core.Outcome.finished else None


def free_run(fit: Fit, run: BodiesData, part: slice) -> Floats:
    """Return the readings of a run from the first window's start, friction the model's, which is the mean event's."""
    windows = fit.windows
    assert isinstance(windows, BodiesWindows)
    point = RunWindows(windows, 0, np.zeros(0), [])
    own = fit.own[0].copy()
    own[windows.begins :] = 0.0
    values, _ = point.started(0, own)
    raw = _core_run(point, values, windows.stretches[0].modes, run.t[part])
    if raw is None:
        raise StickslipError("the model's run from the estimated start stops before the end")
    return point.read(raw, own, False)[0]


def one_ahead(fit: Fit, run: BodiesData) -> WindowForecasts:
    """
    Return what the model of a fit forecasts one window ahead; where it cannot be simulated, that nothing moves.

    Parameters
    ----------
    fit : of the run's windows
    run : the run
    """
    windows = fit.windows
    assert isinstance(windows, BodiesWindows)
    point = RunWindows(windows, 0, np.zeros(0), [])
    out = np.full(run.readings.shape, np.nan)
    moved = 0.0
    for i, w in enumerate(windows.stretches[1:], start=1):
        before = windows.stretches[i - 1]
        motion = point.motion(i - 1, fit.own[i - 1]) if before.stop == w.start else None
        if motion is None:
            continue
        own = fit.own[i].copy()
        own[windows.begins :] = 0.0
        layout, state = point.lowered.layout, motion.state[-1]
        values, _ = point.started(i, own)
        values[layout["initial"] : layout["initial"] + len(state)] = state
        t = run.t[before.stop - 1 : w.stop]
        raw = _core_run(point, values, [int(one) for one in motion.mode[-1]], t)
        read, scale = run.readings[w.start : w.stop], run.weight[w.start : w.stop]
        mean = read.mean(axis=0)
        moved += float((((read - mean) * scale) ** 2).sum())
        out[w.start : w.stop] = mean if raw is None else point.read(raw, own, False)[0][1:]
    seen = np.isfinite(out) & (run.weight > 0)
    off = np.where(seen, run.readings - np.where(seen, out, 0.0), 0.0)
    each = np.sqrt((off**2).sum(axis=0) / np.maximum(seen.sum(axis=0), 1))
    if moved == 0:
        return WindowForecasts(np.nan, np.nan, each, out)
    squares = float(((off * run.weight) ** 2).sum())
    return WindowForecasts(float(np.sqrt(squares / moved)), float(np.sqrt(seen.sum() / moved)), each, out)
