"""Figures of a report of a rig of bodies or matrices: readings in time, the residual, errors, rivals, its spectrum."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.discovery.general_rig.result import GeneralFound, RigView
from stickslip.shown.plot.curves import GREY, LIMIT, MEASURED, SIMULATED, STYLE
from stickslip.shown.plot.drawing import Drawing

BEFORE, AFTER = SIMULATED, LIMIT
MOST_ROWS = 6
SHOWN = 1500  # samples of a run that a figure of its readings holds
MOST_RIVALS = 14
KEYS = (
    ("before", BEFORE, "s", "before"),
    ("after", AFTER, "o", "after"),
    ("floor", "black", "|", "noise alone"),
)


def _shown(found: GeneralFound) -> RigView:
    return next((one for one in found.views if one.role == "validate"), found.views[0])


def _sides(found: GeneralFound, view: RigView) -> list[tuple[str, str, str, Mapping[str, np.ndarray]]]:
    out = [("declared model", BEFORE, "--", view.before)]
    return out + ([("with what was found", AFTER, "-", view.after)] if found.effects else [])


def readings(found: GeneralFound) -> Figure:
    """Draw the readings of a run that was never fitted, and what either model forecasts of them."""
    view = _shown(found)
    names = list(view.measured)[:MOST_ROWS]
    part = slice(0, SHOWN)
    figure = Drawing(figsize=(8.4, 1.8 * len(names) + 0.8), layout="constrained")
    for ax, name in zip(figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0], names, strict=True):
        ax.plot(view.t[part], view.measured[name][part], color=MEASURED, lw=1.4, label="measured")
        for label, colour, style, made in _sides(found, view):
            ax.plot(view.t[part], made[name][part], color=colour, ls=style, lw=0.9, label=label)
        ax.set_ylabel(name)
    figure.axes[-1].set_xlabel(f"t [s], {view.name}")
    _legend(figure)
    return figure


def in_time(found: GeneralFound) -> Figure:
    """Draw what either fit leaves of the training run that is explained worst, over the noise."""
    train = [one for one in found.views if one.role == "train"]
    view = max(train, key=lambda one: max(float(np.nanmean(r**2)) for r in _left(one, one.after).values()))
    names = list(view.measured)[:MOST_ROWS]
    figure = Drawing(figsize=(8.4, 1.6 * len(names) + 0.8), layout="constrained")
    for ax, name in zip(figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0], names, strict=True):
        ax.axhspan(-2, 2, color=GREY, alpha=0.15, lw=0, label="noise keeps 95 % within")
        for label, colour, _, made in _sides(found, view):
            ax.plot(view.t, _left(view, made)[name], color=colour, lw=0.6, label=label)
        ax.set_ylabel(f"{name} / noise")
    figure.axes[-1].set_xlabel(f"t [s], {view.name}")
    _legend(figure)
    return figure


def _left(view: RigView, made: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {name: (one - made[name]) / view.noise[name] for name, one in view.measured.items()}


def _legend(figure: Figure) -> None:
    handles = dict(zip(*figure.axes[0].get_legend_handles_labels()[::-1], strict=True))
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3)


def errors(found: GeneralFound) -> Figure:
    """Draw the error one window ahead of every run that was never fitted, before, after, and what noise leaves."""
    rows = [(one.run, one.one_cycle) for one in found.error.runs]
    rows.append(("mean", {who: getattr(found.error, who) for who, *_ in KEYS}))
    figure = Drawing(figsize=(7.6, 0.34 * len(rows) + 1.3), layout="constrained")
    ax: Axes = figure.subplots()
    for who, colour, marker, label in KEYS:
        if who != "after" or found.effects:
            ax.plot([row[who] for _, row in rows], range(len(rows)), marker, color=colour, ms=7, label=label)
    ax.set_yticks(range(len(rows)), [name for name, _ in rows])
    ax.invert_yaxis()
    ax.margins(y=0.2)
    ax.set_xlim(left=0.0)
    ax.set_xlabel("error one window ahead, over how far the readings move")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def ranking(found: GeneralFound) -> Figure:
    """Draw how far every rival lies above the best."""
    rows = list(found.ranking[:MOST_RIVALS])
    names = [" + ".join(one.names) or "declared law alone" for one in rows]
    figure = Drawing(
        figsize=(5.4 + 0.07 * max(map(len, names)), 0.27 * len(rows) + 1.0), layout="constrained"
    )
    ax: Axes = figure.subplots()
    for y, one in enumerate(rows):
        ax.plot([one.bic], [y], "o", color=AFTER if one.chosen else GREY, ms=7 if one.chosen else 5)
    ax.set_yticks(range(len(rows)), names)
    ax.invert_yaxis()
    ax.set_xlim(left=0.0)
    ax.margins(x=0.05)
    ax.set_xlabel("-2 log evidence above the lowest")
    return figure


def spectrum(found: GeneralFound) -> Figure:
    """Draw the power of the residual over frequency; white noise is 1."""
    figure = Drawing(figsize=(7.6, 3.2), layout="constrained")
    ax: Axes = figure.subplots()
    f = found.spectrum["frequency"] / (2 * np.pi)
    ax.loglog(f, found.spectrum["before"], color=BEFORE, lw=1.0, label="declared model")
    if found.effects:
        ax.loglog(f, found.spectrum["after"], color=AFTER, lw=1.0, label="with what was found")
    ax.axhline(1.0, color="black", lw=1.0, ls=":", label="noise")
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("power over that of the noise")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def curves(found: GeneralFound) -> Figure:
    """Draw what no name explains, with its 95 % band, in SI."""
    every = [one.curve for one in found.effects if one.curve is not None]
    figure = Drawing(figsize=(6.4, 3.2 * len(every) + 0.3), layout="constrained")
    for ax, one in zip(figure.subplots(len(every), 1, squeeze=False)[:, 0], every, strict=True):
        ax.fill_between(one.x, one.low, one.high, color=AFTER, alpha=0.25, lw=0, label="95 % band")
        ax.plot(one.x, one.value, color=AFTER, lw=1.4, label="as found")
        ax.axhline(0.0, color="black", lw=0.8, ls=":", zorder=0)
        ax.set_xlabel(f"{one.variable} [SI]")
        ax.set_ylabel(f"{one.term} [SI]")
        ax.legend()
    return figure


FIGURES: Mapping[str, Callable[[GeneralFound], Figure]] = {
    "readings_ahead": readings,
    "errors": errors,
    "residual_in_time": in_time,
    "residual_spectrum": spectrum,
    "ranking": ranking,
    "learned_curve": curves,
}


def drawn(found: GeneralFound) -> dict[str, Figure]:
    """Return every figure."""
    with mpl.rc_context(STYLE):
        some = any(one.curve is not None for one in found.effects)
        return {name: draw(found) for name, draw in FIGURES.items() if some or draw is not curves}
