"""The figures of the residual: in time, its spectrum, and against the variable of what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes as Plot
from matplotlib.figure import Figure
from scipy.stats import binned_statistic

from stickslip.declared.dimensions import FORCE
from stickslip.declared.si import curve_dimension
from stickslip.discovery.result import Curve, Found, FoundEffect, RunView, Verdict
from stickslip.measured.fit_window import Array
from stickslip.shown.plot.curves import BAND, DOTS, GREY, label
from stickslip.shown.report.figures import AFTER, BEFORE, DASH, after_name, before_name, sheet, styled
from stickslip.shown.report.motion import phase_of, residual
from stickslip.shown.report.units import Axes

CHANNELS = ("x1", "y1")
COLUMNS = {"x1": 0, "x2": 1, "y1": 2, "y2": 3}
BINS = 24
ALIKE = 3.0  # times what a panel needs that a scale shared with its neighbour may be
NOISE = "±2, where noise alone keeps 95 %"


def worst_run(found: Found) -> RunView:
    """The training run that is explained worst, by what was found if that leaves something over."""
    which = "before" if found.residual_after.clean else "after"
    return max(_train(found), key=lambda run: float(np.nanmean(residual(run, which, "x1") ** 2)))


@styled
def in_time(found: Found, axes: Axes) -> Figure:
    """Residual over noise in time, before and after, on the training run that is explained worst."""
    run = worst_run(found)
    columns = _columns(found)
    channels = tuple(run.measured)
    figure = sheet(9.4, 2.0 * len(channels) + 0.2)
    grid = figure.subplots(len(channels), len(columns), squeeze=False, sharex=True)
    every = max(1, len(run.t) // DOTS)
    for row, channel in zip(grid, channels, strict=True):
        tops = []
        for ax, (which, colour) in zip(row, columns, strict=True):
            z = residual(run, which, channel)
            ax.axhspan(-2, 2, color=BAND, alpha=0.45, lw=0, zorder=0, label=NOISE)
            ax.plot(axes.t.size * run.t[::every], z[::every], color=colour, lw=0.6)
            tops.append(max(4.0, 1.08 * float(np.nanmax(np.abs(z)))))
        _scales(row, tops)
        row[0].set_ylabel(f"{channel} residual / noise")
    for ax, (which, colour) in zip(grid[0], columns, strict=True):
        title = "declared model alone" if which == "before" else after_name(found)
        ax.set_title(title, color=colour, fontsize=10)
    for ax in grid[-1]:
        ax.set_xlabel(label(f"time since the start of {run.name}", axes.t.unit))
    figure.legend(*_legend(figure), loc="outside upper center")
    return figure


def _scales(row: Sequence[Plot], tops: Sequence[float]) -> None:
    """One y scale for a row, or where one panel would be flat in it its own, and how much finer that is."""
    most = max(tops)
    for ax, top in zip(row, tops, strict=True):
        own = top if top * ALIKE < most else most
        ax.set_ylim(-own, own)
        if own < most:
            words = f"scale {most / own:.0f} times finer"
            ax.text(0.99, 0.98, words, transform=ax.transAxes, ha="right", va="top", fontsize=8, color=GREY)


def _legend(figure: Figure) -> tuple[list[Artist], list[str]]:
    """Handles and names of all panels, each name once."""
    known: dict[str, Artist] = {}
    for ax in figure.axes:
        for handle, name in zip(*ax.get_legend_handles_labels(), strict=True):
            known.setdefault(name, handle)
    return list(known.values()), list(known)


def _columns(found: Found) -> tuple[tuple[str, str], ...]:
    nothing = found.verdict is Verdict.no_effect
    return (("before", BEFORE),) if nothing else (("before", BEFORE), ("after", AFTER))


@styled
def spectrum(found: Found, axes: Axes) -> Figure:
    """Power of the residual over frequency; white noise is 1."""
    figure = sheet(7.6, 3.6)
    ax = figure.subplots()
    w = axes.rate.size * found.spectrum["frequency"]
    before, after = found.spectrum["before"], found.spectrum["after"]
    ok = w > 0
    ax.plot(w[ok], before[ok], color=BEFORE, lw=1.0, label="before")
    if found.verdict is not Verdict.no_effect:
        ax.plot(w[ok], after[ok], color=AFTER, lw=1.0, label="after")
    ax.axhline(1.0, color="black", lw=1.0, ls=DASH, label="white noise")
    for effect in found.effects:
        if "w" in effect.parameters:
            at = axes.rate.size * effect.parameters["w"].value
            ax.axvline(at, color=GREY, lw=0.9, ls=(0, (1, 2)), label=f"found frequency, $w$ of {effect.name}")
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel(label("angular frequency", axes.rate.unit))
    ax.set_ylabel("power / noise power")
    figure.legend(loc="outside upper center", ncols=4)
    return figure


@styled
def against_variable(found: Found, axes: Axes) -> Figure:
    """Mean residual of the training runs against the variable (or phase) of each effect, before and after."""
    effects = found.effects or (None,)
    channels = _channels(found)
    figure = sheet(4.8 * max(len(effects), 1.4), 2.1 * len(channels))
    grid = figure.subplots(len(channels), len(effects), squeeze=False, sharex="col")
    for column, effect in zip(grid.T, effects, strict=True):
        name, variable = (effect.name, main_variable(found, effect)) if effect else ("", "v_w")
        phases = effect.phases if effect else {}
        values, words, own = _values(found, axes, name, variable, phases)
        for ax, channel in zip(column, channels, strict=True):
            for which, colour in _columns(found):
                _binned(
                    ax,
                    values,
                    _all(found, which, channel),
                    colour,
                    before_name(found) if which == "before" else which,
                )
            ax.axhline(0.0, color="black", lw=0.8, ls=DASH, zorder=0)
            ax.set_ylabel(f"{channel} residual / noise")
        column[-1].set_xlabel(words)
        if name:
            column[0].set_title(name if own else f"{name}, where it shows most", fontsize=10)
    figure.legend(*_legend(figure), loc="outside upper center", ncols=4)
    return figure


def _channels(found: Found) -> tuple[str, ...]:
    """Displacements that the runs record: x1, and y1 where the rig has an angle body."""
    return tuple(channel for channel in CHANNELS if channel in found.runs[0].measured)


def main_variable(found: Found, effect: FoundEffect) -> str:
    """The variable that a residual is drawn against: of those the effect depends on, the one that orders it most.

    An effect with a memory follows rates, so the velocities stand as candidates for it.
    """
    names = [v for v in effect.depends_on if v in COLUMNS or v in ("v_w", "t")]
    if effect.curve is not None:
        return effect.curve.variable
    if "memory" in effect.depends_on:
        names += ["x2", "y2"] if effect.where.endswith("channel") else ["v_w"]
    z = [_all(found, "before", channel) for channel in _channels(found)]
    return max(names or ["v_w"], key=lambda name: sum(_ordered(_column(found, name), one) for one in z))


def _ordered(x: Array, z: Array) -> float:
    """Sum of squares of z that its means in bins of x account for."""
    good = np.isfinite(x) & np.isfinite(z)
    edges = np.unique(np.quantile(x[good], np.linspace(0, 1, BINS + 1)))
    if edges.size < 3:
        return 0.0
    which = np.clip(np.digitize(x[good], edges) - 1, 0, edges.size - 2)
    count = np.bincount(which, minlength=edges.size - 1)
    total = np.bincount(which, weights=z[good], minlength=edges.size - 1)
    return float(np.sum(total**2 / np.maximum(count, 1)))


def _column(found: Found, variable: str) -> Array:
    runs = _train(found)
    if variable == "t":
        return np.concatenate([run.t for run in runs])
    if variable == "v_w":
        return np.concatenate([run.speed_before for run in runs])
    return np.concatenate([run.state_before[:, COLUMNS[variable]] for run in runs])


def _train(found: Found) -> list[RunView]:
    return [run for run in found.runs if run.role == "train"] or list(found.runs)


def _all(found: Found, which: str, channel: str) -> Array:
    return np.concatenate([residual(run, which, channel) for run in _train(found)])


def _values(
    found: Found, axes: Axes, name: str, variable: str, phases: Mapping[str, float]
) -> tuple[Array, str, bool]:
    """What a residual is drawn against, its words, and whether the effect itself depends on that."""
    own = True
    folded = [phase_of(found.after, run, name, phases.get(run.name, 0.0)) for run in _train(found)]
    if phases and all(one is not None for one in folded):
        phase = np.concatenate([one for one in folded if one is not None])
        z = [_all(found, "before", channel) for channel in _channels(found)]
        if sum(_ordered(phase, one) for one in z) > sum(_ordered(_column(found, "v_w"), one) for one in z):
            return phase, f"phase of {name} [rad]", True
        own, variable = False, "v_w"  # what a phase does to the motion may show at another one
    axis = axes.variable(variable)
    symbols = {"v_w": "relative velocity $v_w$", "t": "time in the run $t$"}
    symbol = symbols.get(variable, f"${variable[0]}_{variable[1:]}$")
    return axis.size * _column(found, variable), label(symbol, axis.unit), own


def _binned(ax: Plot, x: Array, z: Array, colour: str, name: str) -> None:
    good = np.isfinite(x) & np.isfinite(z)
    x, z = x[good], z[good]
    edges = np.unique(np.quantile(x, np.linspace(0, 1, BINS + 1)))
    if edges.size < 3:
        return
    centre = binned_statistic(x, x, "mean", bins=edges).statistic
    mean = binned_statistic(x, z, "mean", bins=edges).statistic
    spread = binned_statistic(x, z, "std", bins=edges).statistic
    count = binned_statistic(x, z, "count", bins=edges).statistic
    full = count > 4
    error = 2 * spread[full] / np.sqrt(count[full])
    marker = "o" if name == "after" else "s"
    ax.errorbar(
        centre[full], mean[full], yerr=error, fmt=marker, color=colour, ms=4, lw=1.0,
        label=f"{name}, mean in a bin ± 2 standard errors",
    )  # fmt: skip


@styled
def curve(found: Found, axes: Axes) -> Figure:
    """The learned curve of an effect without a name, with its 95 % band, knots and guess."""
    curves = [effect.curve for effect in found.effects if effect.curve is not None]
    figure = sheet(6.4, 3.6 * len(curves) + 0.3)
    for ax, one in zip(figure.subplots(len(curves), 1, squeeze=False).ravel(), curves, strict=True):
        _curve(ax, one, axes)
    return figure


def _curve(ax: Plot, one: Curve, axes: Axes) -> None:
    axis = axes.variable(one.variable)
    x = axis.size * one.x
    size, unit = _curve_unit(one, axes)
    ax.fill_between(x, size * one.low, size * one.high, color=BAND, alpha=0.5, lw=0, label="95 % band")
    ax.plot(x, size * one.value, color=AFTER, lw=1.6, label="learned")
    knots = one.knots[(one.knots >= one.x[0]) & (one.knots <= one.x[-1])]
    ax.plot(axis.size * knots, size * np.interp(knots, one.x, one.value), "o", color=AFTER, mfc="white", ms=5)
    ax.axhline(0.0, color="black", lw=0.8, ls=DASH, zorder=0)
    ax.set_xlabel(label(f"{one.variable} in one period" if one.period else one.variable, axis.unit))
    ax.set_ylabel(label(one.term, unit))
    if one.guess:
        ax.set_title(f"looks like {one.guess} (model units)", fontsize=9)
    ax.legend()


def _curve_unit(one: Curve, axes: Axes) -> tuple[float, str]:
    if one.where == "x1 channel":
        return axes.x1.size, axes.x1.unit
    if one.where == "y1 channel":
        return axes.y1.size, axes.y1.unit
    return (axes.force.size, axes.force.unit) if curve_dimension(one.where) == FORCE else (1.0, "1")
