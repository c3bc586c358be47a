"""What a figure of motion needs: velocities, and the friction force that the readings imply."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.effect import Effect
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.discovery.result import RunView
from stickslip.errors import StickslipError
from stickslip.fitted.friction_force import friction_force
from stickslip.measured import signals

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class MeasuredMotion:
    """The readings of a run smoothed: t, x1, x2, friction force and v_w, all (n,), in model units.

    `sure` marks samples whose force is not blurred by a transition near by.
    """

    t: Floats
    x1: Floats
    x2: Floats
    force: Floats
    v_w: Floats
    sure: NDArray[np.bool_]


def measured(model: Model, run: RunView) -> MeasuredMotion | None:
    """Velocity and friction force from a run's readings by smoothing splines and (2.1) solved for T.

    Returns None where a channel cannot be smoothed, or where a run misses readings.
    """
    if "y1" not in run.measured:
        return _one_degree(model, run)
    x1, y1 = run.measured["x1"], run.measured["y1"]
    good = np.isfinite(x1) & np.isfinite(y1)
    try:
        x = signals.smooth(run.t[good], x1[good], noise=run.noise["x1"])
        y = signals.smooth(run.t[good], y1[good], noise=run.noise["y1"])
    except StickslipError:
        return None
    force = friction_force(model.rig, (x.x, x.v, x.a), (y.x, y.v))
    v_w = x.v - run.belt_speed
    rough = np.abs(np.gradient(x.a, x.t))
    return MeasuredMotion(x.t, x.x, x.v, force, v_w, rough <= 3 * np.median(rough))


def _one_degree(model: Model, run: RunView) -> MeasuredMotion:
    """A block on a belt: local cubics over an eighth of a natural period, since real contacts jerk."""
    assert isinstance(model.rig, BlockOnBelt)
    good = np.isfinite(run.measured["x1"])
    x = np.interp(run.t, run.t[good], run.measured["x1"][good])
    dt = float(np.median(np.diff(run.t)))
    period = 2 * np.pi * float(np.sqrt(model.rig.mass / model.rig.stiffness))
    width = min(max(int(period / 8 / dt), 7) | 1, (len(x) - 1) // 2 * 2 - 1)
    smooth, v, a = (scipy.signal.savgol_filter(x, width, 3, deriv=k, delta=dt) for k in range(3))
    rough = np.abs(np.gradient(a, run.t))
    force = friction_force(model.rig, (smooth, v, a))
    return MeasuredMotion(run.t, smooth, v, force, v - run.belt_speed, rough <= 3 * np.median(rough))


def broken(t: Floats, state: Floats, *columns: Floats) -> tuple[Floats, ...]:
    """The columns with NaN put where one forecast ends and the next begins, so that no line joins them.

    A join shows as a step of x1 that its velocity does not account for.
    """
    if not np.isfinite(state[:, 0]).any():  # nothing was predicted
        return columns
    step = np.diff(state[:, 0])
    implied = 0.5 * np.diff(t) * (state[1:, 1] + state[:-1, 1])
    miss = np.abs(step - implied)
    size = float(np.nanmax(state[:, 0]) - np.nanmin(state[:, 0])) or 1.0
    at = np.flatnonzero(miss > max(0.004 * size, 30 * float(np.nanmedian(miss)))) + 1
    return tuple(np.insert(np.asarray(one, dtype=np.float64), at, np.nan) for one in columns)


def residual(run: RunView, which: str, channel: str) -> Floats:
    """(measured - predicted)/noise of a channel, (n,); `which` is "before" or "after"."""
    predicted = (run.before if which == "before" else run.after)[channel]
    return np.asarray((run.measured[channel] - predicted) / run.noise[channel])


def phase_of(model: Model, run: RunView, name: str, phi: float) -> Floats | None:
    """Phase in [0, 2 pi) of a periodic effect at the run's samples; None for an effect that has none."""
    one = next((e for e in model.effects if isinstance(e, Effect) and e.name == name), None)
    if one is None:
        return None
    if "w" in one.parameters:
        angle = one.parameters["w"] * run.t + phi
    elif "L" in one.parameters:
        angle = 2 * np.pi * (run.belt_speed * run.t - run.state_before[:, 0]) / one.parameters["L"] + phi
    else:
        return None
    return np.asarray(np.mod(angle, 2 * np.pi))
