"""Columns in memory: arrays, dates, quantities; each turned into numbers of its declared unit, or refused."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.declared.formula.dimension import registry
from stickslip.declared.units import in_si
from stickslip.errors import InputError, Place

Floats = NDArray[np.float64]


def plain(values: ArrayLike, unit: str, place: Place) -> Floats:
    """Return a column (n,) as numbers of its declared unit, copied.

    Dates become the time since the first one, spans of time are converted, and so are numbers with a unit of their
    own (of pint, or in `attrs["units"]` as xarray and pandas keep it).

    Raises
    ------
    InputError
        The column is masked somewhere, complex, of another unit's dimension, or no numbers at all.
    """
    if (own := getattr(values, "units", None)) is not None and hasattr(values, "magnitude"):
        return plain(values.magnitude, unit, place) * ratio(str(own), unit, place)
    if own := _declared(values, place.column):
        return _column(values, place, unit) * ratio(own, unit, place)
    return _column(values, place, unit)


def _declared(values: object, column: str | None) -> str:
    """The unit in a column's attributes; those of a data frame, by its columns' names, are attributes of each."""
    said = getattr(values, "attrs", None)
    own = said.get("units") if isinstance(said, Mapping) else None
    if isinstance(own, Mapping):
        own = own.get(column)
    return "dimensionless" if own == "1" else str(own or "")


def _column(values: ArrayLike, place: Place, unit: str) -> Floats:
    masked = np.ma.getmaskarray(values) if isinstance(values, np.ma.MaskedArray) else np.zeros(0, dtype=bool)
    if masked.any():
        at = int(np.flatnonzero(masked)[0])
        words = f"masked at sample {at} (counted from 0); cut it out or fill it in"
        raise InputError(words, place=place)
    array = _dates(np.asarray(_naive(values)))
    if array.dtype.kind in "mM":
        return _times(array, unit, place)
    if array.dtype.kind == "c":
        raise InputError("complex numbers; give the part that was measured", place=place)
    try:
        return np.array(array, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("not numbers", place=place) from None


def _naive(values: Any) -> Any:
    """Dates with a time zone, as pandas keeps them, in universal time."""
    if getattr(values, "dtype", None) is not None and getattr(values.dtype, "tz", None) is not None:
        import pandas as pd

        return pd.Series(values).dt.tz_convert("UTC").dt.tz_localize(None).to_numpy()
    return values


def _dates(array: NDArray[Any]) -> NDArray[Any]:
    """Python's own dates and spans of time as numpy's."""
    first = array.flat[0] if array.dtype.kind == "O" and array.size else None
    if isinstance(first, dt.datetime):
        own = [x.astimezone(dt.UTC).replace(tzinfo=None) if x.tzinfo else x for x in array.flat]
        return np.array(own, dtype="datetime64[ns]")
    if isinstance(first, dt.timedelta):
        return np.array(list(array.flat), dtype="timedelta64[ns]")
    return array


def _times(array: NDArray[Any], unit: str, place: Place) -> Floats:
    """Dates or spans of time in a unit of time."""
    if np.isnat(array).any():
        at = int(np.flatnonzero(np.isnat(array))[0])
        raise InputError(f"no time at sample {at} (counted from 0); cut it out or fill it in", place=place)
    if unit == "1":
        raise InputError(
            "dates or spans of time, but the channel is nondimensional; give its unit", place=place
        )
    since = array - array[0] if array.dtype.kind == "M" and array.size else array
    return since.astype("timedelta64[ns]").astype(np.float64) * 1e-9 * ratio("s", unit, place)


def ratio(own: str, unit: str, place: Place) -> float:
    """What 1 of a column's own unit is in its declared one."""
    declared = "dimensionless" if unit == "1" else unit
    try:
        known = str(registry().Unit(declared))
        return in_si(own, known, what=f"declared in '{unit}'") if own != declared else 1.0
    except InputError:
        raise InputError(f"is in '{own}', but its channel is declared in '{unit}'", place=place) from None


def read(called: str, held: Mapping[str, ArrayLike], units: Mapping[str, str]) -> dict[str, Floats]:
    """Return columns (n,) by name, each in its declared unit.

    Raises
    ------
    InputError
        A column is missing, is no column of finite numbers, or they differ in length.
    """
    out: dict[str, Floats] = {}
    for name, unit in units.items():
        place = Place(called, column=name)
        if name not in held:
            raise InputError(f"missing; there are {', '.join(map(str, held))}", place=place)
        values = plain(held[name], unit, place)
        if values.ndim != 1:
            raise InputError(f"has {values.ndim} dimensions; a column has 1", place=place)
        first = next(iter(out), name)
        if out and values.size != out[first].size:
            words = f"{values.size} numbers, but column '{first}' has {out[first].size}"
            raise InputError(words, place=place)
        wrong = np.flatnonzero(~np.isfinite(values))
        if wrong.size:
            words = f"{values[wrong[0]]} at sample {wrong[0]} (counted from 0); cut it out or fill it in"
            raise InputError(words, place=place)
        out[name] = values
    return out
