"""Stick-slip motions known exactly, velocity and acceleration included, for the tests of signals.

Written apart from the package: closed form for one degree of freedom, SciPy's DOP853 with events for the
paper's rig.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    t: Floats
    x: Floats
    v: Floats
    a: Floats
    y: Floats  # the angle body; empty for one degree of freedom
    mode: NDArray[np.int8]
    onsets: Floats
    captures: Floats
    belt_speed: float


def coulomb(t: Floats, *, static: float = 1.0, kinetic: float = 0.5, belt_speed: float = 0.2) -> Truth:
    """Block of mass 1 on a spring of stiffness 1, from the onset at t = 0: the closed form."""
    drop, v_b = static - kinetic, belt_speed
    slip, stick = 2.0 * (np.pi - np.arctan(drop / v_b)), 2.0 * drop / v_b
    period = slip + stick
    s = np.mod(t, period)
    slips = s < slip
    x = np.where(slips, kinetic + drop * np.cos(s) + v_b * np.sin(s), 2 * kinetic - static + v_b * (s - slip))
    v = np.where(slips, -drop * np.sin(s) + v_b * np.cos(s), v_b)
    a = np.where(slips, -drop * np.cos(s) - v_b * np.sin(s), 0.0)
    cycles = np.arange(-1, int(t[-1] / period) + 2) * period
    onsets, captures = (e[(e > t[0]) & (e < t[-1])] for e in (cycles, cycles + slip))
    return Truth(t, x, v, a, np.zeros(0), -slips.astype(np.int8), onsets, captures, v_b)


def _magnitude(v: float) -> float:
    """Force of friction on the block, Table 1 of the paper, with the sign of v_w = v."""
    if v > 0.0:
        return max(0.86, 3.63 - v * (3.63 - 0.86) / 0.27)
    left = 0.28 + v
    return -max(1.42, 5.94 - 3.2345 * np.exp(-left / 0.0342) - 2.8736 * np.exp(-left / 0.3053))


def _field(mode: int, v_b: float) -> Callable[[float, Floats], list[float]]:
    def field(_: float, z: Floats) -> list[float]:
        x1, x2, y1, y2 = z
        if mode == 0:
            x2, change = v_b, 0.0
        else:
            v_w = max(x2 - v_b, 1e-300) if mode > 0 else min(x2 - v_b, -0.0)
            change = -x1 - (0.1 * (x2 + y2) + y1 + _magnitude(v_w)) / 16.0
        return [x2, change, y2, (-4.0 * y1 - 0.2 * y2 - x1 - 0.1 * x2) / 8.0]

    return field


def _events(mode: int, v_b: float) -> list[Callable[[float, Floats], float]]:
    def load(z: Floats) -> float:
        return float(16.0 * z[0] + 0.1 * (v_b + z[3]) + z[2])

    if mode == 0:
        events = [lambda _, z: load(z) - 5.94, lambda _, z: load(z) + 3.63]
        directions = [1.0, -1.0]
    else:
        events, directions = [lambda _, z: z[1] - v_b], [-float(mode)]
    for event, direction in zip(events, directions, strict=True):
        event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
    return events


def paper_rig(t: Floats, *, belt_speed: float = 0.1, start: tuple[float, ...] = (0.1, 0.1, 0, 0)) -> Truth:
    """The reference rig of the paper's equations (2.1), reciprocal, v_b > 0, sampled at t >= 0."""
    now, state, mode = 0.0, np.array(start, dtype=np.float64), -1
    if state[1] >= belt_speed:
        mode, state[1] = 0, belt_speed
    values, modes = np.zeros((t.size, 5)), np.zeros(t.size, dtype=np.int8)
    instants: dict[str, list[float]] = {"onset": [], "capture": []}
    while True:
        field = _field(mode, belt_speed)
        run = solve_ivp(
            field, (now, t[-1]), state, "DOP853", rtol=1e-10, atol=1e-12, max_step=0.5, dense_output=True,
            events=_events(mode, belt_speed),
        )  # fmt: skip
        for n in np.flatnonzero((t >= now) & (t <= run.t[-1])):
            z = run.sol(t[n])
            rate = field(t[n], z)
            values[n], modes[n] = (z[0], rate[0], rate[1], z[2], z[3]), mode
        now, state = float(run.t[-1]), run.y[:, -1].copy()
        if run.status != 1:
            break
        load = 16.0 * state[0] + 0.1 * (belt_speed + state[3]) + state[2]
        state[1] = belt_speed
        instants["onset" if mode == 0 else "capture"].append(now)
        sliding = -1 if load > 0 else 1
        mode = 0 if mode != 0 and -3.63 < load < 5.94 else sliding
    x, v, a, y, _ = values.T
    return Truth(t, x, v, a, y, modes, np.array(instants["onset"]), np.array(instants["capture"]), belt_speed)
