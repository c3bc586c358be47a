"""What is drawn of a model at one belt speed, and what was measured to lay beneath it; in the readings' units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.declared.scale import Quantity, Scale, scales
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.identify_windows import natural_period
from stickslip.measured import signals
from stickslip.measured.recording import Recording
from stickslip.simulated.simulate import simulate

Floats = NDArray[np.float64]
PERIODS = 20  # natural ones that are simulated: a cycle settles within a few of them
SAMPLES = 1000
TOLERANCE = 1e-7  # far below a pixel
LAW = 200  # points of the friction law on either side


@dataclass(frozen=True)
class Curves:
    """t, x1 (n,), the second half's portrait x, v (m,), and the law: v_w, T (k,) with NaN at v_w = 0."""

    t: Floats
    x1: Floats
    x: Floats
    v: Floats
    v_w: Floats
    force: Floats
    sticks: bool  # whether the block sticks in the second half


def units(model: Model) -> dict[Quantity, Scale]:
    """Sizes and units of what is drawn."""
    return scales(model.rig, model.channels)


def refuse(model: Model) -> None:
    """Refuse a rig without a belt of its own.

    Raises
    ------
    InputError
        Of another rig than (2.1)'s and the block on a belt.
    """
    if not isinstance(model.rig, (Rig, BlockOnBelt)):
        known = "the rig of (2.1) and a block on a belt can be explored"
        raise InputError(f"a {type(model.rig).__name__} has no belt to set; {known}", key="MODEL")


def curves(model: Model, belt_speed: float) -> Curves:
    """Simulate from rest and return what is drawn.

    Parameters
    ----------
    model : Model
    belt_speed : float
        v_b in the model's unit.

    Raises
    ------
    StickslipError
        The run stops before its end.
    """
    size = units(model)
    t = np.linspace(0.0, PERIODS * natural_period(model.rig), SAMPLES)
    run = simulate(model, belt_speed=belt_speed, t_end=float(t[-1]), t_eval=t, rtol=TOLERANCE, atol=TOLERANCE)
    if len(run.t) < len(t):
        raise StickslipError(f"the run stops at t = {size['t'].of(float(run.t[-1]))}: {run.status.value}")
    late = slice(len(t) // 2, None)
    x1, x2 = run.state[:, 0], run.state[:, 1]
    reach = max(float(np.abs(x2 - belt_speed).max()), abs(belt_speed))
    side = np.linspace(0.0, reach, LAW + 1)[1:]
    v_w = np.concatenate([-side[::-1], [np.nan], side])
    force = np.concatenate([model.friction.force(-side[::-1]), [np.nan], model.friction.force(side)])
    return Curves(
        size["t"].size * run.t,
        size["x1"].size * x1,
        size["x1"].size * x1[late],
        size["x2"].size * x2[late],
        size["x2"].size * v_w,
        size["force"].size * np.asarray(force, dtype=np.float64),
        bool(np.any(run.mode[late] == 0)),
    )


def measured(model: Model, run: Recording) -> dict[str, Floats]:
    """A run's readings as drawn: t from 0, x1, and the velocity of x1 by a smoothing spline."""
    size = units(model)
    good = np.isfinite(run.x1)
    t, x1 = run.t[good] - run.t[0], run.x1[good]
    try:
        smooth = signals.smooth(t, x1)
        x, v = smooth.x, smooth.v
    except StickslipError:  # too rough for a spline
        x, v = x1, np.gradient(x1, t)
    return {
        "t": size["t"].size * t,
        "x1": size["x1"].size * x1,
        "x": size["x1"].size * x,
        "v": size["x2"].size * v,
    }
