"""Simulated runs and their transitions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import Quantity, Scale, scales
from stickslip.declared.speeds import Speed
from stickslip.shown.objects.description import Cell, Description, ShownSamples, describe
from stickslip.shown.plot import bodies, curves
from stickslip.shown.plot.between import between, own_steps
from stickslip.shown.plot.curves import DOTS, GREY, SIMULATED, label
from stickslip.simulated.trajectory import MODE_NAMES, Modes, Trajectory, Transitions

Row = tuple[Cell, ...]
OWN = Scale(1.0, "")


def named_scales(model: Model) -> dict[Quantity, Scale]:
    """How the quantities of a named rig are read: in SI, too, where a block was declared with units."""
    rig = model.rig
    if isinstance(rig, BlockOnBelt) and rig.declared_units and not model.channels:
        si: dict[Quantity, str] = {"t": "s", "x1": "m", "x2": "m/s", "belt": "m/s", "force": "N"}
        return {name: Scale(1.0, unit) for name, unit in si.items()}
    return scales(rig, model.channels)


def read_in(model: Model | None, names: tuple[str, ...]) -> dict[str, Scale]:
    """How t and every state of a model's run are read by a person: in the readings' units, in SI, or as they are."""
    if model is None:
        return dict.fromkeys(("t", *names), OWN)
    if isinstance(model.rig, GeneralRig):
        own = model.rig.equations
        units = {"t": "s", **dict(zip(own.names, own.units, strict=True))}
        units |= {f"v_{name}": "1" if units[name] == "1" else f"{units[name]}/s" for name in own.names}
        return {name: Scale(1.0, units.get(name, "")) for name in ("t", *names)}
    known: Mapping[str, Scale] = {str(name): one for name, one in named_scales(model).items()}
    return {name: known.get(name, OWN) for name in ("t", *names)}


def _units(model: Model | None, names: tuple[str, ...]) -> dict[str, str]:
    """Units of the samples themselves; those of a model in its own numbers are "1"."""
    if model is None:
        return {}
    if isinstance(model.rig, Rig):
        return dict.fromkeys(("t", *names), "1")
    read = read_in(model, names)
    return {name: one.unit if one.size == 1 and one.unit != "1" else "" for name, one in read.items()}


@describe.register
def _trajectory(one: Trajectory) -> Description:
    read = read_in(one.model, one.state_names)
    rows: list[Row] = []
    for k, name in enumerate(one.state_names if len(one.t) else ()):
        ends = [float(read[name].size * x) for x in (one.state[:, k].min(), one.state[:, k].max())]
        rows.append((name, *ends, _bare(read[name].unit)))
    names = {name: one.hidden[name] for name in one.hidden_names}
    states = dict(zip(one.state_names, one.state.T, strict=True))
    t = read["t"]
    span = f", t = {t.of(one.t[0])} to {t.of(one.t[-1])}" if len(one.t) else ""
    return Description(
        title=f"Trajectory: {len(one.t)} samples{span}; {len(one.transitions)} transitions; {one.status}",
        heads=("state", "least", "greatest", "unit"),
        rows=rows,
        notes=[] if one.status.ok else [str(one.status)],
        samples=ShownSamples(
            {"t": one.t, **states, **one.modes, **names}, _units(one.model, one.state_names)
        ),
        draw=lambda ax: _portrait(ax, one),
        large=lambda: _large(one),
    )


def _bare(unit: str) -> str:
    return "" if unit == "1" else unit


def _portrait(ax: Axes, one: Trajectory) -> None:
    """Velocity of the first coordinate over it, the second half of the run stronger."""
    place = one.state_names[0]
    velocity = next((name for name in ("x2", f"v_{place}") if name in one.state_names), one.state_names[-1])
    read = read_in(one.model, one.state_names)
    x, v = (read[name].size * one.state[:, one.state_names.index(name)] for name in (place, velocity))
    if own_steps(one):
        rate = read[place].size / read[velocity].size  # of what is drawn, over the model's
        _, q, w = between(one.t, x[:, None], rate * v[:, None])
        x, v = q[:, 0], w[:, 0] / rate
    step, half = max(1, len(x) // DOTS), len(x) // 2
    ax.plot(x[: half + 1 : step], v[: half + 1 : step], color=GREY, lw=0.5)
    ax.plot(x[half::step], v[half::step], color=SIMULATED, lw=0.9)
    ax.set_xlabel(label(place, read[place].unit))
    ax.set_ylabel(label(velocity, read[velocity].unit))


def _large(one: Trajectory) -> Figure:
    if one.model is not None and isinstance(one.model.rig, GeneralRig):
        return bodies.coordinates(one, one.model.rig)
    units = None if one.model is None else named_scales(one.model)
    speed = one.belt_speed.constant if isinstance(one.belt_speed, Speed) else one.belt_speed
    return curves.trajectory(one, one.state_names, belt_speed=speed, units=units)


@describe.register
def _transitions(one: Transitions) -> Description:
    def named(modes: Modes) -> str:
        return " | ".join(MODE_NAMES[int(mode)] for mode in np.atleast_1d(modes))

    rows: list[Row] = [
        (float(t), named(before), named(after))
        for t, before, after in zip(one.t, one.before, one.after, strict=True)
    ]

    def draw(ax: Axes) -> None:
        ax.plot(one.t[1:], np.diff(one.t), ".", color=SIMULATED, ms=3)
        ax.set_xlabel("t")
        ax.set_ylabel("since the one before")

    return Description(
        title=f"{len(one)} transitions",
        heads=("t", "before", "after"),
        rows=rows,
        draw=draw if len(one) > 1 else None,
    )
