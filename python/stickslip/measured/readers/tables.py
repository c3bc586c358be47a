"""Columns of numbers from CSV and MATLAB files; what is not a number is said with its line and column."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.errors import InputError, Place, did_you_mean, quoted
from stickslip.measured.readers import matlab, memory

Floats = NDArray[np.float64]

_COMMENTS = ("#", "%", "//")


@dataclass(frozen=True)
class Columns:
    """What was read of a file: some of its columns, each (n,), by name."""

    path: Path
    values: dict[str, Floats]
    layout: Layout | None  # None: a MATLAB file, which has no lines

    def place(self, column: str | None = None, row: int | None = None) -> Place:
        """Return the place of a column, or of a row of it, for an error."""
        line = None if self.layout is None or row is None else self.layout.line(row)
        return Place(str(self.path), line, column=column)


@dataclass(frozen=True)
class Held:
    """Columns in memory, each (n,), by name; what they are called stands for a file's path."""

    called: str
    values: Mapping[str, ArrayLike]

    def __fspath__(self) -> str:
        return self.called

    def read(self, units: Mapping[str, str]) -> Columns:
        """Return some of the columns, copied, in the units given by name, as those of a file."""
        return Columns(Path(self.called), memory.read(self.called, self.values, units), None)


@dataclass(frozen=True)
class Layout:
    """How a CSV file is written."""

    path: Path
    header: tuple[str, ...]
    header_line: int  # from 1
    delimiter: str  # " ": any white space

    @property
    def decimals(self) -> str:
        """The decimal signs that its numbers may have."""
        return "." if self.delimiter == "," else ".,"

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Yield the line number and the cells of each row of data."""
        with self.path.open(encoding="utf-8-sig", newline=None) as stream:
            for number, line in enumerate(stream, start=1):
                text = line.partition("#")[0].strip()
                if number > self.header_line and text and not text.startswith(_COMMENTS):
                    yield number, _cells(text, self.delimiter)

    def line(self, row: int) -> int | None:
        """Return the line of a row of data, counted from 0."""
        return next((number for i, (number, _) in enumerate(self.rows()) if i == row), None)


def column_names(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Return the names of the columns of a CSV file, or of the variables of a .mat file.

    Raises
    ------
    InputError
        No such file, or not one that can be read.
    """
    if isinstance(path, Held):
        return tuple(path.values)
    file = _existing(path)
    if file.suffix.lower() == ".mat":
        return tuple(matlab.read(file)[0])
    return _layout(file).header


def read_columns(
    path: str | os.PathLike[str], names: Sequence[str], units: Mapping[str, str] | None = None
) -> Columns:
    """Read columns of a CSV file, or variables of a MATLAB file.

    CSV: separated by commas, semicolons, tabs or white space; where the separator is no comma, a column may have
    decimal commas. Every row has as many cells as the header has names. A byte-order mark and comment lines (#, %, //)
    before the data are passed over. The first line that is no comment names the columns; if it is numbers, the last
    comment before it does.

    Parameters
    ----------
    path
        A .mat file (version 4 to 7.2), anything else as CSV, or columns in memory.
    names
        Columns to read.
    units
        Declared unit by column, which columns in memory with a unit of their own are turned into; "1" if not given.

    Raises
    ------
    InputError
        No such file, a column missing or there twice, an empty cell, NaN or text: the line and column.
    """
    if isinstance(path, Held):
        return path.read({name: (units or {}).get(name, "1") for name in names})
    file = _existing(path)
    if file.suffix.lower() == ".mat":
        return _read_mat(file, names)
    layout = _layout(file)
    for name in names:
        _require(name, layout.header, Place(str(file), layout.header_line, column=name))
    return Columns(file, _read_csv(layout, list(dict.fromkeys(names))), layout)


def _existing(path: str | os.PathLike[str]) -> Path:
    file = Path(path)
    try:
        there = file.exists()
    except OSError as error:  # a name that is too long
        raise InputError(f"cannot be read ({error.strerror})", place=Place(str(file))) from None
    if file.is_dir():
        raise InputError("a folder, not a file", place=Place(str(file)))
    if not there:
        siblings = [one.name for one in file.parent.glob(f"*{file.suffix}")] if file.parent.is_dir() else []
        hint = f"; {did_you_mean(file.name, sorted(siblings)[:8])}" if siblings else ""
        raise InputError(f"no such file{hint}", place=Place(str(file)))
    return file


def _require(name: str, known: Sequence[str], place: Place) -> None:
    count = list(known).count(name)
    if count == 0:
        words = f"missing; the file has {quoted(', '.join(known))}; {did_you_mean(name, known)}"
        raise InputError(words.split("; it must be")[0], place=place)
    if count > 1:
        raise InputError(f"there {count} times; which one is meant? rename the others", place=place)


def _cells(text: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return text.split()
    try:
        return [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter))]
    except csv.Error:  # a cell of more than 131,072 characters, or a NUL
        return [cell.strip() for cell in text.split(delimiter)]


def _number(cell: str, decimal: str) -> float | None:
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return None


def _layout(file: Path) -> Layout:
    """Find header and separator from the first lines of a file."""
    try:
        with file.open(encoding="utf-8-sig", newline=None) as stream:
            lines = [line.rstrip("\n") for _, line in zip(range(1000), stream, strict=False)]
    except UnicodeDecodeError:
        raise InputError("not UTF-8 text; save it as CSV in UTF-8", place=Place(str(file))) from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", place=Place(str(file))) from None
    used = [(i, line.strip()) for i, line in enumerate(lines, 1) if line.strip()]
    data = [(i, line) for i, line in used if not line.startswith(_COMMENTS)]
    if not data:
        raise InputError("empty; it needs a line of column names and rows of numbers", place=Place(str(file)))
    line_number, header = data[0]
    delimiter = _delimiter(header)
    names = _cells(header, delimiter)
    if all(_number(cell, "," if delimiter != "," else ".") is not None for cell in names if cell):
        before = [(i, line) for i, line in used if i < line_number]
        comment = before[-1][1].lstrip("#%/ ") if before else ""
        named = _cells(comment, _delimiter(comment)) if comment else []
        if len(named) != len(names):
            words = "numbers where the column names should be; the first line must name the columns"
            raise InputError(words, place=Place(str(file), line_number))
        names, line_number = named, line_number - 1
    return Layout(file, tuple(name.strip("\"' ") for name in names), line_number, delimiter)


def _delimiter(header: str) -> str:
    return next((one for one in ("\t", ";", ",") if one in header), " ")


def _read_csv(layout: Layout, names: list[str]) -> dict[str, Floats]:
    """Read at full speed; if anything but finite numbers is there, read again and say where."""
    place = Place(str(layout.path), layout.header_line)
    if not _rectangular(layout):
        _raise_first_fault(layout, names)
    for decimal in layout.decimals:
        values = _parsed(layout, names, decimal)
        if values is not None:
            break
    else:
        values = _column_by_column(layout, names)
    if any(column.size == 0 for column in values.values()):
        raise InputError("no rows below the column names", place=place)
    if not all(np.isfinite(column).all() for column in values.values()):
        _raise_first_fault(layout, names)
    return values


def _parsed(layout: Layout, names: list[str], decimal: str) -> dict[str, Floats] | None:
    """The columns, all with one decimal sign; None where a cell is no such number."""
    import pandas as pd

    try:
        frame = pd.read_csv(layout.path, decimal=decimal, dtype=np.float64, **_how(layout, names))
    except (ValueError, pd.errors.ParserWarning):  # pandas' parser errors are ValueErrors
        return None
    return {name: frame[layout.header.index(name)].to_numpy(dtype=np.float64) for name in names}


def _how(layout: Layout, names: list[str]) -> dict[str, Any]:
    """What pandas is told of a file."""
    return {
        "sep": r"\s+" if layout.delimiter == " " else layout.delimiter,
        "header": None,
        "names": list(range(len(layout.header))),
        "usecols": [layout.header.index(name) for name in names],
        "skiprows": layout.header_line,
        "comment": "#",
        "encoding": "utf-8-sig",
        "index_col": False,
        "skipinitialspace": True,
        "on_bad_lines": "error",
    }


def _column_by_column(layout: Layout, names: list[str]) -> dict[str, Floats]:
    """The columns, each with a decimal sign of its own."""
    values: dict[str, Floats] = {}
    for name in names:
        tried = (_parsed(layout, [name], decimal) for decimal in layout.decimals)
        column = next((one for one in tried if one is not None), None)
        if column is None:
            _raise_first_fault(layout, names)
            words = "holds a cell that cannot be read as a number"
            raise InputError(words, place=Place(str(layout.path), column=name))
        values |= column
    return values


def _rectangular(layout: Layout) -> bool:
    """Say whether every row has as many cells as the header names columns, counted row by row."""
    width, separator = len(layout.header), layout.delimiter.encode()
    with layout.path.open("rb") as stream:
        for _ in range(layout.header_line):
            stream.readline()
        for line in stream:
            count = len(line.split()) if separator == b" " else line.count(separator) + 1
            if count == width and b'"' not in line and b"#" not in line:
                continue
            text = line.decode("utf-8", "replace").partition("#")[0].strip()
            if text and not text.startswith(_COMMENTS) and not _fits(_cells(text, layout.delimiter), width):
                return False
    return True


def _fits(cells: Sequence[str], width: int) -> bool:
    """Whether a row has as many cells as there are columns; a separator may end it."""
    return len(cells) == width or (len(cells) == width + 1 and not cells[-1])


def _raise_first_fault(layout: Layout, names: list[str]) -> None:
    """Raise the first cell that is not a finite number, or the first row that is too short or too long."""
    width = len(layout.header)
    at = {name: layout.header.index(name) for name in names}
    seen = dict.fromkeys(names, "")  # the decimal sign of each column, once it has shown one
    for row, (number, cells) in enumerate(layout.rows()):
        if not _fits(cells, width):
            count = "1 cell" if len(cells) == 1 else f"{len(cells)} cells"
            what = f"{count} where the header names {width} columns"
            if layout.delimiter == "," and len(cells) == 2 * width:
                what += "; decimal commas? separate the columns by semicolons then"
            raise InputError(what, place=Place(str(layout.path), number))
        for name, column in at.items():
            cell = cells[column]
            sign = next((one for one in layout.decimals if one in cell), "")
            fault = _cell_fault(cell, sign or ".")
            if fault is None and sign and seen[name] not in ("", sign):
                fault = f"{quoted(cell, 30)}, but above the column has the decimal sign '{seen[name]}'"
            seen[name] = seen[name] or sign
            if fault is None:
                continue
            if row == 0 and all(cell and _number(cell, sign or ".") is None for cell in cells):
                fault += ", as in the whole line; delete it (units are declared with the channels)"
            raise InputError(fault, place=Place(str(layout.path), number, column=name))


def _cell_fault(cell: str, decimal: str) -> str | None:
    if not cell:
        return "empty cell; every sample needs a number (cut the run there or interpolate)"
    value = _number(cell, decimal)
    if value is None:
        return f"'{quoted(cell, 30)}' is text; every sample needs a number"
    if not np.isfinite(value):
        return f"{quoted(cell, 30)}; every sample needs a finite number (cut the run there or interpolate)"
    return None


def _read_mat(file: Path, names: Sequence[str]) -> Columns:
    known, values = matlab.read(file, list(dict.fromkeys(names)))
    for name in names:
        _require(name, known, Place(str(file), column=name))
    for name, column in values.items():
        wrong = np.flatnonzero(~np.isfinite(column))
        if wrong.size:
            words = f"{column[wrong[0]]} at sample {wrong[0]}; every sample needs a finite number"
            raise InputError(words, place=Place(str(file), column=name))
    lengths = {name: column.size for name, column in values.items()}
    if len(set(lengths.values())) > 1:
        words = ", ".join(f"{name} has {size} samples" for name, size in lengths.items())
        raise InputError(f"{words}; channels must be equally long", place=Place(str(file)))
    return Columns(file, values, None)
