"""Figures of a sweep: bifurcation diagram, map of two parameters, basins of attraction; one call each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stickslip.errors import InputError, did_you_mean, number
from stickslip.shown.plot.curves import GREY, MEASURED, STYLE, label
from stickslip.shown.plot.drawing import Drawing
from stickslip.shown.plot.sweep_axes import coordinate, observed, second, starts, two
from stickslip.simulated.sweep.observables import OBSERVABLES

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#999999")
APART = 64  # groups of starts that are sought; what is in none of them has not settled
WORDS = {"periodicity": {0: "none"}}  # whole numbers that stand for a word
SYMBOLS = {
    "belt_speed": "$v_b$",
    "stick_fraction": "stick fraction",
    "period": "mean time between releases",
    "periodicity": "periodicity",
    **{
        f"{head}{x}{k}": f"${x}_{k}{tail}$"
        for x in "xy"
        for k in "12"
        for head, tail in (("", ""), ("initial.", "(0)"))
    },
    **{name: rf"$\{name[:-1]}_{{{name[-1]}}}$" for name in ("alpha1", "alpha2", "beta3", "eta1")},
    "eta12": r"$\eta_{12}$",
}


def bifurcation_diagram(
    ds: xr.Dataset, state: str = "x1", *, parameter: str | None = None, select: str | None = None
) -> Figure:
    """Draw a state at the last releases over a parameter.

    Parameters
    ----------
    ds
        From `sweep` over one dimension, with "points" observed. Starts beside it are drawn over each other: a
        diagram shows all attractors. A second parameter of at most 8 values has a colour for each.
    state
        Which state.
    parameter
        Coordinate along the abscissa; that of the first dimension if absent.
    select
        Another variable to colour the points by, such as "stick_fraction"; over one parameter only.

    Raises
    ------
    InputError
        The dataset lacks the points, the state, the parameter or the variable, or varies more than can be told apart.
    """
    points = observed(ds, "points")
    states = [str(name) for name in ds["state"].values]
    if state not in states:
        raise InputError(f"unknown state; {did_you_mean(str(state), states)}", key="state", value=state)
    colour = None if select is None else observed(ds, select)
    if colour is not None and {"state", "point"} & set(colour.dims):
        words = f"has a value for each {' and '.join(str(d) for d in colour.dims if d in ('state', 'point'))}"
        raise InputError(f"{words}; choose a result with one for each member", key="select", value=select)
    dims = [str(dim) for dim in points.dims if dim not in ("point", "state")]
    if not dims:
        raise InputError("has no dimension left to draw along; keep the one of a parameter", key="dataset")
    along = coordinate(ds, parameter, dims[0])
    beside = second(
        ds, [dim for dim in dims if dim not in ds[along].dims], along, 1 if select else len(COLOURS)
    )
    value = points.isel(state=states.index(state))
    x = ds[along].broadcast_like(value)
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(7.2, 4.2), layout="constrained")
        ax = figure.subplots()
        look: dict[str, Any] = {
            "s": 4.0 if value.size < 20000 else 1.0,
            "lw": 0,
            "rasterized": value.size > 5000,
        }
        if beside is not None:
            for i, one in enumerate(ds[beside].values):
                here = {str(ds[beside].dims[0]): i}
                ax.scatter(x.isel(here), value.isel(here), color=COLOURS[i], **look)
                ax.scatter([], [], s=20, lw=0, color=COLOURS[i], label=f"{_label(ds, beside)} = {one:.4g}")
            figure.legend(loc="outside upper center", ncols=4)
        elif colour is None:
            ax.scatter(x, value, color=MEASURED, **look)
        else:
            drawn = ax.scatter(x, value, c=colour.broadcast_like(value), cmap="viridis", **look)
            figure.colorbar(drawn, ax=ax, label=_label(ds, str(select)))
        ax.set_xlabel(_label(ds, along))
        ax.set_ylabel(_state_label(ds, state, " at releases"))
    return figure


def parameter_map(ds: xr.Dataset, variable: str = "stick_fraction", *, state: str | None = None) -> Figure:
    """Draw a result over two parameters, as colour; whole numbers such as the periodicity in a colour each.

    Parameters
    ----------
    ds
        From `sweep` over two dimensions.
    variable
        Which result.
    state
        Which state, of one that has them.

    Raises
    ------
    InputError
        The dataset has not two dimensions, or lacks the variable or the state.
    """
    values = observed(ds, variable)
    if "state" in values.dims:
        states = [str(name) for name in ds["state"].values]
        if state not in states:
            raise InputError(f"give one of {', '.join(states)}", key="state", value=state)
        values = values.isel(state=states.index(state))
    down, across = two(ds, [str(dim) for dim in values.dims])
    done = (observed(ds, "status") == 0).transpose(*values.dims).values
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(6.0, 4.6), layout="constrained")
        ax = figure.subplots()
        whole = OBSERVABLES[variable].dtype.startswith("int") if variable in OBSERVABLES else False
        shown = np.where(done, values.values, np.nan) if variable != "status" else values.values.astype(float)
        name = (
            f"{SYMBOLS.get(variable, variable)} of {_state_label(ds, state)}"
            if state
            else _label(ds, variable)
        )
        _mesh(figure, ax, ds, (down, across), shown, name, whole=whole, words=WORDS.get(variable, {}))
    return figure


def basin(ds: xr.Dataset, *, tolerance: float = 1e-3) -> Figure:
    """Draw which attractor each start leads to, from a sweep over two initial values.

    Attractors are told apart by the ranges of the states after the transient: members whose `state_min` and
    `state_max` agree are on the same one. So observe these, and count from `after` a transient.

    Parameters
    ----------
    ds
        From `sweep` over two dimensions, with "state_min" and "state_max" observed.
    tolerance
        Difference allowed, as a share of the largest displacement or velocity.

    Raises
    ------
    InputError
        The dataset has not two dimensions, varies anything but initial values, or lacks these results.
    """
    tolerance = number("tolerance", tolerance, above=0)
    low, high, status = (observed(ds, name) for name in ("state_min", "state_max", "status"))
    if "state" not in low.dims:
        raise InputError("has one state left; a basin is told by all of them", key="dataset")
    dims = [dim for dim in low.dims if dim != "state"]
    down, across = starts(ds, [str(dim) for dim in dims])
    low, high, status = low.transpose(*dims, "state"), high.transpose(*dims, "state"), status.transpose(*dims)
    features = np.concatenate([low.values, high.values], axis=-1)
    flat = features.reshape(-1, features.shape[-1])
    flat = np.where((status.values.ravel() == 0)[:, None], flat, np.nan)
    which, kinds, lumped = attractors(flat, tolerance)
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(6.0, 4.6), layout="constrained")
        ax = figure.subplots()
        colours = ListedColormap([COLOURS[i % len(COLOURS)] for i in range(max(1, len(kinds)))])
        limits: dict[str, Any] = {"vmin": -0.5, "vmax": max(1, len(kinds)) - 0.5}
        cells(ax, ds[across].values, ds[down].values, which.reshape(low.shape[:2]), cmap=colours, **limits)
        d = low.shape[-1]
        for i, one in enumerate(kinds):
            share = int((which == i).sum()) / len(flat)
            name = (
                f"others, or not settled ({_percent(share)})"
                if i == lumped
                else _described(one[:d], one[d:], share)
            )
            ax.scatter([], [], marker="s", color=colours(i), s=40, label=name)
        ax.set_xlabel(_label(ds, across))
        ax.set_ylabel(_label(ds, down))
        figure.legend(loc="outside upper center", ncols=min(2, max(1, len(kinds))))
    return figure


def attractors(
    features: Floats, tolerance: float = 1e-3, most: int = 8
) -> tuple[Floats, list[Floats], int | None]:
    """Group rows that agree: (n,) group of each, NaN where there is none; a row for each, the commonest first; and the
    group, if any, of all that are beyond the first `most` - 1: those have not settled, or are too many to tell apart.

    Rows are within `tolerance` of the first of their group, as a share of the largest number there is.
    """
    which = np.full(len(features), np.nan)
    left = np.isfinite(features).all(axis=1)
    if not left.any():
        return which, [], None
    scale = float(np.abs(features[left]).max()) or 1.0
    groups: list[NDArray[np.bool_]] = []
    for first in _commonest(features[left], tolerance * scale):
        if not left.any():
            break
        same = left & (np.abs(features - first).max(axis=1) <= tolerance * scale)
        if same.any():
            groups.append(same)
        left = left & ~same
    groups.sort(key=lambda same: -int(same.sum()))
    if left.any():
        groups.append(np.asarray(left))
    lumped = most - 1 if len(groups) > most else None
    if lumped is not None:
        groups[lumped:] = [np.logical_or.reduce(groups[lumped:])]
    for i, same in enumerate(groups):
        which[same] = i
    return which, [features[np.argmax(same)] for same in groups], lumped


def _commonest(rows: Floats, width: float) -> Floats:
    """A row of each of the fullest cells of this width, the fullest first."""
    _, first, count = np.unique(np.round(rows / width), axis=0, return_index=True, return_counts=True)
    return np.asarray(rows[first[np.argsort(-count, kind="stable")][:APART]])


def cells(ax: Axes, x: Floats, y: Floats, values: Floats, **settings: Any) -> Any:
    """Draw a cell for each value (y, x), to half the way to its neighbours, whatever the order of the coordinates."""
    a, b = np.argsort(x, kind="stable"), np.argsort(y, kind="stable")
    edges = _edges(x[a]), _edges(y[b])
    return ax.pcolormesh(*edges, values[np.ix_(b, a)], shading="flat", rasterized=True, **settings)


def _edges(at: Floats) -> Floats:
    """Between neighbours, and as far beyond the last; a single one has a width all the same."""
    at = np.asarray(at, dtype=np.float64)
    if len(at) == 1:
        return np.asarray(at[0] + np.array([-0.05, 0.05]) * (abs(at[0]) or 1.0))
    middle = 0.5 * (at[1:] + at[:-1])
    return np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _described(low: Floats, high: Floats, share: float) -> str:
    size = high[0] - low[0]
    what = f"steady at $x_1$ = {low[0]:.3g}" if size < 1e-3 else f"cycle, $x_1$ {low[0]:.3g} .. {high[0]:.3g}"
    return f"{what} ({_percent(share)})".replace("-", "\N{MINUS SIGN}")


def _mesh(
    figure: Figure,
    ax: Axes,
    ds: xr.Dataset,
    axes: tuple[str, str],
    values: Floats,
    name: str,
    *,
    whole: bool,
    words: Mapping[int, str],
) -> None:
    down, across = axes
    settings: dict[str, Any] = {"cmap": "viridis"}
    there = np.unique(values[np.isfinite(values)])
    if whole and 0 < len(there) <= 20:
        edges = np.append(there - 0.5, there[-1] + 0.5)
        settings = {
            "cmap": mpl.colormaps["viridis"].resampled(len(there)),
            "norm": BoundaryNorm(edges, len(there)),
        }
    drawn = cells(ax, ds[across].values, ds[down].values, values, **settings)
    bar = figure.colorbar(drawn, ax=ax, label=name)
    if "norm" in settings:
        bar.set_ticks(0.5 * (edges[1:] + edges[:-1]), labels=[words.get(int(v), f"{v:.0f}") for v in there])
    ax.set_facecolor("#dddddd")  # what failed or was not computed
    ax.set_xlabel(_label(ds, across))
    ax.set_ylabel(_label(ds, down))
    ax.tick_params(color=GREY)


def _state_label(ds: xr.Dataset, state: str, where: str = "") -> str:
    """Label of a state, with its unit where that is known."""
    names = [str(one) for one in np.atleast_1d(ds["state"].values)]
    units = str(ds["state"].attrs.get("units", "")).split(", ")
    unit = units[names.index(state)] if len(units) == len(names) else "1"
    return label(SYMBOLS.get(state, state) + where, unit)


def _label(ds: xr.Dataset, name: str) -> str:
    unit = str(ds[name].attrs.get("units", "1"))
    return label(SYMBOLS.get(name, name), "1" if "rig's units" in unit else unit)
