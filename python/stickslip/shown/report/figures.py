"""The figure of a report that shows motion, and what all of them share: colours, names, an empty sheet.

Measured is blue, the declared model alone vermilion and dashed, the model with what was found green and solid: Okabe
and Ito's colours, told apart by line style too.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps

import matplotlib as mpl
from matplotlib.axes import Axes as Plot
from matplotlib.figure import Figure

from stickslip.discovery.result import Found, FoundEffect, RunView, Verdict
from stickslip.shown.plot.curves import GREY, LIMIT, MEASURED, SIMULATED, STYLE, label
from stickslip.shown.plot.drawing import Drawing
from stickslip.shown.report.motion import MeasuredMotion, broken, measured
from stickslip.shown.report.units import Axes
from stickslip.shown.report.words import guessed, joined

BEFORE, AFTER = SIMULATED, LIMIT
LineStyle = str | tuple[int, tuple[int, int]]
DASH: LineStyle = (0, (4, 2))
MOST_RUNS = 3


def styled(draw: Callable[[Found, Axes], Figure]) -> Callable[[Found, Axes], Figure]:
    """Draw in the house style, whatever the caller's settings are, and leave those as they were."""

    @wraps(draw)
    def drawn(found: Found, axes: Axes) -> Figure:
        with mpl.rc_context(STYLE):
            return draw(found, axes)

    return drawn


def sheet(width: float, height: float) -> Figure:
    """An empty figure."""
    return Drawing(figsize=(width, height), layout="constrained")


def after_name(found: Found) -> str:
    """What the second model is called in legends."""
    if found.verdict is Verdict.no_effect:
        return "declared model"
    return "with " + " + ".join(_called(found, effect) for effect in found.effects)


def _called(found: Found, effect: FoundEffect) -> str:
    """What of an effect is in the model after: one without a name is not called unlisted where there is more to say."""
    if effect.of_rig:
        return f"{joined(list(effect.parameters))} mended"
    if guessed(effect):
        return " + ".join(one.name for one in found.after.effects) or "nothing added"
    return "a learned curve" if effect.name == "unlisted" else effect.name


def before_name(found: Found) -> str:
    """What the declared model is called where it has a rival, and where it has none."""
    return "before" if found.effects else "declared model"


def shown_runs(found: Found) -> list[RunView]:
    """The runs that figures of motion show: those of the validation."""
    runs = [run for run in found.runs if run.role == "validate"] or list(found.runs)
    return runs[:MOST_RUNS]


@styled
def portrait(found: Found, axes: Axes) -> Figure:
    """Phase trajectory of the readings with the model's over it, before and after (Fig. 4 twice), a row a run."""
    runs = shown_runs(found)
    nothing = found.verdict is Verdict.no_effect
    columns = (
        (("declared model alone", "before"),)
        if nothing
        else (("declared model alone", "before"), (after_name(found), "after"))
    )
    figure = sheet(4.6 * len(columns) + 0.2, 3.5 * len(runs) + 0.5)
    grid = figure.subplots(len(runs), len(columns), squeeze=False, sharex="row", sharey="row")
    for row, run in zip(grid, runs, strict=True):
        smooth = measured(found.after, run)
        for ax, (title, which) in zip(row, columns, strict=True):
            _portrait(ax, run, smooth, which, axes)
            if run is runs[0]:
                colour = BEFORE if which == "before" else AFTER
                ax.set_title(f"{title}\n", fontsize=10, color=colour)  # above the line that names the run
            if run is runs[-1]:
                ax.set_xlabel(
                    label(f"reading of {'$x_1$' if axes.sensed == 'x1' else axes.sensed}", axes.x1.unit)
                )
        row[0].set_ylabel(label("rate of the reading, $\\dot x_1$", axes.x2.unit))
        row[0].set_title(run.name, loc="left", fontsize=9, color=GREY)
    handles = {
        name: h for ax in grid.ravel() for h, name in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=4)
    return figure


def _portrait(ax: Plot, run: RunView, smooth: MeasuredMotion | None, which: str, axes: Axes) -> None:
    xs, vs = axes.x1.size, axes.x2.size
    half = run.t[-1] / 2
    if smooth is not None:
        late = smooth.t >= half
        ax.plot(
            xs * smooth.x1[late], vs * smooth.x2[late], color=MEASURED, lw=2.2, alpha=0.4, label="measured"
        )
    state, reading, rate = (
        (run.state_before, run.before["x1"], run.rate_before)
        if which == "before"
        else (run.state_after, run.after["x1"], run.rate_after)
    )
    late = run.t >= half
    x, v = broken(run.t[late], state[late], reading[late], rate[late])
    colour, style = (BEFORE, DASH) if which == "before" else (AFTER, "-")
    ax.plot(xs * x, vs * v, color=colour, lw=1.1, ls=style, label="model " + which)
    ax.axhline(vs * run.belt_speed, color=GREY, lw=0.8, ls=(0, (1, 2)), zorder=0, label="belt speed")
    ax.margins(0.06)
    ax.locator_params(nbins=6)
