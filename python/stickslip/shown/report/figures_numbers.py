"""The figures of a report that show numbers side by side: errors, parts of the residual, rivals."""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
from matplotlib.axes import Axes as Plot
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

from stickslip.discovery.laboratory.block_errors import METRIC
from stickslip.discovery.result import Found, Part
from stickslip.shown.plot.curves import GREY
from stickslip.shown.report.figures import AFTER, BEFORE, before_name, sheet, styled
from stickslip.shown.report.units import Axes
from stickslip.shown.report.words import short

MOST_RIVALS = 12
TIED = 10.0  # in BIC: nearer to the best than this, evidence alone rules nothing out
AMBER, PALE = "#b07800", "#8a8f98"
PARTS = ("channel", "mode", "transition", "speed", "time")
TIMES = ("first", "middle", "last")
STEPS = [1, 2, 2.5, 5, 10]
WIDE = 5.0  # of the largest number over the smallest: beyond it an axis is logarithmic


def single_events(found: Found) -> bool:
    """Whether events were taken one by one, each with friction of its own, and not whole runs."""
    return found.error.metric == METRIC


@styled
def errors(found: Found, axes: Axes) -> Figure:
    """Forecast error before and after with its floor, by validate run, at one and two cycles; from 0 on."""
    del axes
    rows = [
        (f"{run.run}, {cycles}" if np.isfinite(run.two_cycles["before"]) else run.run, one)
        for run in found.error.runs
        for cycles, one in (("one cycle", run.one_cycle), ("two cycles", run.two_cycles))
        if np.isfinite(one["before"])
    ]
    rows.append(
        (_mean(found), {"before": found.error.before, "after": found.error.after, "floor": found.error.floor})
    )
    figure = sheet(7.6, 0.34 * len(rows) + 1.3)
    ax = figure.subplots()
    for y, (_, one) in enumerate(reversed(rows)):
        _error(ax, found, y, *(float(one[k]) for k in ("before", "after", "floor")))
    ax.set_yticks(range(len(rows)), [name for name, _ in reversed(rows)])
    shown = [float(one[k]) for _, one in rows for k in ("before", "after", "floor") if np.isfinite(one[k])]
    if shown:
        ax.set_xlim(0.0, 1.08 * max(shown))
    ax.xaxis.set_major_locator(MaxNLocator(7, steps=STEPS))
    what = "error of single events" if single_events(found) else "forecast error"
    ax.set_xlabel(f"{what} over the standard deviation of the signal (NRMSE)")
    ax.grid(axis="x", color="#dddddd", lw=0.6)
    ax.set_ylim(-0.6, len(rows) - 0.4)
    handles = dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3)
    return figure


def _mean(found: Found) -> str:
    """What the last row is: the error of report.json."""
    return "mean" if single_events(found) else "mean, one cycle"


def _error(ax: Plot, found: Found, y: int, before: float, after: float, floor: float) -> None:
    """One row: floor, before and after, joined by a line."""
    ax.plot([after if found.effects else floor, before], [y, y], color=GREY, lw=1.2, zorder=1)
    bar = [y - 0.36, y + 0.36]
    name = "floor: what noise alone leaves, estimated"
    ax.plot([floor, floor], bar, color="black", lw=1.4, label=name, zorder=2)
    ax.plot([before], [y], "s", color=BEFORE, ms=6, label=before_name(found), zorder=3)
    if found.effects:
        ax.plot([after], [y], "o", color=AFTER, ms=6, label="after", zorder=4)


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
    ax.set_ylim(-0.6, len(names) - 0.4)
    shown = [*before.values(), *(after.values() if found.effects else ())]
    _scaled(ax, 1.0, *(end for part in shown if part.chi2 > 0 for end in _reach(part)))
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


def _reach(part: Part) -> tuple[float, float]:
    """Two standard errors about a part's chi-squared, the lower end above 0."""
    return max(part.chi2 - 2 * part.error, 0.1 * part.chi2), part.chi2 + 2 * part.error


def _part(ax: Plot, part: Part, y: int, colour: str, marker: str, name: str) -> None:
    if part.chi2 > 0:
        low, high = _reach(part)
        ax.errorbar(
            [part.chi2],
            [y],
            xerr=[[part.chi2 - low], [high - part.chi2]],
            fmt=marker,
            color=colour,
            ms=5,
            lw=1,
            label=name,
        )


@styled
def ranking(found: Found, axes: Axes) -> Figure:
    """
    How far each rival's evidence lies behind the best.

    Where events were taken one by one: what each leaves over of the numbers that tell events apart (levels of
    friction), against the noise and against how such numbers differ anyway.
    """
    del axes
    rivals = list(found.ranking[:MOST_RIVALS])
    rivals += [one for one in found.ranking[MOST_RIVALS:] if not one.names]
    names = [" + ".join(one.names) or "declared law alone" for one in rivals]
    figure = sheet(5.4 + 0.075 * max(len(name) for name in names), 0.27 * len(rivals) + 1.6)
    ax, single = figure.subplots(), single_events(found)
    for y, one in enumerate(reversed(rivals)):
        colour = AFTER if one.chosen else AMBER if one.bic < TIED else PALE
        at = one.chi2 if single else max(one.bic, 1.0)  # an axis by powers of ten
        ax.plot([1.0, at], [y, y], color=colour, lw=1.2, alpha=0.6, zorder=1)
        ax.plot([at], [y], "o", color=colour, ms=7 if one.chosen else 5.5, zorder=2)
        _beside(ax, y, "0" if one.bic <= 0 else f"+{short(float(one.bic), 3)}", colour)
    _beside(ax, len(rivals) - 0.1, "BIC above\nthe lowest" if single else "above the\nlowest", "black")
    ax.set_yticks(range(len(rivals)), names[::-1])
    if single:
        ax.axvline(1.0, color="black", lw=1.2, zorder=0)
        _scaled(ax, *(one.chi2 for one in rivals), 1.0)
        ax.set_xlabel("chi-squared left over, per number of the events")
    else:
        _scaled(ax, *(max(one.bic, 1.0) for one in rivals), 1.0)
        ax.set_xlabel("-2 log evidence above the lowest, from 1 on")
    ax.set_ylim(-0.6, len(rivals) - 0.4)
    figure.legend(
        handles=_key(found, single),
        title=None if found.effects else _kept(found),
        loc="outside upper center",
        ncols=4,
    )
    return figure


def _beside(ax: Plot, y: float, text: str, colour: str) -> None:
    """Write at the right of a row."""
    ax.annotate(text, (1.01, y), xycoords=("axes fraction", "data"), va="center", fontsize=8, color=colour)


def _key(found: Found, single: bool) -> list[Line2D]:
    """What the colours of the ranking mean: of those that it shows."""
    shown = found.ranking[:MOST_RIVALS]
    known = (
        (AFTER, "chosen" if found.effects else "kept", True),
        (AMBER, f"within {TIED:.0f} of the lowest", any(r.bic < TIED and not r.chosen for r in shown)),
        (PALE, "others", any(r.bic >= TIED and not r.chosen for r in shown)),
    )
    dots = [
        Line2D([], [], color=colour, marker="o", ms=6, lw=0, label=name)
        for colour, name, here in known
        if here
    ]
    line = Line2D([], [], color="black", lw=1.2, label="what events differ by anyway")
    return [line, *dots] if single else dots


def _kept(found: Found) -> str:
    """Why the declared law stands although another may lie lower."""
    if math.isinf(found.gate.threshold):
        return "Nothing is named: no effect was tried."
    what = "chi-squared" if single_events(found) else "-2 log evidence"
    return (
        f"Nothing is named: the best candidate lowers {what} by {short(found.gate.observed, 3)}, "
        f"{short(found.gate.threshold, 3)} is asked for."
    )


def _scaled(ax: Plot, *values: float) -> None:
    """A readable x axis around positive values: logarithmic with plain numbers where they differ widely."""
    low, high = min(values), max(values)
    if high > WIDE * low:
        ax.set_xscale("log")
        subs = (1.0, 2.0, 5.0) if high < 300 * low else (1.0,)
        ax.xaxis.set_major_locator(LogLocator(subs=subs, numticks=12))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
        if len(subs) > 1:
            ax.xaxis.set_minor_locator(NullLocator())
        ax.set_xlim(low / (high / low) ** 0.06, high * (high / low) ** 0.06)
        return
    ax.xaxis.set_major_locator(MaxNLocator(7, steps=STEPS))
    reach = 0.06 * (high - low) or 0.1 * high
    ax.set_xlim(low - reach, high + reach)
