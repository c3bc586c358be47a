"""Events with their own levels under a model's constants: what a model leaves when friction may differ each time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Effect
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.fitted.block_events.cycle import LOG_W2, RATE, RELEASE, ZETA, K, S, positions
from stickslip.fitted.block_events.fit import Fitted, Prior, Windows, fit
from stickslip.fitted.block_events.levels import damping, true_stiffness
from stickslip.fitted.block_events.sensor import reading_of
from stickslip.fitted.block_events.table import Measured, cut

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Constants:
    """What a model says of every event: rise over the set-point speed, ln(k/m), damping."""

    rate: float
    log_w2: float
    zeta: float


@dataclass(frozen=True)
class Held:
    """Events of a run under a model: numbers (k, 6), residual over noise (k, n), NaN beyond an event."""

    p: Floats
    residual: Floats


def constants_of(model: Model, measured: Measured) -> Constants:
    """The constants of a model on a run, the run's own declared stiffness and mass in place of the model's."""
    run = measured.run
    known = {one.name: one.parameters for one in model.effects if isinstance(one, Effect)}
    reading = reading_of(model, run.force_channel)
    assert isinstance(model.rig, BlockOnBelt)
    stiffness = run.rig.stiffness * true_stiffness(model) / model.rig.stiffness
    mass = run.rig.mass * (1 + known.get("rig_mass", {}).get("e", 0.0))
    fastest = (
        0.5 * float(np.median(measured.events.slip)) * np.sqrt(stiffness / mass)
        if len(measured.events)
        else 0.0
    )
    c = run.rig.damping - model.rig.damping + damping(model, fastest)
    middle = float(np.median(measured.events.p[:, S])) if len(measured.events) else 0.0
    slope = float(reading.bend.slope(np.array(middle))) + reading.bend.drift / run.belt_speed
    squeeze = known.get("contact_compliance", {}).get("k")
    if squeeze is not None:
        slope *= squeeze / (squeeze + stiffness)
    return Constants(slope, float(np.log(stiffness / mass)), float(c / (2 * np.sqrt(stiffness * mass))))


def held(measured: Measured, constants: Constants) -> Held:
    """Fit every event's own levels and instant, all else as the model has it."""
    run, e = measured.run, measured.events
    if not len(e):
        return Held(np.zeros((0, 6)), np.zeros((0, 0)))
    windows = cut(run, e.window)
    found = [_fitted(measured, windows, constants, late) for late in (0.0, 0.4)]
    costs = [np.nansum(one.residual**2, axis=1) for one in found]
    take = (costs[1] < costs[0])[:, None]
    return Held(np.where(take, found[1].p, found[0].p), np.where(take, found[1].residual, found[0].residual))


def _fitted(measured: Measured, windows: Windows, constants: Constants, late: float) -> Fitted:
    """Least squares from a breakaway `late` natural radians after the one found freely."""
    run, e = measured.run, measured.events
    w = np.exp(0.5 * constants.log_w2)
    start = e.p.copy()
    start[:, RATE], start[:, LOG_W2] = constants.rate * run.belt_speed, constants.log_w2
    start[:, ZETA] = constants.zeta
    start[:, RELEASE] += late / w
    start[:, K] = np.minimum(0.5 * (e.p[:, S] + e.arrest), start[:, S] - run.noise)
    size = np.maximum(e.slip, 5 * run.noise)
    spread = np.empty_like(start)
    spread[:, [S, K]] = 100 * size[:, None]
    spread[:, RELEASE] = 10 / w
    spread[:, RATE], spread[:, LOG_W2], spread[:, ZETA] = 1e-6 * run.belt_speed, 1e-6, 1e-6
    return fit(windows, start, Prior(start, spread), tail=np.inf)


def motion(measured: Measured, one: Held) -> tuple[Floats, Floats, NDArray[np.int8]]:
    """Readings, velocities and modes of the events along the run, (n,); NaN and 0 between them."""
    run, n = measured.run, len(measured.run.t)
    x, v, mode = np.full(n, np.nan), np.full(n, np.nan), np.zeros(n, dtype=np.int8)
    if not len(one.p):
        return x, v, mode
    windows = cut(run, measured.events.window)
    values = positions(one.p, windows.t)
    for i, (a, b) in enumerate(measured.events.window):
        x[a:b] = values[i, : b - a]
        v[a:b] = np.gradient(values[i, : b - a], run.t[a:b])
    sliding = v < run.belt_speed * 0.5
    mode[sliding & np.isfinite(v)] = -1
    return x, v, mode
