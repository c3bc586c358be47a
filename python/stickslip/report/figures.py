"""The figures of a report: motion before and after, friction, errors.

Measured is blue, the declared model alone vermilion and dashed, the model with what was found green and solid: Okabe
and Ito's colours, told apart by line style too.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import wraps

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes as Plot
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from stickslip.discovery.readings import reading_velocity
from stickslip.discovery.result import Found, Part, RunView, Verdict
from stickslip.model import Model
from stickslip.plot import DOTS, GREY, LIMIT, MEASURED, SIMULATED, STYLE, label
from stickslip.report.motion import Measured, broken, measured
from stickslip.report.units import Axes
from stickslip.report.words import short

BEFORE, AFTER = SIMULATED, LIMIT
LineStyle = str | tuple[int, tuple[int, int]]
AMBER = "#b07800"
DASH: LineStyle = (0, (4, 2))
MOST_RUNS = 3
MOST_RIVALS = 12
PARTS = ("channel", "mode", "transition", "speed", "time")
TIMES = ("first", "middle", "last")


def styled(draw: Callable[[Found, Axes], Figure]) -> Callable[[Found, Axes], Figure]:
    """Draw in the house style, whatever the caller's settings are, and leave those as they were."""

    @wraps(draw)
    def drawn(found: Found, axes: Axes) -> Figure:
        with mpl.rc_context(STYLE):
            return draw(found, axes)

    return drawn


def sheet(width: float, height: float) -> Figure:
    """An empty figure."""
    return Figure(figsize=(width, height), layout="constrained")


def after_name(found: Found) -> str:
    """What the second model is called in legends."""
    return (
        "declared model"
        if found.verdict is Verdict.no_effect
        else "with " + " + ".join(e.name for e in found.effects)
    )


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
            _portrait(ax, found, run, smooth, which, axes)
            if run is runs[0]:
                ax.set_title(title, fontsize=10, color=BEFORE if which == "before" else AFTER)
            if run is runs[-1]:
                ax.set_xlabel(label("$x_1$ reading", axes.x1.unit))
        row[0].set_ylabel(f"{run.name}\n" + label("its rate $\\dot x_1$", axes.x2.unit))
    handles = {
        name: h for ax in grid.ravel() for h, name in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=4)
    return figure


def _portrait(ax: Plot, found: Found, run: RunView, smooth: Measured | None, which: str, axes: Axes) -> None:
    xs, vs = axes.x1.size, axes.x2.size
    half = run.t[-1] / 2
    if smooth is not None:
        late = smooth.t >= half
        ax.plot(
            xs * smooth.x1[late], vs * smooth.x2[late], color=MEASURED, lw=2.2, alpha=0.4, label="measured"
        )
    state, reading = (
        (run.state_before, run.before["x1"]) if which == "before" else (run.state_after, run.after["x1"])
    )
    rate = reading_velocity(found.before if which == "before" else found.after, state, reading)
    late = run.t >= half
    x, v = broken(run.t[late], state[late], reading[late], rate[late])
    colour, style = (BEFORE, DASH) if which == "before" else (AFTER, "-")
    ax.plot(xs * x, vs * v, color=colour, lw=1.1, ls=style, label="model " + which)
    ax.axhline(vs * run.belt_speed, color=GREY, lw=0.8, ls=(0, (1, 2)), zorder=0, label="belt speed")
    ax.margins(0.06)
    ax.locator_params(nbins=6)


@styled
def friction(found: Found, axes: Axes) -> Figure:
    """T against v_w: from the readings of all runs, and the law before and after; sticks lie on v_w = 0."""
    figure = sheet(7.6, 4.2)
    ax = figure.subplots()
    vs, force = axes.x2.size, axes.force.size
    v, T = _force_points(found)
    if v.size:
        ax.plot(vs * v, force * T, ".", color=MEASURED, ms=2.0, alpha=0.3, mew=0, rasterized=True)
        ax.plot([], [], ".", color=MEASURED, ms=7, mew=0, label="from the readings")
    speeds = np.concatenate([run.speed_after for run in found.runs])
    low, high = float(np.nanmin(speeds)), float(np.nanmax(speeds))
    drawn: list[tuple[Model, str, LineStyle, str]] = [(found.before, BEFORE, DASH, "law identified alone")]
    if found.verdict is not Verdict.no_effect:
        drawn.append((found.after, AFTER, "-", f"law {after_name(found)}"))
    for model, colour, style, name in drawn:
        for side in (np.linspace(low, 0.0, 300)[:-1], np.linspace(0.0, high, 300)[1:]):
            if np.ptp(side) > 0:
                ax.plot(
                    vs * side, force * model.friction.force(side), color=colour, ls=style, lw=1.6, label=name
                )
        minus, plus = model.friction.static_limits
        ax.plot([0, 0], [-force * minus, force * plus], color=colour, ls=style, lw=1.0)
    ax.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    ax.set_xlabel(label("relative velocity $v_w$", axes.x2.unit))
    ax.set_ylabel(label("friction force $T$", axes.force.unit))
    top = 1.25 * force * max(*found.after.friction.static_limits, *found.before.friction.static_limits)
    ax.set_ylim(-top, top)
    reach = 0.06 * (high - low)
    ax.set_xlim(*sorted((vs * (low - reach), vs * (high + reach))))
    handles = dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3)
    return figure


def _force_points(found: Found) -> tuple[np.ndarray, np.ndarray]:
    v, T = [], []
    for run in found.runs:
        one = measured(found.after, run)
        if one is not None:
            v.append(one.v_w[one.sure])
            T.append(one.force[one.sure])
    if not v:
        return np.array([]), np.array([])
    speeds, forces = np.concatenate(v), np.concatenate(T)
    if speeds.size > DOTS:
        kept = np.random.default_rng(0).choice(speeds.size, DOTS, replace=False)
        speeds, forces = speeds[kept], forces[kept]
    return speeds, forces


@styled
def errors(found: Found, axes: Axes) -> Figure:
    """Forecast error before and after with its floor, by validate run, at one and two cycles; logarithmic."""
    del axes
    rows = [
        (f"{run.run}, {cycles}" if np.isfinite(run.two_cycles["before"]) else run.run, one)
        for run in found.error.runs
        for cycles, one in (("one cycle", run.one_cycle), ("two cycles", run.two_cycles))
        if np.isfinite(one["before"])
    ]
    rows.append(
        ("all", {"before": found.error.before, "after": found.error.after, "floor": found.error.floor})
    )
    figure = sheet(7.6, 0.34 * len(rows) + 1.3)
    ax = figure.subplots()
    for y, (_, one) in enumerate(reversed(rows)):
        before, after, floor = (float(one[k]) for k in ("before", "after", "floor"))
        ax.plot([after if found.effects else floor, before], [y, y], color=GREY, lw=1.2, zorder=1)
        ax.plot(
            [floor, floor],
            [y - 0.36, y + 0.36],
            color="black",
            lw=1.4,
            label="floor: the noise alone",
            zorder=2,
        )
        ax.plot([before], [y], "s", color=BEFORE, ms=6, label=before_name(found), zorder=3)
        if found.effects:
            ax.plot([after], [y], "o", color=AFTER, ms=6, label="after", zorder=4)
    ax.set_yticks(range(len(rows)), [name for name, _ in reversed(rows)])
    if any(np.isfinite(one["before"]) for _, one in rows):
        _plain_log(ax)
    whole = any(np.isfinite(run.two_cycles["before"]) for run in found.error.runs)
    what = "forecast error" if whole else "error of single events"
    ax.set_xlabel(f"{what} over the standard deviation of the signal (NRMSE)")
    ax.grid(axis="x", color="#dddddd", lw=0.6)
    ax.set_ylim(-0.6, len(rows) - 0.4)
    handles = dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3)
    return figure


@styled
def parts(found: Found, axes: Axes) -> Figure:
    """Where the residual sits: chi-squared per reading by channel, mode, speed, time, before and after."""
    before = {(p.what, p.name): p for p in found.residual_before.parts}
    after = {(p.what, p.name): p for p in found.residual_after.parts}
    names = sorted(before, key=_place)
    figure = sheet(7.6, 0.27 * len(names) + 1.3)
    ax = figure.subplots()
    for y, name in enumerate(reversed(names)):
        _part(ax, before[name], y, BEFORE, "s", before_name(found))
        if name in after and found.effects:
            _part(ax, after[name], y, AFTER, "o", "after")
    ax.axvline(1.0, color="black", lw=1.2, label="noise alone", zorder=0)
    ax.set_yticks(range(len(names)), [_named(what, name, axes) for what, name in reversed(names)])
    _plain_log(ax)
    ax.set_xlabel("chi-squared per reading on the training runs")
    ax.grid(axis="x", color="#dddddd", lw=0.6)
    handles = dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3)
    return figure


def _named(what: str, name: str, axes: Axes) -> str:
    if what != "speed":
        return f"{what}: {name}"
    unit = "" if axes.x2.unit == "1" else f" {axes.x2.unit}"
    return f"belt speed: {short(axes.x2.size * float(name), 3)}{unit}"


def _place(part: tuple[str, str]) -> tuple[int, float, str]:
    """Where a part stands in the figure: by kind, then by number or in the order of time."""
    what, name = part
    kind = PARTS.index(what) if what in PARTS else len(PARTS)
    with suppress(ValueError):
        return kind, float(name), name
    word = name.split(" ")[0]
    return kind, float(TIMES.index(word)) if word in TIMES else 0.0, name


def _part(ax: Plot, part: Part, y: int, colour: str, marker: str, name: str) -> None:
    if part.chi2 > 0:
        reach = min(2 * part.error, 0.9 * part.chi2)
        ax.errorbar(
            [part.chi2],
            [y],
            xerr=[[reach], [2 * part.error]],
            fmt=marker,
            color=colour,
            ms=5,
            lw=1,
            label=name,
        )


@styled
def ranking(found: Found, axes: Axes) -> Figure:
    """What each rival leaves over on the training runs, in chi-squared per reading; BIC above the best beside it."""
    del axes
    rivals = list(found.ranking[:MOST_RIVALS])
    rivals += [one for one in found.ranking[MOST_RIVALS:] if not one.names]
    figure = sheet(7.6, 0.27 * len(rivals) + 1.2)
    ax = figure.subplots()
    for y, one in enumerate(reversed(rivals)):
        colour = AFTER if one.chosen else AMBER if one.bic < 10 else "#8a8f98"
        ax.plot([1.0, one.chi2], [y, y], color=colour, lw=1.2, alpha=0.6, zorder=1)
        ax.plot([one.chi2], [y], "o", color=colour, ms=7 if one.chosen else 5.5, zorder=2)
        worse = "best" if one.bic <= 0 else f"+{short(float(one.bic), 3)}"
        ax.annotate(
            worse, (1.01, y), xycoords=("axes fraction", "data"), va="center", fontsize=8, color=colour
        )
    ax.axvline(1.0, color="black", lw=1.2, zorder=0)
    ax.annotate(
        "noise alone", (1.0, len(rivals) - 0.45), ha="center", va="bottom", fontsize=8, annotation_clip=False
    )
    ax.set_yticks(
        range(len(rivals)), [" + ".join(one.names) or "declared law alone" for one in reversed(rivals)]
    )
    _plain_log(ax)
    low = min(one.chi2 for one in rivals)
    ax.set_xlim(min(0.9, 0.95 * low), 1.2 * max(2.0, *(one.chi2 for one in rivals)))
    ax.set_ylim(-0.6, len(rivals) - 0.4)
    ax.set_xlabel("chi-squared per reading that is left over; at the right: BIC above the best")
    return figure


def _plain_log(ax: Plot) -> None:
    """A logarithmic x axis with plain numbers."""
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0), numticks=9))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
