"""From simulated motion to sensor readings: the run of one record, hidden history included."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rigsim
from numpy.typing import NDArray
from truths import READING_FIELDS

Array = NDArray[np.float64]
NO_WANDER = np.zeros(2)


def pack(values: Mapping[str, float]) -> np.void:
    """The simulator's record of numbers; what acts on readings only is left out."""
    numbers: np.void = np.zeros(1, rigsim.NUMBERS)[0]
    for name, value in values.items():
        if name not in READING_FIELDS:
            numbers[name] = value
    return numbers


def simulate(
    values: Mapping[str, float],
    times: Array,
    start: Array,
    *,
    since: float = 0.0,
    h_max: float = 0.005,
    wander: Array = NO_WANDER,
    extrapolate: bool = False,
) -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """Noise-free readings ``x1``, ``y1``, the belt's speed and the contact mode at ``times``.

    ``start`` is the simulator's state at ``times[0]``. With a delay the angle body is needed before
    ``times[0]``; with ``extrapolate`` it is continued backwards with constant velocity, otherwise the caller
    must have started early and sees the record from its own first sample on.
    """
    delay = values.get("delay", 0.0)
    late = times - delay
    inside = late >= times[0]
    grid, where = np.unique(np.concatenate([times, late[inside]]), return_inverse=True)
    numbers = pack(values)
    states, modes, _ = rigsim.run(grid, start, since, h_max, numbers, wander)
    now = where[: times.size]
    x1, y1 = states[now, 0], states[now, 2].copy()
    if delay > 0.0:
        y1[inside] = states[where[times.size :], 2]
        y1[~inside] = start[2] + (start[3] * (late[~inside] - times[0]) if extrapolate else 0.0)
    x_read = x1 + values.get("crosstalk_c", 0.0) * states[now, 2]
    if values.get("lag_tau", 0.0) > 0.0:
        x_read = states[now, 7]
    x_read = x_read + values.get("nonlinear_q", 0.0) * x_read**2 + values.get("x1_cubic", 0.0) * x_read**3
    x_read = x_read + values.get("drift_x1", 0.0) * times
    if values.get("y1_lag_tau", 0.0) > 0.0:
        y1 = states[now, 10]
    y_read = y1 + values.get("y1_quadratic", 0.0) * y1**2 + values.get("y1_crosstalk", 0.0) * x1
    y_read = y_read + values.get("drift_y1", 0.0) * times
    if (limit := values.get("y1_saturation", 0.0)) > 0.0:
        y_read = limit * np.tanh(y_read / limit)
    belt = np.array([rigsim.belt_speed(t, s, numbers)[0] for t, s in zip(times, states[now], strict=True)])
    return x_read, y_read, belt, modes[now]
