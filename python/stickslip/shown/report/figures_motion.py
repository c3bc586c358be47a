"""The figure of a report that lays the models over the readings in time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes as Plot
from matplotlib.figure import Figure

from stickslip.discovery.result import Found, RunView
from stickslip.shown.plot.curves import DOTS, MEASURED, label
from stickslip.shown.report.figures import (
    AFTER,
    BEFORE,
    DASH,
    after_name,
    before_name,
    sheet,
    shown_runs,
    styled,
)
from stickslip.shown.report.motion import Floats, broken
from stickslip.shown.report.units import Axes

CHANNELS = ("x1", "y1")
CYCLES = 5  # of the run's end that are shown first; a share of the run where it has none
SHARE = 0.2


@styled
def motion(found: Found, axes: Axes) -> Figure:
    """Readings over time and both models' forecasts of them, a panel a channel of each run that was not fitted."""
    panels = [(run, channel) for run in shown_runs(found) for channel in CHANNELS if channel in run.measured]
    figure = sheet(7.6, 1.9 * len(panels) + 0.4)
    grid = figure.subplots(len(panels), 1, squeeze=False).ravel()
    first: dict[str, Plot] = {}
    for ax, (run, channel) in zip(grid, panels, strict=True):
        _panel(ax, found, run, channel, axes)
        if run.name in first:
            ax.sharex(first[run.name])
        else:
            ax.set_title(run.name, loc="left", fontsize=9)
            ax.set_xlim(*(axes.t.size * t for t in _shown(run)))
        first.setdefault(run.name, ax)
    handles = dict(zip(*grid[0].get_legend_handles_labels()[::-1], strict=True))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3)
    return figure


def _panel(ax: Plot, found: Found, run: RunView, channel: str, axes: Axes) -> None:
    size = (axes.x1 if channel == "x1" else axes.y1).size
    every = max(1, len(run.t) // DOTS)
    t = run.t[::every]
    ax.plot(
        axes.t.size * t,
        size * run.measured[channel][::every],
        color=MEASURED,
        lw=2.4,
        alpha=0.45,
        label="measured",
    )
    if channel in run.low:
        low, high = (size * side[channel][::every] for side in (run.low, run.high))
        name = "95 % of readings"
        ax.fill_between(axes.t.size * t, low, high, color=AFTER, alpha=0.18, lw=0, label=name)
    models = [(run.before, run.state_before, BEFORE, DASH, before_name(found))]
    if found.effects:
        models.append((run.after, run.state_after, AFTER, "-", after_name(found)))
    for reading, state, colour, style, name in models:
        time, x = broken(run.t, state, run.t, reading[channel])
        keep = slice(None, None, every)
        ax.plot(axes.t.size * time[keep], size * x[keep], color=colour, ls=style, lw=1.1, label=name)
    ax.set_xlabel(label("time", axes.t.unit))
    name, axis = (axes.sensed, axes.x1) if channel == "x1" else (channel, axes.y1)
    ax.set_ylabel(label(name, axis.unit))
    ax.locator_params(nbins=6)


def _shown(run: RunView) -> tuple[float, float]:
    """The last few cycles of a run: from onset of slip to onset of slip."""
    onsets: Floats = run.t[1:][(run.mode_after[1:] != 0) & (run.mode_after[:-1] == 0)]
    end = float(run.t[-1])
    if onsets.size > CYCLES:
        period = float(np.median(np.diff(onsets)))
        return max(float(run.t[0]), end - CYCLES * period), end
    return end - SHARE * (end - float(run.t[0])), end
