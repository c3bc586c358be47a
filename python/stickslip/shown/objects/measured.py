"""Channels, recordings and cases."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import Scale, scales
from stickslip.declared.units import Channel
from stickslip.measured.case import Case
from stickslip.measured.recording import Recording
from stickslip.shown.objects.description import Cell, Description, ShownSamples, describe
from stickslip.shown.plot.curves import DOTS, MEASURED, label

Row = tuple[Cell, ...]


@describe.register
def _channel(one: Channel) -> Description:
    rows: list[Row] = [("column", one.column), ("unit", one.unit), ("scale", one.scale)]
    return Description(title=f"Channel from column '{one.column}'", heads=("what", "as declared"), rows=rows)


@describe.register
def _recording(one: Recording) -> Description:
    t = one.raw["t"]
    rows: list[Row] = [
        (
            name,
            channel.column,
            float(one.raw[name].min()) if len(one) else None,
            float(one.raw[name].max()) if len(one) else None,
            _bare(channel.unit),
            _noise(one, name),
        )
        for name, channel in one.channels.items()
    ]
    samples = ShownSamples(
        {name: one.raw[name] for name in ("t", *(key for key in one.channels if key != "t"))},
        {name: channel.unit for name, channel in one.channels.items()},
    )
    apart = (
        f", {float(np.median(np.diff(t))):.4g} {_bare(one.channels['t'].unit)} apart" if len(one) > 1 else ""
    )
    moved = f"; {told}" if (told := _moved(one, "belt speed ")) else ""
    return Description(
        title=f"Recording '{one.name}' ({one.role}): {len(one)} samples{apart}{moved}",
        heads=("channel", "column", "least", "greatest", "unit", "noise"),
        rows=rows,
        notes=[str(finding) for finding in one.findings],
        samples=samples,
        draw=lambda ax: _over_time(ax, one),
    )


def _moved(one: Recording, named: str = "") -> str:
    """How fast what moves the rig goes; `named` stands before the belt's speed of a named rig."""
    if isinstance(one.rig, GeneralRig):
        return ", ".join(f"{key.replace('_', ' ')} {speed.text}" for key, speed in one.speeds.items())
    return (
        "" if one.drive is not None else f"{named}{scales(one.rig, one.channels)['belt'].of(one.belt_speed)}"
    )


def _span(one: Recording) -> str:
    length = float(one.t[-1] - one.t[0]) if len(one) else 0.0
    unit = Scale(1.0, "s") if isinstance(one.rig, GeneralRig) else scales(one.rig, one.channels)["t"]
    return unit.of(length, 4) if len(one) else "nothing"


def _bare(unit: str) -> str:
    return "" if unit == "1" else unit


def _noise(one: Recording, name: str) -> float | None:
    """Standard deviation in the column's numbers."""
    known = one.noise.get("x1" if name == "spring_force" else name)
    return None if known is None or name == "t" else float(known / abs(one.factors[name]))


def _over_time(ax: Axes, one: Recording) -> None:
    name = next(key for key in ("x1", "spring_force", *one.channels) if key in one.channels and key != "t")
    step = max(1, len(one) // DOTS)
    ax.plot(one.raw["t"][::step], one.raw[name][::step], color=MEASURED, lw=0.8)
    ax.set_xlabel(label("t", one.unit("t")))
    ax.set_ylabel(label(name.replace("_", " "), one.channels[name].unit))


@describe.register
def _case(one: Case) -> Description:
    rows: list[Row] = []
    for run in one.runs:
        rows.append((run.name, run.role, _moved(run), len(run), _span(run), len(run.findings) or None))
    law = one.declared_law
    declared = "no law declared" if law is None else f"{law.kind} friction"
    return Description(
        title=f"Case '{one.title}': {type(one.rig).__name__}, {declared}, {len(one.runs)} runs",
        heads=(
            "run",
            "role",
            "speeds" if isinstance(one.rig, GeneralRig) else "belt speed",
            "samples",
            "over",
            "findings",
        ),
        rows=rows,
        notes=one.findings,
        draw=lambda ax: _over_time(ax, one.runs[0]),
    )
