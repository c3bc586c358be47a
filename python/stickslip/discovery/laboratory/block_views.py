"""Runs of a block on a belt as the report draws them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.discovery.laboratory.block_errors import BlockForecasts
from stickslip.discovery.result import RunView
from stickslip.fitted.block_events.levels import damping, true_stiffness
from stickslip.fitted.block_events.sensor import reading_of
from stickslip.fitted.block_events.table import MeasuredBlock

Floats = NDArray[np.float64]
Ints = NDArray[np.int8]
Motion = tuple[Floats, Floats, Ints]
MOST = 20_000  # samples of a run drawn
THINNEST = 4


def validate_view(
    one: MeasuredBlock, before: Model, after: Model, forecasts: tuple[BlockForecasts, BlockForecasts]
) -> RunView:
    """A run that was forecast; NaN where no forecast was made."""
    was, now = (_forecast(one, f) for f in forecasts)
    return view(one, before, after, was, now)


def _forecast(one: MeasuredBlock, ahead: BlockForecasts) -> Motion:
    n = len(one.run.t)
    x, v, mode = np.full(n, np.nan), np.full(n, np.nan), np.zeros(n, dtype=np.int8)
    for p in ahead.predictions:
        a, b = np.searchsorted(one.run.t, [p.t[0], p.t[-1]])
        t = one.run.t[a : b + 1]
        x[a : b + 1] = np.interp(t, p.t, p.reading)
        v[a : b + 1] = np.interp(t, p.t, np.gradient(p.reading, p.t))
        mode[a : b + 1] = p.mode[np.clip(np.searchsorted(p.t, t), 0, len(p.t) - 1)]
    return x, v, mode


def view(one: MeasuredBlock, before: Model, after: Model, was: Motion, now: Motion) -> RunView:
    """A run as measured and as two motions have it."""
    run = one.run
    step = min(max(1, len(run.t) // MOST), THINNEST)
    at = slice(0, MOST * step, step)
    states = [state_read(one, model, m) for model, m in ((before, was), (after, now))]
    forces = [_force(one, model, s, at) for model, s in zip((before, after), states, strict=True)]
    sign = run.sign
    return RunView(
        name=run.name,
        role=run.role,
        belt_speed=sign * run.belt_speed,
        t=run.t[at],
        measured={"x1": sign * run.x[at]},
        noise={"x1": run.noise},
        before={"x1": sign * was[0][at]},
        after={"x1": sign * now[0][at]},
        rate_before=sign * was[1][at],
        rate_after=sign * now[1][at],
        state_before=sign * _seen(was)[at],
        state_after=sign * _seen(now)[at],
        mode_before=(sign * was[2][at]).astype(np.int8),
        mode_after=(sign * now[2][at]).astype(np.int8),
        force_before=sign * forces[0],
        force_after=sign * forces[1],
        speed_before=sign * (states[0][at, 1] - run.belt_speed),
        speed_after=sign * (states[1][at, 1] - run.belt_speed),
    )


def state_read(one: MeasuredBlock, model: Model, m: Motion) -> Floats:
    """(n, 2) deflections and velocities behind predicted readings and their rates."""
    reading = reading_of(model, one.run.force_channel)
    x = reading.bend.undone(m[0], one.run.t)
    return np.column_stack([x, reading.bend.moves(x, m[1])])


def _seen(m: Motion) -> Floats:
    """(n, 4) readings and their rates, for portraits of readings."""
    none = np.zeros(len(m[0]))
    return np.column_stack([m[0], m[1], none, none])


def _force(one: MeasuredBlock, model: Model, state: Floats, at: slice) -> Floats:
    """T that the equation of motion needs, -(m x'' + c x' + k x)."""
    assert isinstance(model.rig, BlockOnBelt)
    stiffness = one.run.rig.stiffness * true_stiffness(model) / model.rig.stiffness
    acceleration = np.gradient(state[:, 1], one.run.t)
    drag = damping(model, 0.0) * state[:, 1]
    return np.asarray(-(one.run.rig.mass * acceleration + drag + stiffness * state[:, 0]))[at]
