"""What every effect does to a motion: drawn beside the same motion without it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import stickslip as ss
from stickslip.declared.catalogue import CONSTANTS, DRIVEN, KINDS
from stickslip.simulated.driven_slider import Loop, closed_loop
from website.law_figures import GREY, ORANGE, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SIZE = (6.4, 3.2)  # inches
SPEED, END, SHOWN = 0.1, 90.0, 45.0


def draw(kind: str, path: Path) -> None:
    """Draw an effect's signature."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    axis = figure.subplots()
    if KINDS[kind].on_belt is None and kind not in CONSTANTS:
        _slider(axis, kind)
    elif kind in CONSTANTS:
        _block(axis, kind)
    else:
        _portrait(axis, kind)
    axis.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    save(figure, path)


def numbers(kind: str) -> Mapping[str, float]:
    """Return the numbers that an effect is drawn with."""
    return KINDS[kind].drawn


def _pair(axis: Axes, before: tuple[Floats, Floats], after: tuple[Floats, Floats]) -> None:
    axis.plot(*before, color=GREY, lw=1.0, label="without")
    axis.plot(*after, color=ORANGE, lw=1.0, label="with")


def _portrait(axis: Axes, kind: str) -> None:
    """The block's phase portrait as its sensor reads it; for the sensor of y1, its reading over that of x1."""
    t = np.linspace(0, END, 9001)
    late = t > END - SHOWN
    (x, y), (x_with, y_with) = read(None, t), read(kind, t)
    _pair(axis, (x[late], y[late]), (x_with[late], y_with[late]))
    reads = KINDS[kind].where.endswith("channel")
    axis.set_xlabel("$x_1$ reading" if reads else "$x_1$")
    axis.set_ylabel(
        "$y_1$ reading" if KINDS[kind].where == "y1 channel" else "its rate" if reads else "$x_2$"
    )


def read(kind: str | None, t: Floats) -> tuple[Floats, Floats]:
    """Return what is drawn of the reference rig with an effect: x1 and its rate, or y1, as they are read.

    The formulas of the sensors are those of the catalogue, written here once more.
    """
    effects = (ss.effect(kind, **numbers(kind)),) if kind else ()
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    model = ss.Model(rig, friction=ss.PaperFriction(), effects=effects)
    run = ss.simulate(model, belt_speed=SPEED, initial=(0.1, 0.1, 0, 0), t_end=END, t_eval=t)
    x, y, p = run.state[:, 0], run.state[:, 2], numbers(kind) if kind else {}
    if kind == "sensor_delay":
        return x, np.interp(t - p["delay"], t, y)
    if kind == "sensor_lag":
        x = run.hidden["m"]
    elif kind == "sensor_crosstalk":
        x = x + p["c"] * y
    elif kind == "sensor_nonlinearity":
        x = x + p["q"] * x**2
    elif kind == "sensor_drift":
        x = x + p["r"] * t
    return x, np.gradient(x, t)


def _block(axis: Axes, kind: str) -> None:
    """A block on a belt: as declared, and as it reads with a constant that is off."""
    runs = []
    law = ss.CoulombFriction(static=1.0, kinetic=0.6)
    for effects in ((), (ss.effect(kind, **numbers(kind)),)):
        run = ss.simulate(
            ss.Model(ss.BlockOnBelt(), friction=law, effects=effects),
            belt_speed=0.2,
            initial=(0, 0.2),
            t_end=40,
        )
        runs.append((run.t, run.state[:, 0]))
    if kind == "sensor_gain":
        runs[1] = (runs[0][0], (1 + numbers(kind)["e"]) * runs[0][1])
    _pair(axis, runs[0], runs[1])
    axis.set_xlabel("$t$")
    axis.set_ylabel("$x_1$ reading" if kind == "sensor_gain" else "$x_1$")


def _slider(axis: Axes, kind: str) -> None:
    """The force balance of a slider in its position loop: drive less inertia, over velocity or position."""
    t = np.arange(0, 10.0, 2e-3)
    settled = t > 2.0  # the loop starts with a jolt
    goal = 0.12 * np.sin(0.8 * t) ** 3 + 0.04 * np.sin(1.9 * t)
    found = []
    law = ss.CoulombFriction(static=20.0, kinetic=20.0)
    mass = 95.0
    for effects in ((), (ss.effect(kind, **numbers(kind)),)):
        model = ss.Model(ss.DrivenSlider(mass=mass, damping=200.0), friction=law, effects=effects)
        run = closed_loop(model, Loop(gain=35.0, kp=20.0, kv=120.0), t, goal)
        force = 35.0 * run.command - mass * run.acceleration
        across = run.x if over_position(kind) else run.velocity
        found.append((1e3 * across[settled], force[settled]))
    _pair(axis, found[0], found[1])
    axis.set_xlabel("$x_1$ [mm]" if over_position(kind) else "$x_2$ [mm/s]")
    axis.set_ylabel("drive less inertia [N]")


def over_position(kind: str) -> bool:
    """Say whether an effect of a driven slider is drawn over the position."""
    return "x1" in DRIVEN[kind].depends_on
