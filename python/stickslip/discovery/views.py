"""Runs as the report draws them: measured, and as the models before and after have them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.rig import Rig
from stickslip.discovery.errors import ForecastErrors
from stickslip.discovery.result import RunView
from stickslip.fitted.data import Data
from stickslip.simulated.states import BELT, X1, X2, Y1, Y2

Floats = NDArray[np.float64]


@dataclass
class Made:
    """What a model makes of a run: readings (n, c), the rate of x1's (n,), states (n, 9), modes (n,); NaN for none."""

    readings: Floats
    rate: Floats
    state: Floats
    mode: NDArray[np.int8]


def validate_view(run: Data, before: ForecastErrors, after: ForecastErrors, rig: object) -> RunView:
    """A run that was forecast; NaN before the first forecast."""
    seen = view(run, _forecast(run, before), _forecast(run, after), rig)
    if after.band is None:
        return seen
    low, high = np.full((2, *run.readings.shape), np.nan)
    low[after.samples, :2], high[after.samples, :2] = after.band
    sides = [{c: side[:, i] for i, c in enumerate(run.channels[:2])} for side in (low, high)]
    return replace(seen, low=sides[0], high=sides[1])


def nothing(run: Data) -> Made:
    """A run of which a model makes nothing."""
    n = len(run.t)
    none = np.full(n, np.nan)
    return Made(
        np.full(run.readings.shape, np.nan), none, np.full((n, 9), np.nan), np.zeros(n, dtype=np.int8)
    )


def _forecast(run: Data, measured: ForecastErrors) -> Made:
    made, got = nothing(run), measured.prediction
    made.readings[measured.samples] = got.readings
    made.rate[measured.samples] = got.rate
    made.state[measured.samples] = got.state
    made.mode[measured.samples] = got.mode
    return made


def view(run: Data, before: Made, after: Made, rig: object) -> RunView:
    """A run as measured and as two models have it."""
    channels = run.channels
    return RunView(
        name=run.name,
        role=run.role,
        belt_speed=run.belt_speed,
        t=run.t,
        measured={c: run.readings[:, i] for i, c in enumerate(channels)},
        noise={c: float(run.noise[i]) for i, c in enumerate(channels)},
        before={c: before.readings[:, i] for i, c in enumerate(channels)},
        after={c: after.readings[:, i] for i, c in enumerate(channels)},
        rate_before=before.rate,
        rate_after=after.rate,
        state_before=before.state[:, :4],
        state_after=after.state[:, :4],
        mode_before=before.mode,
        mode_after=after.mode,
        force_before=_force(run, before.state, rig),
        force_after=_force(run, after.state, rig),
        speed_before=before.state[:, X2] - run.belt_speed - before.state[:, BELT],
        speed_after=after.state[:, X2] - run.belt_speed - after.state[:, BELT],
    )


def _force(run: Data, state: Floats, rig: object) -> Floats:
    """T that the declared equation of motion needs for the simulated motion: friction and whatever else acts."""
    assert isinstance(rig, Rig)
    sign = 1.0 if rig.coupling == "reciprocal" else -1.0
    acceleration = np.gradient(state[:, X2], run.t)
    inertia = rig.alpha1 * (acceleration + state[:, X1])
    return np.asarray(-(inertia + rig.eta1 * (state[:, X2] + state[:, Y2]) + sign * state[:, Y1]))
