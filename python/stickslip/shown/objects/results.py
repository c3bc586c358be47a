"""What was fitted, compared and found."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.declared.scale import law_scale, scales
from stickslip.declared.si import si_of
from stickslip.discovery.driven_slider.result import DrivenFound
from stickslip.discovery.result import Found, RunView
from stickslip.fitted.compare import Comparison, per_model, speed_unit
from stickslip.fitted.identified import Identified
from stickslip.likelihoods.interval import Interval
from stickslip.shown.driven_slider.figures import friction
from stickslip.shown.objects.declared import characteristic
from stickslip.shown.objects.description import Cell, Description, Span, describe
from stickslip.shown.plot.curves import MEASURED, SIMULATED, friction_characteristic, label, phase_portrait
from stickslip.shown.report import figures
from stickslip.shown.report.units import Axes as Units
from stickslip.shown.report.units import Axis, axes_of
from stickslip.shown.report.words import headline

Row = tuple[Cell, ...]
BARE = Axis(1.0, "1")


@describe.register
def _identified(one: Identified) -> Description:
    rows: list[Row] = []
    for name, estimate in one.estimates.items():
        scale = law_scale(name, one.rig, one.channels)
        low, high = (None if x is None else x * scale.size for x in (estimate.low, estimate.high))
        unit = "" if scale.unit == "1" else scale.unit
        rows.append((name, estimate.value * scale.size, Span(low, high), unit, estimate.status))
    known = scales(one.rig, one.channels)
    units = {
        "v_w": (known["x2"].size, _bare(known["x2"].unit)),
        "T": (known["force"].size, _bare(known["force"].unit)),
    }
    return Description(
        title=f"Identified {one.law.kind} law; chi-squared per degree of freedom {one.reduced_chi2:.3g}",
        heads=("number", "value", "95 % interval", "unit", "status"),
        rows=rows,
        notes=one.messages,
        draw=characteristic(
            one.law, units, max((span[1] for span in one.covered.values() if span), default=None)
        ),
        large=lambda: friction_characteristic(one),
    )


def _bare(unit: str) -> str:
    return "" if unit == "1" else unit


@describe.register
def _comparison(one: Comparison) -> Description:
    rows: list[Row] = [
        (r.quantity, r.measured, r.simulated, r.difference, r.scatter, _bare(r.unit)) for r in one.rows
    ]

    x, v = per_model(one.recording, "x1"), speed_unit(one.recording)[1]

    def draw(ax: Axes) -> None:
        for track, colour, name in (
            (one.measured, MEASURED, "measured"),
            (one.simulated, SIMULATED, "simulated"),
        ):
            half = len(track.t) // 2
            ax.plot(x * track.x[half:], v * track.v[half:], color=colour, lw=0.8, label=name)
        ax.legend()
        ax.set_xlabel(label("$x_1$", one.units[1]))
        ax.set_ylabel(label("$x_2$", one.units[2]))

    return Description(
        title=f"Comparison with '{one.recording.name}'",
        heads=("quantity", "measured", "simulated", "difference", "scatter", "unit"),
        rows=rows,
        notes=one.verdict(),
        draw=draw,
        large=lambda: phase_portrait(one),
    )


@describe.register
def _found(one: Found) -> Description:
    after = one.after
    rows: list[Row] = []
    for effect in one.effects:
        for name, value in effect.parameters.items():
            rows.append(_number(one, f"{effect.name}.{name}", value, "effect"))
        if effect.curve is not None:
            rows.append((effect.name, effect.curve.guess or "a curve", None, "", "effect"))
    rows += [_number(one, name, value, f"{after.friction.kind} law") for name, value in one.law.items()]
    rows += [
        (f"scatter of {name}", x.value, Span(x.low, x.high), "", "scatter") for name, x in one.scatter.items()
    ]
    error = one.error
    rows += [
        (f"error {name}", getattr(error, name), None, "", "validate") for name in ("before", "after", "floor")
    ]
    return Description(
        title=headline(one),
        heads=("number", "value", "95 % interval", "unit", "of"),
        rows=rows,
        notes=[f"Error: {error.metric}.", *one.messages],
        draw=_drawn(one),
        large=lambda: _large(one),
    )


def _number(found: Found, name: str, one: Interval, of: str) -> Row:
    known = si_of(name, found.after.rig, found.after.channels)
    if known is None:
        return name, one.value, Span(one.low, one.high), "", of
    low, high = (None if x is None else known.of(x) for x in (one.low, one.high))
    return name, known.of(one.value), Span(low, high), known.unit, of


def _drawn(found: Found) -> Callable[[Axes], None]:
    """What draws the portrait: a run as measured and as the model has it, or the law where there is no run."""
    runs = figures.shown_runs(found)
    return partial(_run, found, runs[0]) if runs else characteristic(found.after.friction)


def _run(found: Found, run: RunView, ax: Axes) -> None:
    known = scales(found.after.rig, found.after.channels)
    t, x = known["t"], known["x1"]
    part = slice(0, max(2, len(run.t) // 3))
    for values, colour, width, name in (
        (run.measured["x1"], MEASURED, 2.0, "measured"),
        (run.after["x1"], SIMULATED, 0.9, "model after"),
    ):
        times = t.size * (run.t[part] - run.t[0])
        ax.plot(times, x.size * np.asarray(values)[part], color=colour, lw=width, alpha=0.8, label=name)
    ax.legend()
    ax.set_xlabel(label("$t$", t.unit))
    ax.set_ylabel(label("$x_1$", x.unit))


def _large(found: Found) -> Figure:
    if isinstance(found, DrivenFound):
        return friction(found)
    if found.case is None:
        return figures.portrait(found, Units(BARE, BARE, BARE, BARE, BARE, BARE, si=False))
    return figures.portrait(found, axes_of(found.case))
