"""The runs of a fit as a report draws them: measured, and as the models before and after have them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.result import RunView
from stickslip.fitted.data import Data
from stickslip.fitted.readings import reading_rate
from stickslip.likelihoods.fit import Fit

Floats = NDArray[np.float64]


def train_views(bench: Bench, before: Fit, after: Fit) -> list[RunView]:
    """Return the runs of the fit as the report draws them."""
    return [_view(bench, r, before, after) for r in range(len(bench.data))]


def _view(bench: Bench, number: int, before: Fit, after: Fit) -> RunView:
    run = bench.data[number]
    made = [_made(bench, number, fit) for fit in (before, after)]
    (was, was_rate, was_state, was_mode), (now, now_rate, now_state, now_mode) = made
    channels = run.channels
    return RunView(
        name=run.name,
        role=run.role,
        belt_speed=run.belt_speed,
        t=run.t,
        measured={c: run.readings[:, i] for i, c in enumerate(channels)},
        noise={c: float(run.noise[i]) for i, c in enumerate(channels)},
        before={c: was[:, i] for i, c in enumerate(channels)},
        after={c: now[:, i] for i, c in enumerate(channels)},
        rate_before=was_rate,
        rate_after=now_rate,
        state_before=was_state[:, :4],
        state_after=now_state[:, :4],
        mode_before=was_mode,
        mode_after=now_mode,
        force_before=_force(run, was_state, bench.model.rig),
        force_after=_force(run, now_state, bench.model.rig),
        speed_before=was_state[:, 1] - run.belt_speed - was_state[:, 6],
        speed_after=now_state[:, 1] - run.belt_speed - now_state[:, 6],
    )


def _made(bench: Bench, number: int, fit: Fit) -> tuple[Floats, Floats, Floats, NDArray[np.int8]]:
    run = bench.data[number]
    n = len(run.t)
    readings, rate = np.full(run.readings.shape, np.nan), np.full(n, np.nan)
    state, mode = np.full((n, 9), np.nan), np.zeros(n, dtype=np.int8)
    values = fit.values(number)
    for s, motion in zip(bench.stretches, fit.windows.motions(fit.at, fit.own), strict=True):
        if s.run != number or motion is None:
            continue
        rows = slice(s.start, s.stop)
        readings[rows], state[rows], mode[rows] = motion.readings, motion.state, motion.mode
        rate[rows] = reading_rate(motion.t, motion.state, values)
    return readings, rate, state, mode


def _force(run: Data, state: Floats, rig: object) -> Floats:
    """T that the declared equation of motion needs for the simulated motion."""
    acceleration = np.gradient(state[:, 1], run.t)
    if isinstance(rig, BlockOnBelt):
        return np.asarray(
            -(rig.mass * acceleration + rig.damping * state[:, 1] + rig.stiffness * state[:, 0])
        )
    assert isinstance(rig, Rig)
    sign = 1.0 if rig.coupling == "reciprocal" else -1.0
    inertia = rig.alpha1 * (acceleration + state[:, 0])
    return np.asarray(-(inertia + rig.eta1 * (state[:, 1] + state[:, 3]) + sign * state[:, 2]))
