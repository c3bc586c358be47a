"""The figure of a report that shows friction: the points that the readings imply, and the laws before and after."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes as Plot
from matplotlib.figure import Figure

from stickslip.declared.model import Model
from stickslip.discovery.result import Found, Verdict
from stickslip.shown.plot.curves import DOTS, GREY, MEASURED, label
from stickslip.shown.report.figures import AFTER, BEFORE, DASH, LineStyle, after_name, sheet, styled
from stickslip.shown.report.motion import Floats, measured
from stickslip.shown.report.units import Axes
from stickslip.shown.report.words import joined

OUTLIERS = 0.2  # per cent of the points on either side that set no limit of the figure
FEW = 3  # samples of slip one way that a forecast may have by mistake
ON_BLOCK = ("block", "both")


@styled
def friction(found: Found, axes: Axes) -> Figure:
    """T against v_w: from the readings of all runs, and the law before and after; sticks lie on v_w = 0.

    Laws are drawn where the block slips, and what is drawn sets the limits.
    """
    figure = sheet(7.6, 4.2)
    ax = figure.subplots()
    vs, force = axes.x2.size, axes.force.size
    v, T = _force_points(found)
    if v.size:
        ax.plot(vs * v, force * T, ".", color=MEASURED, ms=2.0, alpha=0.3, mew=0, rasterized=True)
        inside = contained(found)
        name = "from the readings" + (f", with the force of {joined(inside)}" if inside else "")
        ax.plot([], [], ".", color=MEASURED, ms=7, mew=0, label=name)
    speeds = v if v.size else np.concatenate([run.speed_after for run in found.runs])
    low, high = (bound(0.0, end) for bound, end in zip((min, max), _reach(speeds), strict=True))
    drawn: list[tuple[Model, str, LineStyle, str]] = [(found.before, BEFORE, DASH, "law identified alone")]
    if found.verdict is not Verdict.no_effect:
        drawn.append((found.after, AFTER, "-", f"law {after_name(found)}"))
    ends = [*_reach(T)] if T.size else []
    for model, colour, style, name in drawn:
        for sign in _slipping(found):
            end = low if sign < 0 else high
            ends += _branch(ax, model, sign, end, axes, color=colour, ls=style, label=name)
    ax.plot([], [], "D", color=GREY, mfc="white", ms=5, label="limits of sticking, at $v_w$ = 0")
    ax.axhline(0.0, color=GREY, lw=0.5, zorder=0)
    ax.set_xlabel(label("relative velocity $v_w$", axes.x2.unit))
    ax.set_ylabel(label("friction force $T$", axes.force.unit))
    ax.set_ylim(*_margin(force * min(ends), force * max(ends), 0.08))
    left, right = sorted((vs * low, vs * high))  # a reading may run against the model's direction
    ax.set_xlim(*_margin(left, right, 0.06))
    handles = dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=2)
    return figure


def contained(found: Found) -> list[str]:
    """Effects whose force on the block the points contain: they are the equation of motion without them."""
    return [
        "the learned curve" if one.curve is not None else one.name
        for one in found.effects
        if one.where in ON_BLOCK and not one.of_rig and (one.curve is not None or one.name != "unlisted")
    ]


def _branch(
    ax: Plot, model: Model, sign: int, end: float, axes: Axes, *, color: str, ls: LineStyle, label: str
) -> list[float]:
    """Draw a law on one side, up to a velocity, and its limit of sticking; return the forces drawn."""
    vs, size = axes.x2.size, axes.force.size
    v = np.linspace(0.0, end if sign * end > 0 else 0.0, 300)[1:]
    forces = model.friction.force(v) if sign * end > 0 else np.array([])
    ax.plot(vs * v[: forces.size], size * forces, color=color, ls=ls, lw=1.6, label=label)
    minus, plus = model.friction.static_limits
    limit = -minus if sign < 0 else plus
    ax.plot([0], [size * limit], "D", color=color, mfc="white", ms=5, zorder=3)
    return [*(float(one) for one in forces), float(limit)]


def _slipping(found: Found) -> list[int]:
    """Signs of v_w with which the block slips in some run, by the models; both where it never does."""
    modes = np.concatenate([mode for run in found.runs for mode in (run.mode_before, run.mode_after)])
    return [sign for sign in (-1, 1) if np.count_nonzero(modes == sign) > FEW] or [-1, 1]


def _reach(values: Floats) -> tuple[float, float]:
    """Between what values lie, but for a few outliers."""
    low, high = np.nanpercentile(values, [OUTLIERS, 100 - OUTLIERS])
    return float(low), float(high)


def _margin(low: float, high: float, share: float) -> tuple[float, float]:
    reach = share * (high - low) or 1.0
    return low - reach, high + reach


def _force_points(found: Found) -> tuple[Floats, Floats]:
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
