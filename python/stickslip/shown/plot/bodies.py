"""Figures of a rig of bodies or matrices: coordinates and velocities over time, sticks shaded; identified laws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.declared.bodies_model import law_of
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import Scale
from stickslip.fitted.bodies_data import smoothed
from stickslip.fitted.bodies_sensors import may_jump
from stickslip.likelihoods.bodies_compare import RigComparison
from stickslip.likelihoods.identified_rig import IdentifiedRig
from stickslip.measured.intervals import intervals
from stickslip.shown.plot.between import between, own_steps
from stickslip.simulated.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 8.0, 1.8  # inches, of the figure and of a row of it


def coordinates(run: Trajectory, rig: GeneralRig) -> Figure:
    """Draw the coordinates (left) and velocities (right) of a run, a row each; grey where a contact of it sticks."""
    from stickslip.shown.plot.drawing import Drawing

    own = rig.equations
    n = len(own.names)
    figure = Drawing(figsize=(WIDTH, HEIGHT * n + 0.6), layout="constrained")
    axes = figure.subplots(n, 2, sharex=True, squeeze=False)
    q, v = run.state[:, :n], run.state[:, n : 2 * n]
    t, *drawn = between(run.t, q, v) if own_steps(run) else (run.t, q, v)
    for i, (name, unit) in enumerate(zip(own.names, own.units, strict=True)):
        for k, (label, scale) in enumerate(
            ((name, unit), (f"v_{name}", "1" if unit == "1" else f"{unit}/s"))
        ):
            axis = axes[i, k]
            axis.plot(t, drawn[k][:, i], lw=0.9)
            axis.set_ylabel(Scale(1.0, scale).head(label))
            for j, contact in enumerate(own.contacts):
                if contact.direction[i]:
                    _shade(axis, run.t, run.mode[:, j] == 0)
    for axis in axes[-1]:
        axis.set_xlabel("t" if set(own.units) == {"1"} else "t [s]")
    return figure


def laws(found: IdentifiedRig) -> Figure:
    """Draw the laws at every contact, as identified and as declared, over the slip speeds that the runs show."""
    from stickslip.shown.plot.drawing import Drawing

    rig = found.model.rig
    assert isinstance(rig, GeneralRig)
    contacts = rig.equations.contacts
    figure = Drawing(figsize=(4.6 * len(contacts), 3.6), layout="constrained")
    axes = figure.subplots(1, len(contacts), squeeze=False)[0]
    for axis, one in zip(axes, contacts, strict=True):
        most = found.fastest[one.name]
        for side in (-1.0, 1.0):
            v = side * np.linspace(1e-3 * most, most, 200)
            for model, look, name in (
                (found.declared, {"color": "0.6", "ls": "--"}, "declared"),
                (found.model, {"color": "C0"}, "identified"),
            ):
                force = side * law_of(model.friction, one).magnitude(v)
                axis.plot(v, force, lw=1.4, label=name if side > 0 else None, **look)
        axis.set_title(one.name)
        axis.set_xlabel(Scale(1.0, "rad/s" if one.rotation else "m/s").head("v"))
        axis.set_ylabel(Scale(1.0, "N m" if one.rotation else "N").head("T"))
    axes[0].legend()
    return figure


def beside(c: RigComparison) -> Figure:
    """Draw a free run of the model over the readings, channel by channel."""
    from stickslip.shown.plot.drawing import Drawing

    general = isinstance(c.model.rig, GeneralRig)
    how = "friction of the mean event" if general else "each piece from the readings before it"
    figure = Drawing(figsize=(WIDTH, HEIGHT * len(c.channels) + 0.6), layout="constrained")
    axes = figure.subplots(len(c.channels), 1, sharex=True, squeeze=False)[:, 0]
    for axis, name, read, made in zip(axes, c.channels, c.readings.T, c.simulated.T, strict=True):
        axis.plot(c.t, read, color="0.6", lw=1.8, label="measured")
        axis.plot(c.t, made, color="C3", lw=0.9, label=f"simulated, {how}")
        axis.set_ylabel(Scale(1.0, _unit(c, name)).head(name))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    axes[-1].set_xlabel("t [s]")
    return figure


def portraits(c: RigComparison) -> Figure:
    """Draw every recorded coordinate's rate over it, its mean motion taken away; what jumps is left out."""
    from stickslip.shown.plot.drawing import Drawing

    each = list(zip(c.channels, c.readings.T, c.simulated.T, strict=True))
    shown = [one for one in each if not _may_jump(c, one[0])] or each
    figure = Drawing(figsize=(4.2 * len(shown), 3.8), layout="constrained")
    axes = figure.subplots(1, len(shown), squeeze=False)[0]
    for axis, (name, read, made) in zip(axes, shown, strict=True):
        for values, begins, look in (
            (read, (0,), {"color": "0.6", "lw": 1.8}),
            (made, c.begins, {"color": "C3", "lw": 0.9}),
        ):
            trend = np.polyval(np.polyfit(c.t, values, 1), c.t)
            for a, b in zip(begins, (*begins[1:], len(c.t)), strict=True):
                x, v, _ = smoothed(c.t[a:b] - c.t[a], values[a:b], 0.0, 0.0)
                axis.plot(x - trend[a:b], v, **look)
        unit = _unit(c, name)
        axis.set_xlabel(Scale(1.0, unit).head(f"{name} less its trend"))
        axis.set_ylabel(Scale(1.0, "1" if unit == "1" else f"{unit}/s").head("rate"))
    return figure


def _may_jump(c: RigComparison, name: str) -> bool:
    rig = c.model.rig
    return isinstance(rig, GeneralRig) and may_jump(rig.equations, _quantity(c, name))


def _unit(c: RigComparison, name: str) -> str:
    rig = c.model.rig
    if not isinstance(rig, GeneralRig):  # a driven slider
        return "1" if c.recording.channels[name].unit == "1" else "m"
    return rig.channel_units[_quantity(c, name)]


def _quantity(c: RigComparison, name: str) -> str:
    """What a channel reads."""
    return c.recording.channels[name].reads or name


def _shade(axis: object, t: np.ndarray, stuck: np.ndarray) -> None:
    for first, last in intervals(stuck):
        axis.axvspan(t[first], t[min(last + 1, len(t) - 1)], color="0.9", lw=0)  # type: ignore[attr-defined]
