"""Figure of a branch of limit cycles: stable solid, unstable dashed, bifurcations marked."""

from __future__ import annotations

from typing import Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.arguments import must_be
from stickslip.errors import InputError, did_you_mean
from stickslip.shown.plot.curves import BAND, GREY, LIMIT, MEASURED, SIMULATED, STYLE
from stickslip.shown.plot.drawing import Drawing
from stickslip.shown.plot.sweep import SYMBOLS
from stickslip.simulated.orbits.branch import Branch, Kind, SpecialPoint
from stickslip.simulated.orbits.flow import Floats

Quantity = Literal["x1_max", "period", "stick_time"]
Limits = dict[int, tuple[float, float]]  # parameter and quantity at a Hopf point, by its index

LABELS: dict[str, str] = {
    "x1_max": "greatest $x_1$ of the cycle",
    "period": "period",
    "stick_time": "time stuck in a period",
}
MARKS: dict[Kind, tuple[str, str, str]] = {
    "fold": ("s", GREY, "fold"),
    "flip": ("D", LIMIT, "flip"),
    "neimark_sacker": ("P", BAND, "Neimark–Sacker"),
    "hopf": ("o", GREY, "Hopf, of sliding"),
    "loss_of_stick": ("v", SIMULATED, "loss of stick"),
    "crossing": ("X", SIMULATED, "crossing"),
    "grazing": ("^", SIMULATED, "grazing"),
}


def plot_branch(branch: Branch, quantity: Quantity = "x1_max") -> Figure:
    """Draw a branch over its parameter.

    Parameters
    ----------
    branch
        From `continuation`.
    quantity
        "x1_max" (of a rig moved from outside: x1 when it is looked at; of one of bodies or matrices: its first state
        where the cycle is cut), "period" or "stick_time".

    Returns
    -------
    Figure
        `stickslip.shown.plot.curves.save_figure` writes it.

    Raises
    ------
    InputError
        An unknown quantity.
    """
    must_be("branch", branch, Branch, "continuation(...) gives one")
    if quantity not in LABELS:
        raise InputError(did_you_mean(quantity, LABELS), key="quantity", value=quantity)
    columns: dict[str, Floats] = {
        "x1_max": branch.state[:, 0],
        "period": branch.period,
        "stick_time": branch.stick_time,
    }
    limits = {
        one.index: (one.value, _limit(one, quantity)) for one in branch.special if one.sliding is not None
    }
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(5.6, 3.6), layout="constrained")
        ax = figure.subplots()
        _lines(ax, branch, columns[quantity], limits)
        _marks(ax, branch, columns[quantity], limits)
        strobed = quantity == "x1_max" and branch.forced
        words = "$x_1$ once a period of what moves the rig" if strobed else LABELS[quantity]
        if quantity == "x1_max" and branch.states[0] != "x1":
            words = f"{branch.states[0]} where the cycle is cut"
        ax.set(xlabel=SYMBOLS.get(branch.parameter, branch.parameter), ylabel=words)
        handles, names = ax.get_legend_handles_labels()
        unique = dict(zip(names, handles, strict=True))
        figure.legend(unique.values(), unique.keys(), loc="outside upper center", ncols=4)
    return figure


def _limit(hopf: SpecialPoint, quantity: Quantity) -> float:
    """What a quantity of the cycles tends to where they shrink to steady sliding."""
    assert hopf.sliding is not None
    tends: dict[str, float] = {
        "x1_max": float(hopf.sliding.state[0]),
        "period": hopf.period,
        "stick_time": 0.0,
    }
    return tends[quantity]


def _lines(ax: Axes, branch: Branch, y: Floats, limits: Limits) -> None:
    """Draw runs of equal stability; each starts where the last one ended, and one that ends at a Hopf point goes on
    to it.
    """
    changes = np.flatnonzero(np.diff(branch.stable.astype(int))) + 1
    bounds = [0, *changes.tolist(), len(branch)]
    for first, last in zip(bounds[:-1], bounds[1:], strict=True):
        piece = slice(max(first - 1, 0), last)
        stable = bool(branch.stable[first])
        line = np.column_stack([branch.values[piece], y[piece]])
        if first == 0 and 0 in limits:
            line = np.vstack([limits[0], line])
        if last == len(branch) and last in limits:
            line = np.vstack([line, limits[last]])
        ax.plot(
            *line.T,
            color=MEASURED,
            ls="-" if stable else (0, (4, 2)),
            lw=1.6 if stable else 1.2,
            label="stable" if stable else "unstable",
        )


def _marks(ax: Axes, branch: Branch, y: Floats, limits: Limits) -> None:
    for one in branch.special:
        marker, colour, name = MARKS[one.kind]
        if one.sliding is not None:
            height = limits[one.index][1]
        else:
            k = min(max(one.index, 1), len(branch) - 1)
            ends = branch.values[k - 1 : k + 1]
            share = (one.value - ends[0]) / (ends[1] - ends[0]) if ends[1] != ends[0] else 0.0
            height = float(y[k - 1] + np.clip(share, 0.0, 1.0) * (y[k] - y[k - 1]))
        ax.plot(one.value, height, marker, color=colour, ms=6, mec="white", mew=0.6, zorder=3, label=name)
