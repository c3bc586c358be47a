"""A title, a table, samples and a drawing: what every object of the package is shown by."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import singledispatch
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from markupsafe import Markup, escape
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.declared.scale import to_digits
from stickslip.errors import StickslipError
from stickslip.shown.plot.curves import STYLE
from stickslip.shown.plot.drawing import Drawing

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

MOST_ROWS = 30  # of a table in a notebook
PORTRAIT = (3.2, 2.1)  # inches
DENSITY = 160  # dots an inch


@dataclass(frozen=True)
class Span:
    """A 95 % interval; a side is None where it is open."""

    low: float | None
    high: float | None

    def __str__(self) -> str:
        if self.low is None or self.high is None:
            if self.low == self.high:
                return "–"
            return f"below {self.high:.4g}" if self.low is None else f"above {self.low:.4g}"
        half = abs(self.high - self.low) / 2
        return f"{to_digits(self.low, half)} … {to_digits(self.high, half)}"


Cell = str | bool | int | float | Span | None


@dataclass(frozen=True)
class ShownSamples:
    """Columns (n,) over the first of them, and the unit of each; "" is not known, "1" a pure number."""

    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class Description:
    """What is shown of an object.

    Attributes
    ----------
    title : one line.
    heads, rows : a table.
    notes : sentences below it.
    samples : the object's own columns, for frames and datasets.
    draw : draws a portrait.
    large : makes the figure of `plot`; the portrait, larger, if absent.
    """

    title: str
    heads: Sequence[str] = ("quantity", "value", "unit")
    rows: Sequence[Sequence[Cell]] = ()
    notes: Sequence[str] = ()
    samples: ShownSamples | None = None
    draw: Callable[[Axes], None] | None = None
    large: Callable[[], Figure] | None = None

    def html(self) -> Markup:
        """The title, the table, the portrait and the notes for a notebook; nothing of it runs or is fetched."""
        parts = [Markup('<div style="font-weight:600;margin-bottom:4px">{}</div>').format(self.title)]
        table = self._table() if self.rows else Markup()
        body = Markup('<div style="display:flex;flex-wrap:wrap;gap:16px;align-items:flex-start">{}{}</div>')
        parts.append(body.format(table, self._portrait()))
        line = Markup('<div style="opacity:.75;font-size:smaller;max-width:60em">{}</div>')
        parts += [line.format(note) for note in self.notes]
        return Markup('<div class="stickslip" style="padding:4px 0">{}</div>').format(Markup().join(parts))

    def frame(self) -> pd.DataFrame:
        """The samples, or else the table, an interval as two columns."""
        import pandas as pd  # slow to import

        if self.samples is not None:
            frame = pd.DataFrame(dict(self.samples.columns))
            frame.attrs["units"] = {name: unit for name, unit in self.samples.units.items() if unit}
            return frame
        columns: dict[str, list[Cell]] = {}
        for k, head in enumerate(self.heads):
            cells = [row[k] for row in self.rows]
            if any(isinstance(one, Span) for one in cells):
                columns["low"] = [one.low if isinstance(one, Span) else None for one in cells]
                columns["high"] = [one.high if isinstance(one, Span) else None for one in cells]
            else:
                columns[head] = cells
        return pd.DataFrame(columns)

    def dataset(self) -> xr.Dataset:
        """The samples over the first of them."""
        import xarray as xr  # slow to import

        assert self.samples is not None
        along, *names = self.samples.columns
        units = self.samples.units
        data = {name: (along, self.samples.columns[name], _unit(units, name)) for name in names}
        coordinate = (along, self.samples.columns[along], _unit(units, along))
        return xr.Dataset(data, coords={along: coordinate}, attrs={"title": self.title})

    def figure(self) -> Figure:
        """What `plot` returns."""
        with mpl.rc_context(STYLE):
            if self.large is not None:
                return self.large()
            if self.draw is None:
                raise StickslipError(f"nothing can be drawn of this: {self.title}")
            figure = Drawing(figsize=(6.0, 3.9), layout="constrained")
            self.draw(figure.subplots())
        return figure

    def _table(self) -> Markup:
        kept = self.rows[:MOST_ROWS]
        used = [k for k in range(len(self.heads)) if any(row[k] not in (None, "") for row in kept)]
        head = Markup().join(
            Markup('<th style="text-align:{};padding:1px 8px">{}</th>').format(self._side(k), self.heads[k])
            for k in used
        )
        lines = []
        for row in kept:
            cells = Markup().join(
                Markup('<td style="text-align:{};padding:1px 8px">{}</td>').format(
                    self._side(k), self._cell(row, k)
                )
                for k in used
            )
            lines.append(Markup("<tr>{}</tr>").format(cells))
        if len(self.rows) > len(kept):
            more = Markup('<tr><td colspan="{}">… and {} more</td></tr>')
            lines.append(more.format(len(used), len(self.rows) - len(kept)))
        return Markup("<table><thead><tr>{}</tr></thead><tbody>{}</tbody></table>").format(
            head, Markup().join(lines)
        )

    def _side(self, k: int) -> str:
        numbers = all(isinstance(row[k], float | int | Span | None) for row in self.rows)
        return "right" if numbers and k else "left"

    def _cell(self, row: Sequence[Cell], k: int) -> str:
        """A cell as text; a value has the digits that its interval leaves it."""
        one = row[k]
        if one is None:
            return "–" if self._side(k) == "right" else ""
        if isinstance(one, float) and math.isfinite(one):
            span = next((cell for cell in row if isinstance(cell, Span)), None)
            sides = [] if span is None else [abs(x - one) for x in (span.low, span.high) if x is not None]
            return to_digits(one, float(np.mean(sides)) if sides and self.heads[k] == "value" else None)
        if isinstance(one, bool):
            return "yes" if one else "no"
        return str(one)

    def _portrait(self) -> Markup:
        if self.draw is None:
            return Markup()
        stream = io.BytesIO()
        with mpl.rc_context({**STYLE, "font.size": 7.0, "axes.labelsize": 7.5, "legend.fontsize": 6.5}):
            figure = Figure(figsize=PORTRAIT, layout="constrained")
            axes = figure.subplots()
            axes.locator_params(nbins=4)
            self.draw(axes)
            figure.savefig(stream, format="png", dpi=DENSITY)
        style = "background:#fff;border-radius:4px"
        data = base64.b64encode(stream.getvalue()).decode()
        size = Markup('<img alt="{}" width="{}" style="{}" src="data:image/png;base64,{}">')
        return size.format(escape(self.title), round(96 * PORTRAIT[0]), style, data)


def _unit(units: Mapping[str, str], name: str) -> dict[str, str]:
    return {"units": units[name]} if units.get(name) else {}


@singledispatch
def describe(one: object) -> Description:
    """Describe an object; of a kind that nothing else describes, its fields."""
    assert is_dataclass(one)
    rows: list[tuple[Cell, ...]] = []
    for field in fields(one):
        value = getattr(one, field.name)
        if isinstance(value, str | bool | int | float) and value != "":
            rows.append((field.name, value))
    called = next((str(value) for name, value in rows if name in ("name", "column")), "")
    title = f"{type(one).__name__} {called}".strip()
    return Description(title=title, heads=("field", "value"), rows=rows)
