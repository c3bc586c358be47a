"""A figure of matplotlib as Bokeh's, which zooms and shows values: drawn once, seen on paper and on a screen.

Taken over are lines, points, error bars, bands and filled curves, ranges that panels share, logarithmic axes, named
rows and words at the right of a row. Legends and titles become HTML, so that they wrap on a phone.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.models import (
    BoxAnnotation,
    BoxZoomTool,
    ColumnDataSource,
    FixedTicker,
    HoverTool,
    LinearAxis,
    PanTool,
    Range1d,
    ResetTool,
    Span,
    Toolbar,
    WheelZoomTool,
)
from bokeh.plotting import figure as bokeh_figure
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Annotation
from matplotlib.ticker import FixedLocator

POINTS = 4 / 3  # CSS pixels in a point
MARKERS = {".": "circle", "o": "circle", "s": "square", "D": "diamond", "x": "x", "^": "triangle"}
DASHES = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dashdot"}
LEAST, ROW = 230, 22  # pixels: height of a panel, and of a named row in it
NAMES = {"\\dot x_1": "rate of x1", "\\mathdefault": "", "\\ ": " "}


@dataclass(frozen=True)
class Key:
    """One line of a legend: its words, its colour, and whether a line or a marker stands before it."""

    words: str
    colour: str
    dash: str  # "" for a marker alone
    marker: str  # "" for a line alone


@dataclass(frozen=True)
class Interactive:
    """A figure for a page: its panels, in rows of `columns`, as one document of Bokeh's, and the legend.

    `panels` are titles, `below` what is written along their x axes; panel i goes into the element `name`-panel-i.
    `document` is JSON: a document of Bokeh's, and where `Bokeh.embed.embed_items` puts its roots.
    """

    name: str
    panels: tuple[str, ...]
    below: tuple[str, ...]
    columns: int
    legend: tuple[Key, ...]
    document: str


def interactive(figure: Figure, name: str) -> Interactive:
    """A figure of matplotlib, drawn already, for a page.

    Parameters
    ----------
    figure : Figure
        With lines, points, error bars, bands and filled curves; other artists are left out.
    name : str
        Unlike that of any other figure of the page.

    Returns
    -------
    Interactive
        The same from the same figure, whatever was made before.
    """
    ranges: dict[tuple[str, int], Range1d] = {}
    panels = [_panel(ax, ranges) for ax in figure.axes]
    spec = figure.axes[0].get_subplotspec() if figure.axes else None
    columns = spec.get_gridspec().ncols if spec is not None else 1
    titles = tuple(_title(ax) for ax in figure.axes)
    below = tuple(plain(ax.get_xlabel()) for ax in figure.axes)
    return Interactive(name, titles, below, columns, _legend(figure), _document(panels, name))


def plain(text: str) -> str:
    """Words without the marks of mathematics: "$v_w$ [m/s]" is "v_w [m/s]", "$x_1$" is "x1"."""
    for mark, words in NAMES.items():
        text = text.replace(mark, words)
    text = re.sub(r"\$([^$]*)\$", lambda found: re.sub(r"_\{?(\d+)\}?", r"\1", found[1]), text)
    return text.replace("rate of the reading, rate of x1", "rate of the x1 reading").strip()


def _document(panels: list[Any], name: str) -> str:
    """Bokeh's JSON with numbers of its own for the models, so that it does not depend on what was made before."""
    document = Document()
    for one in panels:
        document.add_root(one)
    roots = {one.id: f"{name}-panel-{i}" for i, one in enumerate(panels)}
    whole = {
        "document": document.to_json(deferred=False),
        "item": {"docid": name, "roots": roots, "root_ids": list(roots)},
    }
    raw = json.dumps(whole, allow_nan=False)
    seen: dict[str, str] = {}
    raw = re.sub(r'"p\d{4,}"', lambda one: seen.setdefault(one[0], f'"{name}-{len(seen)}"'), raw)
    return raw.replace("</", "<\\/")  # it stands in a script


def _title(ax: Axes) -> str:
    parts = [ax.get_title(loc=loc).strip() for loc in ("left", "center")]
    return plain(" · ".join(one for one in parts if one))


def _panel(ax: Axes, ranges: dict[tuple[str, int], Range1d]) -> Any:
    rows = _rows(ax)
    inches = ax.bbox.height / ax.figure.dpi
    height = max(LEAST, int(96 * inches), ROW * len(rows) + 70 if rows else 0)
    out = bokeh_figure(
        height=height,
        sizing_mode="stretch_width",
        x_axis_type=ax.get_xscale(),
        y_axis_type=ax.get_yscale(),
        x_range=_range(ax, "x", ranges),
        y_range=_range(ax, "y", ranges),
        y_axis_label=plain(ax.get_ylabel()) or None,
        tools=[],
        min_border=6,
        outline_line_color=None,
        background_fill_color=None,
        border_fill_color=None,
    )
    out.toolbar = _toolbar()
    out.toolbar_location = "above"
    out.axis.minor_tick_line_color = None
    out.grid.grid_line_alpha = 0.45
    out.axis.axis_label_text_font_style = "normal"
    out.xaxis.ticker.desired_num_ticks = 5  # room for the labels on a phone
    if rows:
        out.yaxis.ticker = FixedTicker(ticks=list(rows))
        out.yaxis.major_label_overrides = dict(rows)
    _beside(ax, out)
    for artist in sorted(ax.get_children(), key=lambda one: one.get_zorder()):
        _draw(ax, out, artist)
    out.add_tools(_hover(ax, bool(rows)))
    return out


def _toolbar() -> Toolbar:
    """Box zoom where one drags; the wheel scrolls the page until its tool is chosen."""
    box = BoxZoomTool()
    tools = [box, PanTool(), WheelZoomTool(zoom_on_axis=False), ResetTool()]
    return Toolbar(tools=tools, active_drag=box, active_scroll=None, autohide=False, logo=None)


def _range(ax: Axes, which: str, ranges: dict[tuple[str, int], Range1d]) -> Range1d:
    """The range of an axis, the same object for axes that share it."""
    group = ax.get_shared_x_axes() if which == "x" else ax.get_shared_y_axes()
    first = min(id(one) for one in group.get_siblings(ax))
    low, high = ax.get_xlim() if which == "x" else ax.get_ylim()
    return ranges.setdefault((which, first), Range1d(float(low), float(high)))


def _rows(ax: Axes) -> dict[float, str]:
    """Names of rows by their place; none where the axis has numbers."""
    if not isinstance(ax.yaxis.get_major_locator(), FixedLocator):
        return {}
    ticks = [float(y) for y in ax.get_yticks()]
    return dict(zip(ticks, ax.yaxis.get_major_formatter().format_ticks(ticks), strict=True))


def _beside(ax: Axes, out: Any) -> None:
    """Words at the right of rows, as a second axis."""
    words = {
        float(one.xy[1]): plain(one.get_text()).replace("\n", " ")
        for one in ax.texts
        if isinstance(one, Annotation) and one.xycoords == ("axes fraction", "data")
    }
    if words:
        axis = LinearAxis(ticker=FixedTicker(ticks=list(words)), major_label_overrides=words)
        axis.axis_line_color = axis.major_tick_line_color = None
        out.add_layout(axis, "right")


def _draw(ax: Axes, out: Any, artist: object) -> None:
    if isinstance(artist, Line2D):
        _line(ax, out, artist)
    elif isinstance(artist, LineCollection):
        segments = [np.asarray(one) for one in artist.get_segments() if len(one)]
        xs, ys = [one[:, 0].tolist() for one in segments], [one[:, 1].tolist() for one in segments]
        colour = _colour(artist)
        width = POINTS * float(np.atleast_1d(artist.get_linewidth())[0])
        out.multi_line(xs=xs, ys=ys, line_color=colour, line_width=width)
    elif isinstance(artist, PolyCollection):
        for path in artist.get_paths():
            corners = np.asarray(path.vertices)
            out.patch(corners[:, 0], corners[:, 1], line_color=None, **_fill(artist))
    elif isinstance(artist, Rectangle) and artist in ax.patches:
        _box(ax, out, artist)


def _colour(lines: LineCollection) -> str:
    return to_hex(tuple(np.atleast_2d(lines.get_edgecolor())[0].tolist()))


def _fill(artist: Any) -> dict[str, Any]:
    colour = np.atleast_2d(artist.get_facecolor())[0]
    return {"fill_color": to_hex(colour), "fill_alpha": float(colour[3])}


def _box(ax: Axes, out: Any, one: Rectangle) -> None:
    """A band right across the panel."""
    low, high = one.get_y(), one.get_y() + one.get_height()
    if one.get_transform() - ax.transData == ax.get_yaxis_transform() - ax.transData or one.get_width() == 1:
        out.add_layout(BoxAnnotation(bottom=low, top=high, line_color=None, level="underlay", **_fill(one)))


def _line(ax: Axes, out: Any, line: Line2D) -> None:
    x, y = (np.asarray(one, dtype=np.float64) for one in line.get_data())
    if not x.size:
        return
    in_x, in_y = line.get_transform().contains_branch_seperately(ax.transData)
    style = _line_style(line)
    if not (in_x and in_y):  # right across the panel
        place, dimension = (y[0], "width") if in_y else (x[0], "height")
        if in_x or in_y:
            level = {"level": "underlay"}
            out.add_layout(Span(location=float(place), dimension=dimension, **style, **level))
        return
    rows = _rows(ax)
    names = [plain(rows.get(float(one), "")) for one in y] if rows else []
    data: dict[str, Any] = {"x": x.astype(np.float32), "y": y.astype(np.float32)}
    source = ColumnDataSource(data | ({"row": names} if rows else {}))
    label = str(line.get_label())
    name = "" if label.startswith("_") else plain(label)
    if line.get_linestyle() not in ("None", "none", "", " "):
        out.line("x", "y", source=source, name=name or None, **style)
    marker = MARKERS.get(str(line.get_marker()))
    if marker:
        alpha = line.get_alpha() or 1.0
        face = line.get_markerfacecolor()
        size = POINTS * line.get_markersize() * (0.6 if line.get_marker() == "." else 1.0)
        hollow = str(face) == "white"
        out.scatter(
            "x", "y", source=source, marker=marker, size=max(size, 3.0), name=name or None,
            line_color=to_hex(line.get_color()) if hollow or marker == "x" else None,
            fill_color="white" if hollow else to_hex(face), fill_alpha=alpha, line_alpha=alpha,
        )  # fmt: skip


def _line_style(line: Line2D) -> dict[str, Any]:
    return {
        "line_color": to_hex(line.get_color()),
        "line_alpha": line.get_alpha() or 1.0,
        "line_width": max(POINTS * line.get_linewidth(), 1.0),
        "line_dash": _dash(line),
    }


def _dash(line: Line2D) -> Any:
    pattern = line._unscaled_dash_pattern[1]  # type: ignore[attr-defined]  # has no public reader
    if pattern is None or line.get_linestyle() == "-":
        return "solid"
    return [max(1, round(POINTS * line.get_linewidth() * one)) for one in pattern]


def _hover(ax: Axes, rows: bool) -> HoverTool:
    """Values where one points, named as the axes are."""
    x, y = _named(ax, "x"), _named(ax, "y")
    across = (("", "@row"), (x, "@x{%.4g}")) if rows else ((x, "@x{%.4g}"), (y, "@y{%.4g}"))
    formatters: Any = {"@x": "printf", "@y": "printf"}
    return HoverTool(
        visible=False,
        tooltips=[*across],
        formatters=formatters,
        line_policy="nearest",
        point_policy="snap_to_data",
    )


def _named(ax: Axes, which: str) -> str:
    """What an axis shows: its own words, or those of a panel that shares it."""
    if which == "x":
        alike, label = ax.get_shared_x_axes().get_siblings(ax), Axes.get_xlabel
    else:
        alike, label = ax.get_shared_y_axes().get_siblings(ax), Axes.get_ylabel
    return next((plain(label(one)) for one in (ax, *alike) if label(one)), which)


def _legend(figure: Figure) -> tuple[Key, ...]:
    """What colours and lines mean, each said once."""
    known: dict[str, Key] = {}
    legends = [*figure.legends, *(one for ax in figure.axes if (one := ax.get_legend()) is not None)]
    for legend in legends:
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
            if handle is not None:
                words = plain(text.get_text())
                known.setdefault(words, _key(words, handle))
    return tuple(known.values())


def _key(words: str, handle: Any) -> Key:
    if isinstance(handle, Line2D):
        style = handle.get_linestyle()
        dash = "" if style in ("None", "none", "", " ") else DASHES.get(str(style), "dashed")
        marker = MARKERS.get(str(handle.get_marker()), "")
        return Key(words, to_hex(handle.get_color()), dash, marker)
    if isinstance(handle, LineCollection):
        return Key(words, _colour(handle), "solid", "")
    colour = np.atleast_2d(handle.get_facecolor())[0] if hasattr(handle, "get_facecolor") else (0, 0, 0, 1)
    return Key(words, to_hex(colour), "", "square")


def script() -> str:
    """BokehJS, for a page that loads nothing."""
    from bokeh.resources import Resources

    return "\n".join(Resources(mode="inline", components=["bokeh"]).js_raw)
