"""Columns of numbers from CSV and MATLAB files; what is not a number is said with its line and column."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.errors import InputError, Place, did_you_mean, quoted

Floats = NDArray[np.float64]

_COMMENTS = ("#", "%", "//")
_DECIMAL_COMMA = re.compile(r"\d,\d")


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

    def read(self, names: Sequence[str]) -> Columns:
        """Return some of the columns, copied, as those of a file."""
        out: dict[str, Floats] = {}
        for name in dict.fromkeys(names):
            place = Place(self.called, column=name)
            if name not in self.values:
                raise InputError(f"missing; there are {', '.join(map(str, self.values))}", place=place)
            try:
                values = np.array(self.values[name], dtype=np.float64)
            except (TypeError, ValueError):
                raise InputError("not numbers", place=place) from None
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
        return Columns(Path(self.called), out, None)


@dataclass(frozen=True)
class Layout:
    """How a CSV file is written."""

    path: Path
    header: tuple[str, ...]
    header_line: int  # from 1
    delimiter: str  # " ": any white space
    decimal: str

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
        return tuple(name for name, _, _ in _whosmat(file))
    return _layout(file).header


def read_columns(path: str | os.PathLike[str], names: Sequence[str]) -> Columns:
    """Read columns of a CSV file, or variables of a MATLAB file.

    CSV: separated by commas, semicolons, tabs or white space; a decimal comma where the separator is another;
    a byte-order mark and comment lines (#, %, //) before the data are passed over. The first line that is no
    comment names the columns; if it is numbers, the last comment before it does.

    Parameters
    ----------
    path
        A .mat file (version 4 to 7.2), anything else as CSV, or columns in memory.
    names
        Columns to read.

    Raises
    ------
    InputError
        No such file, a column missing or there twice, an empty cell, NaN or text: the line and column.
    """
    if isinstance(path, Held):
        return path.read(names)
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
    """Find header, separator and decimal sign from the first lines of a file."""
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
    below = [line for _, line in data[1:20]] or [header]
    decimal = "," if delimiter != "," and any(_DECIMAL_COMMA.search(line) for line in below) else "."
    names = _cells(header, delimiter)
    if all(_number(cell, decimal) is not None for cell in names if cell):
        before = [(i, line) for i, line in used if i < line_number]
        comment = before[-1][1].lstrip("#%/ ") if before else ""
        named = _cells(comment, _delimiter(comment)) if comment else []
        if len(named) != len(names):
            words = "numbers where the column names should be; the first line must name the columns"
            raise InputError(words, place=Place(str(file), line_number))
        names, line_number = named, line_number - 1
    return Layout(file, tuple(name.strip("\"' ") for name in names), line_number, delimiter, decimal)


def _delimiter(header: str) -> str:
    return next((one for one in ("\t", ";", ",") if one in header), " ")


def _read_csv(layout: Layout, names: list[str]) -> dict[str, Floats]:
    """Read at full speed; if anything but finite numbers is there, read again and say where."""
    import pandas as pd

    try:
        frame = pd.read_csv(
            layout.path,
            sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
            decimal=layout.decimal,
            header=None,
            names=list(range(len(layout.header))),
            usecols=[layout.header.index(name) for name in names],
            skiprows=layout.header_line,
            comment="#",
            encoding="utf-8-sig",
            dtype=np.float64,
            index_col=False,
            skipinitialspace=True,
            on_bad_lines="error",
        )
        values = {name: frame[layout.header.index(name)].to_numpy(dtype=np.float64) for name in names}
    except (ValueError, pd.errors.ParserWarning) as error:  # pandas' parser errors are ValueErrors
        _raise_first_fault(layout, names)
        raise InputError(f"cannot be read: {error}", place=Place(str(layout.path))) from None
    sound = all(np.isfinite(column).all() for column in values.values())
    if not (sound and _rectangular(layout, values[names[0]].size)):
        _raise_first_fault(layout, names)
    if any(column.size == 0 for column in values.values()):
        raise InputError("no rows below the column names", place=Place(str(layout.path), layout.header_line))
    return values


def _rectangular(layout: Layout, rows: int) -> bool:
    """Say whether the separators add up; pandas passes over surplus cells of single rows."""
    if layout.delimiter == " ":
        return True
    with layout.path.open("rb") as stream:
        for _ in range(layout.header_line):
            stream.readline()
        separator = layout.delimiter.encode()
        count = sum(block.count(separator) for block in iter(lambda: stream.read(1 << 22), b""))
    return count == rows * (len(layout.header) - 1)


def _raise_first_fault(layout: Layout, names: list[str]) -> None:
    """Raise the first cell that is not a finite number, or the first row that is too short or too long."""
    width = len(layout.header)
    at = {name: layout.header.index(name) for name in names}
    for row, (number, cells) in enumerate(layout.rows()):
        if len(cells) != width and not (len(cells) == width + 1 and not cells[-1]):
            count = "1 cell" if len(cells) == 1 else f"{len(cells)} cells"
            what = f"{count} where the header names {width} columns"
            if layout.delimiter == "," and len(cells) == 2 * width:
                what += "; decimal commas? separate the columns by semicolons then"
            raise InputError(what, place=Place(str(layout.path), number))
        for name, column in at.items():
            fault = _cell_fault(cells[column], layout.decimal)
            if fault is None:
                continue
            if row == 0 and all(cell and _number(cell, layout.decimal) is None for cell in cells):
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


def _whosmat(file: Path) -> list[tuple[str, tuple[int, ...], str]]:
    from scipy.io import whosmat
    from scipy.io.matlab import MatReadError

    try:
        return list(whosmat(str(file)))
    except NotImplementedError:
        words = "a MATLAB 7.3 file; save it with -v7"
    except (ValueError, TypeError, MatReadError, OSError) as error:
        words = f"not a MATLAB file ({str(error).splitlines()[0]})"
    raise InputError(words, place=Place(str(file)))


def _read_mat(file: Path, names: Sequence[str]) -> Columns:
    from scipy.io import loadmat

    known = [name for name, _, _ in _whosmat(file)]
    for name in names:
        _require(name, known, Place(str(file), column=name))
    found = loadmat(str(file), variable_names=list(names))
    values: dict[str, Floats] = {}
    for name in names:
        array = np.asarray(found[name])
        if array.dtype.kind not in "iufb" or array.ndim > 2 or max(array.shape) != array.size:
            words = f"a {array.dtype.name} array of shape {array.shape}; a channel is a real vector"
            raise InputError(words, place=Place(str(file), column=name))
        column = np.ascontiguousarray(array.ravel(), dtype=np.float64)
        wrong = np.flatnonzero(~np.isfinite(column))
        if wrong.size:
            words = f"{column[wrong[0]]} at sample {wrong[0]}; every sample needs a finite number"
            raise InputError(words, place=Place(str(file), column=name))
        values[name] = column
    lengths = {name: column.size for name, column in values.items()}
    if len(set(lengths.values())) > 1:
        words = ", ".join(f"{name} has {size} samples" for name, size in lengths.items())
        raise InputError(f"{words}; channels must be equally long", place=Place(str(file)))
    return Columns(file, values, None)
