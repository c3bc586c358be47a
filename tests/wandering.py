"""A block on a belt whose friction wanders along the belt by more than it falls in a slip, in closed form."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import stickslip as ss
from stickslip.measured.case import Case
from stickslip.measured.memory_case import case_in_memory

RIG = ss.BlockOnBelt(mass=1.2, stiffness=850.0)  # kg, N/m
STATIC, FALL = 6.0, 0.6  # N: mean breakaway; what friction falls by
WANDER, LENGTH = 0.08, 2e-3  # of breakaway, and along the belt [m]
NOISE, STEP = 8e-6, 2.5e-3  # m, s
SPEED = 0.01  # m/s
LAW = ss.CoulombFriction(static=STATIC, kinetic=STATIC - FALL)


def read(seed: int, events: int, rig: ss.BlockOnBelt, by: float = WANDER) -> NDArray[np.float64]:
    """Times and displacements (n, 2): stick and slip in turn, the friction of each event drawn along the belt."""
    rng, k, omega = np.random.default_rng(seed), rig.stiffness, np.sqrt(rig.stiffness / rig.mass)
    starts, parts = [0.0], []
    wander, now, last = by * rng.standard_normal(), (STATIC - 2 * FALL) / k, 0.0
    for _ in range(events):
        keep = np.exp(-SPEED * (starts[-1] - last) / LENGTH)
        wander, last = (
            keep * wander + by * np.sqrt(1 - keep**2) * rng.standard_normal(),
            starts[-1],
        )
        top = max(STATIC * (1 + wander) / k, now + 0.2 * FALL / k)
        away = FALL * float(rng.uniform(0.7, 1.3)) / k  # of the breakaway from where the block would rest
        stuck, phase = (top - now) / SPEED, np.arctan2(omega * away, SPEED)
        slid = (2 * np.pi - 2 * phase) / omega
        parts.append((starts[-1], stuck, now, top, away))
        now = top - away + away * np.cos(omega * slid) + SPEED / omega * np.sin(omega * slid)
        starts.append(starts[-1] + stuck + slid)
    t = np.arange(0.0, starts[-1], STEP)
    x = np.empty_like(t)
    for (begins, stuck, low, top, away), end in zip(parts, starts[1:], strict=True):
        own = (t >= begins) & (t < end)
        since = t[own] - begins - stuck
        slips = top - away + away * np.cos(omega * since) + SPEED / omega * np.sin(omega * since)
        x[own] = np.where(since < 0, low + SPEED * (since + stuck), slips)
    return np.column_stack([t, x + NOISE * rng.standard_normal(len(t))])


def recording(
    seed: int,
    events: int = 30,
    *,
    gain: float = 1.0,
    true: ss.BlockOnBelt = RIG,
    declared: ss.BlockOnBelt = RIG,
    by: float = WANDER,
) -> ss.Recording:
    """What a sensor with a gain reads of a true rig, with what is declared of it; friction wanders by so much."""
    t, x = read(seed, events, true, by).T
    return ss.load_recording(
        {"t": t, "x1": gain * x}, declared, belt_speed=SPEED, noise={"x1": NOISE}, name=f"run_{seed}"
    )


def case_of(*runs: ss.Recording) -> Case:
    """A case of recordings of which the last is to validate."""
    return case_in_memory([*runs[:-1], replace(runs[-1], role="validate")], None, friction=LAW)
