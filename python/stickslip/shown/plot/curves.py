"""Figures: phase portrait (Fig. 4), friction characteristic (Fig. 3), time series; SVG and PNG.

Colours are Okabe and Ito's, told apart by readers with any colour vision: measured is blue, simulated vermilion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.declared.scale import Quantity, Scale, scales
from stickslip.files import whole
from stickslip.fitted.compare import Comparison, per_model, speed_unit
from stickslip.fitted.dominant_cycle import dominant
from stickslip.fitted.identified import BRANCHES, Branch, Identified
from stickslip.measured.fit_window import Array
from stickslip.measured.recording import Recording
from stickslip.measured.sticks import Track
from stickslip.shown.plot.between import between, own_steps
from stickslip.shown.plot.drawing import Drawing
from stickslip.simulated.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas as pd

MEASURED, SIMULATED, BAND, LIMIT, GREY = "#0072B2", "#D55E00", "#E69F00", "#009E73", "#555555"
STYLE: dict[Any, Any] = {  # matplotlib's own stubs spell every key out
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.labelsize": 10.0,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.solid_capstyle": "round",
    "svg.fonttype": "none",
    "svg.hashsalt": "stickslip",
    "savefig.dpi": 200,
}
DOTS = 4000  # points drawn at most; more only make the file large
THIN = 0.01  # of an axis
MOST_DRAWN = 40  # transitions of a run over time
P = ParamSpec("P")


def _styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Draw in the house style, whatever the caller's settings are, and leave those as they were."""

    @wraps(draw)
    def drawn(*args: P.args, **keywords: P.kwargs) -> Figure:
        with mpl.rc_context(STYLE):
            return draw(*args, **keywords)

    return drawn


def _figure(width: float, height: float, rows: int = 1, columns: int = 1) -> tuple[Figure, list[Axes]]:
    figure = Drawing(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex="col" if rows > 1 else "none")
    for ax in axes.ravel():
        ax.locator_params(nbins=6)
    return figure, list(axes.ravel())


def save_figure(figure: Figure, path: str | Path) -> tuple[Path, Path]:
    """Write `path`.svg and `path`.png whole; return both paths."""
    out = []
    with mpl.rc_context(STYLE):  # laid out once, for both
        figure.draw_without_rendering()
        figure.set_layout_engine(None)
    for kind in ("svg", "png"):
        target = Path(f"{path}.{kind}")
        metadata = {"Date": None} if kind == "svg" else None
        with mpl.rc_context(STYLE), whole(target) as temporary:
            figure.savefig(temporary, format=kind, metadata=metadata)
        out.append(target)
    return out[0], out[1]


def label(symbol: str, unit: str) -> str:
    """Axis label: symbol and unit, the unit left out where there is none."""
    return symbol if unit in ("1", "") else f"{symbol} [{unit.replace('um', 'µm')}]"


def _scales(c: Comparison) -> tuple[float, float, float]:
    """Model to readings: time, displacement, velocity."""
    t, x = per_model(c.recording, "t"), per_model(c.recording, "x1")
    return t, x, speed_unit(c.recording)[1]


def _x_symbol(c: Comparison) -> str:
    return "spring force $k x_1$" if c.recording.channel("x1") == "spring_force" else "$x_1$"


@_styled
def phase_portrait(comparison: Comparison) -> Figure:
    """Block velocity against displacement, measured and simulated, over the second half of the run (Fig. 4)."""
    c = comparison
    figure, (ax,) = _figure(5.2, 4.2)
    _, xs, vs = _scales(c)
    drawn: tuple[tuple[Track, str, str, float, float], ...] = (
        (c.measured, MEASURED, "measured", 1.5, 0.4),
        (c.simulated, SIMULATED, "simulated", 1.0, 1.0),
    )
    for track, colour, name, width, alpha in drawn:
        half = len(track.t) // 2
        ax.plot(xs * track.x[half:], vs * track.v[half:], color=colour, lw=width, alpha=alpha, label=name)
    ax.axhline(vs * c.belt_speed, color=GREY, lw=0.8, ls=(0, (4, 3)), zorder=0)
    ax.annotate(
        "belt speed $v_b$",
        (1.0, vs * c.belt_speed),
        xycoords=("axes fraction", "data"),
        xytext=(0, 4 if c.belt_speed >= 0 else -11),
        textcoords="offset points",
        color=GREY,
        fontsize=8,
        ha="right",
    )
    ax.margins(y=0.1)
    ax.set_xlabel(label(_x_symbol(c), c.units[1]))
    ax.set_ylabel(label("$x_2$", c.units[2]))
    figure.legend(loc="outside upper right", ncols=2)
    return figure


@_styled
def friction_characteristic(found: Identified) -> Figure:
    """Friction force against relative velocity: points from the readings, the law and its 95 % band (Fig. 3).

    In SI for a rig declared in SI. The points are drawn, not fitted: the filter that gives their velocities rounds
    corners and bends steep stretches, so that they may lie off a law that reproduces the readings.
    """
    seen = [b for b in BRANCHES if found.covered[b] is not None]
    width = 9.0 if len(seen) == 2 else 5.8  # as wide as the legend
    figure, axes = _figure(width, 4.0, 1, max(len(seen), 1))
    known = scales(found.rig, found.channels)
    speed, force = known["x2"], known["force"]
    handles: dict[str, Artist] = {}
    thin = [
        _branch(ax, found, branch, speed.size, force.size) for ax, branch in zip(axes, seen, strict=False)
    ]
    for ax in axes:
        ax.set_xlabel(label("relative velocity $v_w$", speed.unit))
        for handle, name in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(name, handle)
    _alike(axes)
    axes[0].set_ylabel(label("friction force $T$", force.unit))
    note = " (thinner than its line)" if thin and all(thin) else ""  # one patch, one entry
    names = [name + note if name.startswith("95 %") else name for name in handles]
    figure.legend(list(handles.values()), names, loc="outside upper center", ncols=2 if len(seen) < 2 else 3)
    return figure


def _alike(axes: Sequence[Axes]) -> None:
    """Give axes ranges of one height, so that slopes and scatter can be compared by eye."""
    spans = [ax.get_ylim() for ax in axes]
    most = max(high - low for low, high in spans)
    for ax, (low, high) in zip(axes, spans, strict=True):
        extra = most - (high - low)
        ax.set_ylim((low - extra, high) if low < -high else (low, high + extra))


def _branch(ax: Axes, found: Identified, branch: Branch, speed: float, force: float) -> bool:
    """Draw one branch; return whether its band is too thin to be seen beside its line."""
    sign = -1.0 if branch == "minus" else 1.0
    covered = found.covered[branch]
    assert covered is not None
    _points(ax, found, sign, speed, force)
    top = covered[1]
    u = np.linspace(0.0, top, 400)
    low, value, high = (force * x for x in found.band(branch, u))
    static = force * found.law.static_limits[0 if branch == "minus" else 1]
    span = _force_range(found, sign, value, static, force)
    band = f"95 % band of the {'mean ' if found.events is not None else ''}law"
    ax.fill_between(
        speed * sign * u, sign * low, sign * high, color=BAND, alpha=0.55, lw=0, label=band, zorder=3
    )
    name = "identified law" if found.events is None else "identified law, mean of the slips"
    ax.plot(speed * sign * u, sign * value, color=SIMULATED, lw=1.6, label=name, zorder=4)
    ax.plot(
        [0], [sign * static], "o", color=SIMULATED, mfc="white", mew=1.4, ms=6, label="static limit", zorder=5
    )
    if found.events is not None:
        ax.plot(
            np.zeros(len(found.events.t)),
            sign * force * found.events.static,
            "_",
            color=LIMIT,
            ms=11,
            alpha=0.6,
            label="breakaway, each slip",
            zorder=4,
        )
    ax.set_xlim(*sorted((-sign * speed * 0.05 * top, sign * speed * 1.04 * top)))
    ax.set_ylim(*span)
    return bool(np.nanmax(high - low) < THIN * (span[1] - span[0]))


def _force_range(
    found: Identified, sign: float, value: Array, static: float, force: float
) -> tuple[float, float]:
    all_ = [*value.tolist(), static]
    if found.events is not None:
        all_ += [force * float(found.events.static.min()), force * float(found.events.static.max())]
    if found.force is not None and (inside := found.force.mode == sign).any():
        all_ += (force * np.quantile(np.abs(found.force.T[inside]), [0.005, 0.995])).tolist()
    low, high = min(all_), max(all_)
    pad = 0.12 * (high - low)
    a, b = sign * (low - pad), sign * (high + pad)
    return min(a, b), max(a, b)


def _points(ax: Axes, found: Identified, sign: float, speed: float, force: float) -> None:
    if found.force is None:
        return
    here = np.flatnonzero(found.force.mode == sign)
    std = found.force.T_std[here]
    here = here[std <= 2 * np.median(std)] if here.size else here  # the ends of a slip are uncertain
    if here.size > DOTS:
        here = np.random.default_rng(0).choice(here, DOTS, replace=False)
    ax.plot(
        speed * found.force.v_w[here],
        force * found.force.T[here],
        ".",
        color=MEASURED,
        ms=2.2,
        alpha=0.35,
        mew=0,
        rasterized=True,
    )
    ax.plot([], [], ".", color=MEASURED, ms=7, mew=0, label="readings through a filter, not fitted")


@_styled
def time_series(comparison: Comparison, *, span: float | None = None) -> Figure:
    """Displacement and velocity over time, measured and simulated, with the measured transitions marked.

    Parameters
    ----------
    comparison : Comparison
    span : float, optional
        Length drawn, in the rig's unit of time; the first eight measured cycles if absent. Cycles and marks are of
        the slips that the table counts.
    """
    c, seen = comparison, dominant(comparison.measured).track
    ts, xs, vs = _scales(c)
    t = c.measured.t
    if span is None:
        releases = seen.releases
        span = float(releases[8] - t[0]) if len(releases) > 8 else float(t[-1] - t[0])
    part = slice(0, int(np.searchsorted(t, t[0] + span)) + 1)
    figure, (top, bottom) = _figure(7.2, 4.4, 2, 1)
    top.plot(ts * t[part], xs * c.readings[part, 0], color=MEASURED, lw=2.2, alpha=0.45)
    top.plot(ts * t[part], xs * c.simulated.x[part], color=SIMULATED, lw=1.0)
    bottom.plot(ts * t[part], vs * c.measured.v[part], color=MEASURED, lw=2.2, alpha=0.45, label="measured")
    bottom.plot(ts * t[part], vs * c.simulated.v[part], color=SIMULATED, lw=1.0, label="simulated")
    for k, (events, name) in enumerate(((seen.releases, "release"), (seen.captures, "capture"))):
        inside = events[events <= t[0] + span]
        x = np.interp(inside, t, c.measured.x)
        top.plot(
            ts * inside, xs * x, "^v"[k], color=LIMIT, mfc="white", ms=5, mew=1.1, label=f"{name}, measured"
        )
    unit = "" if c.units[0] in ("", "1") else f" {c.units[0]}"
    part_of = (
        ""
        if span >= t[-1] - t[0]
        else f"; the first {ts * span:.3g} of {ts * (t[-1] - t[0]):.3g}{unit} are shown"
    )
    top.set_title(
        "simulation started once, at the first reading, and left to itself" + part_of,
        fontsize=8,
        color=GREY,
        loc="left",
    )
    top.set_ylabel(label(_x_symbol(c), c.units[1]))
    bottom.set_ylabel(label("$x_2$", c.units[2]))
    bottom.set_xlabel(label("time since the start of the run $t$", c.units[0]))
    figure.legend(loc="outside upper center", ncols=4)
    return figure


@_styled
def trajectory(
    run: Trajectory,
    names: tuple[str, ...],
    *,
    belt_speed: float | None,
    units: Mapping[Quantity, Scale] | None = None,
) -> Figure:
    """A simulation: the block over time with its transitions, and its phase portrait.

    Of a run with many transitions the last ones are drawn over time, and stand out in the portrait.

    Parameters
    ----------
    run, names, belt_speed
        The run, the names of its states, and v_b, None where that changes; in the model's numbers.
    units
        How they are drawn, from `stickslip.declared.scale.scales`; as they are if absent.
    """
    t, x, v, y = ((units or {}).get(name, Scale()) for name in ("t", "x1", "x2", "y1"))
    times, state = _with_corners(run)
    happened = run.transitions.t[(run.transitions.t >= run.t[0]) & (run.transitions.t <= run.t[-1])]
    begin = happened[-MOST_DRAWN] if len(happened) > MOST_DRAWN else run.t[0]
    late = times >= begin
    figure, (left, right) = _figure(9.0, 3.8, 1, 2)
    left.plot(t.size * times[late], x.size * state[late, 0], color=SIMULATED, lw=1.1, label="$x_1$")
    if "y1" in names:
        own, second = label("$y_1$", "" if y.unit == x.unit else y.unit), state[late, names.index("y1")]
        left.plot(t.size * times[late], y.size * second, color=MEASURED, lw=1.0, label=own)
    was, then = run.transitions.before, run.transitions.after
    for chosen, marker, name in (
        (was == 0, "^", "release"),
        (then == 0, "v", "capture"),
        (was * then < 0, "d", "turn of the slip"),
    ):
        inside = chosen & (run.transitions.t >= begin) & (run.transitions.t <= run.t[-1])
        if not inside.any():
            continue
        at, where = t.size * run.transitions.t[inside], x.size * run.transitions.state[inside, 0]
        left.plot(at, where, marker, color=LIMIT, mfc="white", ms=5, label=name)
    left.set_xlabel(label("time $t$", t.unit))
    left.set_ylabel(label("displacement", x.unit))
    if not late.all():
        left.set_title(f"the last {MOST_DRAWN} of {len(happened)} transitions", fontsize="medium")
        right.plot(
            x.size * state[~late, 0], v.size * state[~late, 1], color=GREY, lw=0.6, label="before these"
        )
    right.plot(x.size * state[late, 0], v.size * state[late, 1], color=SIMULATED, lw=1.0)
    if belt_speed is not None:
        right.axhline(v.size * belt_speed, color=GREY, lw=0.8, ls=(0, (4, 3)), zorder=0)
    right.set_xlabel(label("$x_1$", x.unit))
    right.set_ylabel(label("$x_2$", v.unit))
    figure.legend(loc="outside upper center", ncols=5)
    return figure


@_styled
def forecast(past: Recording, following: pd.DataFrame) -> Figure:
    """A forecast after the end of the record that it follows from, channel by channel, in the record's own units.

    Parameters
    ----------
    past
        The record.
    following
        What `stickslip.forecast` gave for it. Of the record the last part is drawn, as long as the forecast.
    """
    times, ahead = past.raw["t"], following["t"].to_numpy()
    part = times >= 2 * times[-1] - ahead[-1]
    names = [str(name) for name in following if name in past.raw and name != "t"]
    figure, axes = _figure(7.2, 1.4 + 1.6 * len(names), len(names), 1)
    for ax, name in zip(axes, names, strict=True):
        readings = past.raw[name]
        ax.plot(times[part], readings[part], color=MEASURED, lw=2.2, alpha=0.45, label="measured")
        joined = np.append(readings[-1], following[name])
        ax.plot(np.append(times[-1], ahead), joined, color=SIMULATED, lw=1.2, label="forecast")
        if f"{name}_low" in following:
            band = (following[f"{name}_low"], following[f"{name}_high"])
            ax.fill_between(ahead, *band, color=SIMULATED, alpha=0.18, lw=0, label="95 % of readings")
        ax.axvline(float(times[-1]), color=GREY, lw=0.8, ls=(0, (4, 3)), zorder=0)
        ax.set_ylabel(_label_of(past, name))
    axes[-1].set_xlabel(_label_of(past, "t"))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def _label_of(recording: Recording, name: str) -> str:
    """A column's symbol, with its unit unless the column is a multiple of that."""
    symbols = {"t": "time $t$", "x1": "$x_1$", "y1": "$y_1$", "spring_force": "spring force"}
    return label(symbols.get(name, name), recording.unit(name) if recording.channels[name].scale == 1 else "")


def _with_corners(run: Trajectory) -> tuple[Array, Array]:
    """Times and states of a run's samples, of transitions, where its curves have their corners, and between them."""
    change = run.transitions
    inside = (change.t >= run.t[0]) & (change.t <= run.t[-1])
    times = np.append(run.t, change.t[inside])
    order = np.argsort(times, kind="stable")
    states = np.vstack([run.state, change.state[inside]])[order]
    if not own_steps(run):
        return times[order], states
    places = [0, 2] if states.shape[1] == 4 else [0]  # of the coordinates; each has its velocity after it
    t, q, v = between(times[order], states[:, places], states[:, [i + 1 for i in places]])
    out = np.empty((len(t), states.shape[1]))
    out[:, places], out[:, [i + 1 for i in places]] = q, v
    return t, out
