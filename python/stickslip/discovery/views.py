"""Runs as the report draws them: measured, and as the models before and after have them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.data import Data
from stickslip.discovery.errors import Measured
from stickslip.discovery.result import RunView
from stickslip.discovery.solve import Fit
from stickslip.rig import Rig

Floats = NDArray[np.float64]


def train_view(run: Data, number: int, before: Fit, after: Fit) -> RunView:
    """A run of the fit."""
    return _view(run, _fitted(before, number), _fitted(after, number), before.engine.hypothesis.model.rig)


def validate_view(run: Data, before: Measured, after: Measured, rig: object) -> RunView:
    """A run that was forecast; NaN before the first forecast."""
    return _view(run, _forecast(run, before), _forecast(run, after), rig)


def _fitted(fit: Fit, number: int) -> tuple[Floats, Floats, NDArray[np.int8]]:
    """Readings, states and modes of a run in the fit; NaN where no window is."""
    run = fit.engine.data[number]
    readings, states, modes = _nothing(run)
    for w, b in zip(fit.windows, fit.blocks, strict=True):
        if w.run != number:
            continue
        done, rows = fit.engine.simulate(fit.vector, [w]), slice(w.start, w.stop)
        if done.ok[0]:
            states[rows] = done.state
        modes[rows] = done.mode
        noise = np.where(run.weight[rows] > 0, run.noise, np.nan)
        readings[rows] = run.readings[rows] - b.r.reshape(w.stop - w.start, -1) * noise
    return readings, states, modes


def _nothing(run: Data) -> tuple[Floats, Floats, NDArray[np.int8]]:
    n = len(run.t)
    return np.full((n, run.readings.shape[1]), np.nan), np.full((n, 9), np.nan), np.zeros(n, dtype=np.int8)


def _forecast(run: Data, measured: Measured) -> tuple[Floats, Floats, NDArray[np.int8]]:
    readings, states, modes = _nothing(run)
    readings[measured.samples] = measured.prediction.readings
    states[measured.samples] = measured.prediction.state
    modes[measured.samples] = measured.prediction.mode
    return readings, states, modes


def _view(
    run: Data,
    before: tuple[Floats, Floats, NDArray[np.int8]],
    after: tuple[Floats, Floats, NDArray[np.int8]],
    rig: object,
) -> RunView:
    channels = run.channels
    return RunView(
        name=run.name,
        role=run.role,
        belt_speed=run.belt_speed,
        t=run.t,
        measured={c: run.readings[:, i] for i, c in enumerate(channels)},
        noise={c: float(run.noise[i]) for i, c in enumerate(channels)},
        before={c: before[0][:, i] for i, c in enumerate(channels)},
        after={c: after[0][:, i] for i, c in enumerate(channels)},
        state_before=before[1][:, :4],
        state_after=after[1][:, :4],
        mode_before=before[2],
        mode_after=after[2],
        force_before=_force(run, before[1], rig),
        force_after=_force(run, after[1], rig),
        speed_before=before[1][:, 1] - run.belt_speed - before[1][:, 6],
        speed_after=after[1][:, 1] - run.belt_speed - after[1][:, 6],
    )


def _force(run: Data, state: Floats, rig: object) -> Floats:
    """T that the declared equation of motion needs for the simulated motion: friction and whatever else acts."""
    assert isinstance(rig, Rig)
    sign = 1.0 if rig.coupling == "reciprocal" else -1.0
    acceleration = np.gradient(state[:, 1], run.t)
    inertia = rig.alpha1 * (acceleration + state[:, 0])
    return np.asarray(-(inertia + rig.eta1 * (state[:, 1] + state[:, 3]) + sign * state[:, 2]))
