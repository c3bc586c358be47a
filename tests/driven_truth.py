"""A driven slider in its position loop, moved in closed form from sample to sample; no code of the package.

Between two samples the drive is held: m v' = F - c v - sgn(v) R has an exponential solution up to v = 0, where the
slider turns or stays.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "bench" / "discovery"))
from driven_draw import draw as draw
from driven_draw import exact

sys.path.pop(0)

MASS, DAMPING, MINUS, PLUS = 12.0, 30.0, 7.0, 5.0
GAIN, KP, KV = 4.0, 60.0, 40.0  # N/V, 1/s, V s/m
RATE = 500.0
QUANTUM = 2e-7


def moved(x, v, force, h, minus=MINUS, plus=PLUS, m=MASS, c=DAMPING):
    """Position and velocity after a time h under a constant force, turns and rests included."""
    return exact(x, v, force, h, m, c, minus, plus)


def reference(t):
    """A set-point that runs to and fro at three speeds (n,)."""
    speed = np.zeros_like(t)
    for start, level in ((0.0, 0.05), (1.1, 0.1), (2.0, 0.16), (2.9, -0.05), (4.0, -0.1), (4.9, -0.16)):
        phase = np.mod(t, 5.8)
        speed[phase >= start] = level
    smooth = np.ones(25) / 25
    return np.cumsum(np.convolve(speed, smooth, mode="same")) / RATE


def record(
    seconds,
    *,
    seed=0,
    noise=0.25,
    colour=0.8,
    reading=0.0,
    closed=True,
    force=None,
    friction=None,
    delay=0,
    step=QUANTUM,
):
    """Times, positions and commands [V] (n,).

    `noise` [N] is the standard deviation of the force noise, `colour` its memory per sample. Readings have an encoder's
    `step` [m] or, with `reading` [m], white noise of that size, which the loop feeds back. Not `closed`: three sines
    drive the slider. `force(x, t)` acts on it too, `friction(x)` multiplies friction, `delay` counts samples.
    """
    generator = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE)) / RATE
    goal = reference(t)
    plan = (15 * np.sin(2.2 * t) + 8 * np.sin(8 * t + 1) + 5 * np.sin(31 * t + 2)) / GAIN
    x = v = 0.0
    last = before = 0.0
    out, commands = np.empty(len(t)), np.empty(len(t))
    disturbance = 0.0
    for k in range(len(t)):
        read = x + reading * generator.standard_normal() if reading else step * round(x / step)
        u = KP * KV * (goal[k] - read) - KV * 0.5 * (read - before) * RATE if closed else plan[k]
        before, last = last, read
        out[k], commands[k] = read, u
        disturbance = colour * disturbance + noise * math.sqrt(1 - colour**2) * generator.standard_normal()
        total = (
            GAIN * commands[max(k - delay, 0)]
            + disturbance
            + (force(x + 0.5 * v / RATE, t[k]) if force else 0.0)
        )
        scale = friction(x) if friction else 1.0
        x, v = moved(x, v, total, 1 / RATE, MINUS * scale, PLUS * scale)
    return t, out, commands


RIG = f"""title = "a slider on a screw"

[rig]
kind = "driven_slider"
m = {MASS}

[friction]
kind = "coulomb"
static = 6.0
kinetic = 6.0

[[run]]
file = "run.csv"
role = "train"
to = 17.4

[[run]]
file = "run.csv"
role = "validate"
from = 17.4

[channels]
t = {{ column = "t", unit = "s" }}
x1 = {{ column = "x", unit = "mm" }}
drive = {{ column = "u", unit = "V", scale = {GAIN} }}
"""


def write_case(folder: Path, *, seconds: float = 29.0, train: float = 17.4, **physics) -> Path:
    """A case of one record, positions in mm, of which the first `train` seconds train; returns rig.toml."""
    t, x, u = record(seconds, **physics)
    rows = np.column_stack([t, 1e3 * x, u])
    np.savetxt(folder / "run.csv", rows, fmt="%.10g", delimiter=",", header="t,x,u", comments="")
    (folder / "rig.toml").write_text(RIG.replace("17.4", str(train)))
    return folder / "rig.toml"
