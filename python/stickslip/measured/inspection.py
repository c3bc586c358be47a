"""What is in a file, before anything is declared: its columns, their units, ranges and rates, and what is doubtful."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip.declared.units import same_dimension
from stickslip.errors import InputError
from stickslip.measured.findings import channel_findings, time_findings
from stickslip.measured.readers.columns import Contents, Floats, Source
from stickslip.measured.readers.tables import open_table
from stickslip.measured.readers.text import Text
from stickslip.measured.readers.unchanged import ChangedError
from stickslip.measured.signals import check_time_base

TIMES = ("t", "time", "zeit", "x_value", "temps", "tiempo", "seconds", "timestamp", "datetime")


@dataclass(frozen=True)
class Column:
    """One column of a file.

    Attributes
    ----------
    name, head
        What it is called, with its unit and without.
    unit
        As the file says; None if it does not.
    values
        Its numbers (n,), those of clock times and dates in seconds since the first; None if it has none.
    doubt
        Why it has no numbers, in words; "" for a column of words.
    """

    name: str
    head: str
    unit: str | None
    values: Floats | None
    doubt: str = ""


@dataclass(frozen=True)
class Inspection:
    """What a file holds."""

    path: Path
    contents: Contents
    columns: tuple[Column, ...]
    time: Column | None
    doubts: tuple[str, ...]

    @property
    def rate(self) -> float | None:
        """Samples in one unit of the time column; None without times."""
        if self.time is None or self.time.values is None:
            return None
        return 1 / check_time_base(self.time.values).dt

    def column(self, name: str) -> Column | None:
        """Return a column by its name or its head."""
        return next((one for one in self.columns if name in (one.name, one.head)), None)


def inspect(path: str | os.PathLike[str]) -> Inspection:
    """Look at every column of a file.

    Raises
    ------
    InputError
        The file cannot be read at all; a column that cannot is a doubt.
    """
    source = open_table(path)
    contents = source.contents
    unique = [name for name in dict.fromkeys(contents.names) if contents.names.count(name) == 1]
    columns, doubts = _read(source, unique)
    doubts += [
        f"{name}: there {contents.names.count(name)} times" for name in set(contents.names) - set(unique)
    ]
    time = _time_of(columns)
    doubts += [f"{one.name}: {one.doubt}" for one in columns if one.doubt]
    doubts += _odd(columns, time)
    return Inspection(Path(path), contents, tuple(columns), time, (*contents.doubts, *doubts))


def _read(source: Source, names: list[str]) -> tuple[list[Column], list[str]]:
    """The columns, all at once where that goes, else one by one to find which of them cannot be read."""
    contents, seconds = source.contents, dict.fromkeys(names, "s")
    try:
        read = source.read(names, seconds)
    except ChangedError:
        raise
    except InputError:
        parts = [_column(source, name) for name in names]
        return parts, []
    return [_described(contents, name, read.values[name]) for name in names], list(read.doubts)


def _column(source: Source, name: str) -> Column:
    try:
        return _described(source.contents, name, source.read([name], {name: "s"}).values[name])
    except InputError as error:
        if isinstance(source, Text) and source.is_words(name):
            return _described(source.contents, name, None)
        where = "" if error.place is None or error.place.line is None else f"line {error.place.line}: "
        return _described(source.contents, name, None, where + error.what)


def _described(contents: Contents, name: str, values: Floats | None, doubt: str = "") -> Column:
    parts = contents.head(name)
    unit = contents.units.get(name) or (parts[1] if parts else None)
    return Column(name, parts[0] if parts else contents.titles.get(name, name), unit, values, doubt)


def _time_of(columns: list[Column]) -> Column | None:
    """The column of times: one that increases throughout, by its unit, its name or its place."""
    rising = [one for one in columns if one.values is not None and one.values.size > 1]
    rising = [one for one in rising if one.values is not None and bool(np.all(np.diff(one.values) > 0))]
    by_unit = [one for one in rising if one.unit is not None and same_dimension(one.unit, "s")]
    by_name = [one for one in rising if one.head.rpartition("/")[2].lower() in TIMES]
    unknown = [one for one in rising if one.unit is None]
    return next(iter([*(one for one in by_unit if one in by_name), *by_unit, *by_name, *unknown]), None)


def _odd(columns: list[Column], time: Column | None) -> list[str]:
    """What is odd about the numbers, as a recording would say it."""
    if time is None or time.values is None:
        return ["no column of times: none increases throughout"]
    found = time_findings(time.values, time.unit or "")
    jumps = np.array([i for one in found for i in one.samples], dtype=np.intp)
    for one in columns:
        if one is not time and one.values is not None and one.values.size == time.values.size:
            found += channel_findings(one.name, one.values, one.unit or "", None, jumps)
    return [" ".join(one.message.split()) for one in found]
