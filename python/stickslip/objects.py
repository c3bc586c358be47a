"""What a person holds of this package: one line printed, a table in a notebook, a figure, a frame, equality by value.

`stickslip.shown.objects` says of each kind what its title and its rows are. It stands below the rooms that make the
objects, so it is named here as text and loaded when somebody looks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

DESCRIBED_BY = "stickslip.shown.objects"
REPORTED_BY = "stickslip.shown.report.write"
CONTENTS_BY = "stickslip.shown.report.contents"
WIDEST = 119  # characters of the line that an object is printed in
LISTED = 4  # members of a sequence that are printed; of a longer one how many there are


def _described(one: object) -> Any:
    return import_module(DESCRIBED_BY).describe(one)


def reporter() -> Callable[..., list[Path]]:
    """What writes the report of a `Found`."""
    write: Callable[..., list[Path]] = import_module(REPORTED_BY).write_report
    return write


def contents() -> Callable[..., dict[str, Any]]:
    """What tells all that the report of a `Found` says."""
    told: Callable[..., dict[str, Any]] = import_module(CONTENTS_BY).contents
    return told


def one_line(text: str) -> str:
    """Return what is printed of an object: one line, its middle left out where it is too long."""
    text = " ".join(text.split())
    if len(text) <= WIDEST:
        return text
    end = text[-1] if text[-1] in ">)" else ""
    return f"{text[: WIDEST - 3 - len(end)]}...{end}"


def as_call(one: Any) -> str:
    """Return the call that makes an object: what differs from what an argument is if it is left out."""
    own = [f for f in fields(one) if f.repr]
    usual = {f.name: f.default if f.default_factory is MISSING else f.default_factory() for f in own}
    given = [(f.name, getattr(one, f.name)) for f in own if not same(getattr(one, f.name), usual[f.name])]
    return one_line(f"{type(one).__name__}({', '.join(f'{name}={_brief(value)}' for name, value in given)})")


def _brief(value: object) -> str:
    if isinstance(value, list | tuple) and len(value) > LISTED:
        return f"({_brief(value[0])}, ... {len(value)} in all)"
    return repr(value)


class Displayed:
    """An object that says what it is: printed in a line, as a table in a notebook, as a data frame."""

    def __repr__(self) -> str:
        return one_line(f"<{type(self).__name__}: {_described(self).title}>")

    def _repr_html_(self) -> str:
        return str(_described(self).html())

    def to_dataframe(self) -> pd.DataFrame:
        """The object's table, or its samples: a row each; units are in `attrs`."""
        frame: pd.DataFrame = _described(self).frame()
        return frame

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return self is other or same(self, other)

    def __hash__(self) -> int:
        assert is_dataclass(self)
        plain = (getattr(self, one.name) for one in fields(self))
        return hash((type(self).__name__, *(x for x in plain if isinstance(x, str | int | float | Enum))))


class Drawn(Displayed):
    """One that can be drawn."""

    def plot(self) -> Figure:
        """Draw it.

        Returns
        -------
        matplotlib.figure.Figure
            A notebook shows it; `figure.savefig(path)` writes it.
        """
        figure: Figure = _described(self).figure()
        return figure


class Sampled(Drawn):
    """One that has samples over time, or over another variable."""

    def to_xarray(self) -> xr.Dataset:
        """The samples as a dataset over the first of them; each has its unit in its attribute `units`."""
        dataset: xr.Dataset = _described(self).dataset()
        return dataset


def same(one: object, other: object) -> bool:
    """Are two values equal, arrays element by element, NaN equal to NaN?"""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        a, b = np.asarray(one), np.asarray(other)
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")
    if type(one) is not type(other):
        return False
    if is_dataclass(one) and not isinstance(one, type):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one) if f.compare)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other) or (isinstance(one, float) and one != one and other != other)
