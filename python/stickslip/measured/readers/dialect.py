"""How a table in text is written: the line that names its columns, the separator, a row of units, where the rows begin.

The declared names find their line. Where none are declared, the line of names is the one above the first rows of
numbers. Above it a program may have written anything.
"""

from __future__ import annotations

import csv
import re
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from stickslip.declared.units import same_unit
from stickslip.errors import InputError, Place
from stickslip.measured.heads import head_parts, unit_in
from stickslip.measured.readers.clock import is_time
from stickslip.measured.readers.encoding import encoding_of

COMMENTS = ("#", "%", "//")
SEPARATORS = ("\t", ";", ",", " ")  # " ": any white space
BLANKS = " \t\r\n\v\f"  # a no-break space is none of them: no number is read with one
EMPTY = "\t;, \"'\r\n"  # what a line of empty cells is made of
HEAD = 5000  # lines in which the names must stand
ALIKE = 3  # rows of numbers, one below the other, that are the table and no numbers of its preamble
_APART = re.compile(f"[{BLANKS}]+")


@dataclass(frozen=True)
class Layout:
    """How a table in text is written.

    Attributes
    ----------
    header
        The names of its columns.
    header_line, first, last
        Lines, from 1: of the names, from which there may be rows, and the last one; 0: the file's last.
    delimiter
        " " is any white space.
    units
        As a row below the names gives them, or the file's header; "" where there is none.
    spare
        Names at the end that may have no cell.
    decimals
        The decimal signs that its numbers may have.
    above
        Rows of numbers right above the names.
    """

    path: Path
    encoding: str
    mark: int
    header: tuple[str, ...]
    header_line: int
    first: int
    delimiter: str
    decimals: str
    units: tuple[str, ...] = ()
    spare: int = 0
    last: int = 0
    above: int = 0

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Yield the line number and the cells of each row of data."""
        with opened(self.path, self.encoding, self.mark) as stream:
            for number, line in enumerate(stream, start=1):
                if number < self.first:
                    continue
                if self.last and number > self.last:
                    return
                if text := bare(line, self.delimiter):
                    yield number, cells_of(text, self.delimiter)

    def line(self, row: int) -> int | None:
        """Return the line of a row of data, counted from 0."""
        return next((number for i, (number, _) in enumerate(self.rows()) if i == row), None)


def opened(file: Path, encoding: str, mark: int, newline: str | None = None) -> IO[str]:
    """Open a text file behind its byte-order mark."""
    stream = file.open(encoding=encoding, newline=newline)
    stream.seek(mark)
    return stream


def rows_from(layout: Layout) -> int:
    """Return the byte at which the rows begin."""
    at = layout.mark
    with opened(layout.path, layout.encoding, layout.mark, newline="") as stream:
        for _ in range(layout.first - 1):
            at += len(stream.readline().encode(layout.encoding))
    return at


def bare(line: str, delimiter: str) -> str:
    """Return a row without comment and line end; separators stay, those at its ends too: cells that are empty."""
    text = line.partition("#")[0].strip("\r\n " if delimiter == "\t" else BLANKS)
    return "" if text.lstrip().startswith(COMMENTS) else text


def cells_of(text: str, delimiter: str) -> list[str]:
    """Return the cells of a row, without the blanks around them."""
    if delimiter == " ":
        return text.split() if text.isascii() else [cell for cell in _APART.split(text) if cell]
    try:
        return [cell.strip(BLANKS) for cell in next(csv.reader([text], delimiter=delimiter))]
    except (csv.Error, StopIteration):  # a cell of more than 131,072 characters
        return [cell.strip(BLANKS) for cell in text.split(delimiter)]


def odd_blank(text: str) -> str:
    """Return the first blank of a text that is none of ASCII's, as "a no-break space (U+00A0)"; "" without one."""
    found = next((one for one in text if one > "\x7f" and one.isspace()), "")
    return found and f"a {unicodedata.name(found, 'blank').lower()} (U+{ord(found):04X})"


def number_in(cell: str, decimal: str) -> float | None:
    """Return the number in a cell with a decimal sign, None if there is none."""
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return None


def signs(delimiter: str) -> str:
    """Return the decimal signs that can stand beside a separator."""
    return "." if delimiter == "," else ".,"


def find_layout(file: Path, wanted: Sequence[str] = ()) -> Layout:
    """Return how a file is written, its line of names found by the `wanted` ones where they are given.

    Raises
    ------
    InputError
        The file is no text, is empty, or has no line of names.
    """
    encoding, mark = encoding_of(file)
    with opened(file, encoding, mark) as stream:
        lines = [line.rstrip("\n") for _, line in zip(range(HEAD), stream, strict=False)]
    if not _plain(lines):
        raise InputError("empty; it needs a line of column names and rows of numbers", place=Place(str(file)))
    at, names, delimiter = (_declared(file, lines, wanted) if wanted else None) or _guessed(file, lines)
    units, first = _units_below(lines, at, names, delimiter)
    above = _rows_above(lines[:at], names, delimiter)
    where = (at + 1, first + 1)
    return Layout(file, encoding, mark, names, *where, delimiter, signs(delimiter), units, above=above)


def _rows_above(lines: Sequence[str], names: Sequence[str], delimiter: str) -> int:
    """The number of rows of numbers that stand right above the names, at least as wide as these."""
    count = 0
    for line in reversed(lines):
        if line.strip() and _names(line, delimiter) != names:
            if not _is_row(line, delimiter) or len(cells_of(line, delimiter)) < len(names):
                break
            count += 1
    return count


def _declared(
    file: Path, lines: Sequence[str], wanted: Sequence[str]
) -> tuple[int, tuple[str, ...], str] | None:
    """The last line above the rows that has all the wanted names, with its cells and its separator.

    A note may name them too, also below the names: rows tell, which have as many cells as there are names.
    """
    found: list[tuple[int, tuple[str, ...], str]] = []
    rows = 0
    for i, line in enumerate(lines):
        as_wide = [one for one in found if _is_row(line, one[2], len(one[1]))]
        if as_wide:  # white space parts the words of a note, too
            as_wide = [one for one in as_wide if one[2] != " "] or as_wide
            _refuse_other_order(file, lines, as_wide, wanted)
            return as_wide[-1]
        if found and bare(
            line, found[-1][2]
        ):  # of another width: rows without a last cell, or one of a preamble
            rows = rows + 1 if _is_row(line, found[-1][2]) else 0
            if rows == ALIKE:
                break
        for delimiter in SEPARATORS:
            names = _names(line, delimiter)
            if names and all(_has(names, one) for one in wanted):
                found.append((i, names, delimiter))
                break
    return found[-1] if found else None


def _refuse_other_order(
    file: Path,
    lines: Sequence[str],
    found: Sequence[tuple[int, tuple[str, ...], str]],
    wanted: Sequence[str],
) -> None:
    """Refuse a line right above the rows that has the names of a plain line above it in another order."""
    last, names, _ = found[-1]
    for at, others, _ in found[:-1]:
        plain = not lines[at].lstrip().startswith(COMMENTS)
        shared = [one for one in wanted if _has(others, one)]
        if plain and _ordered(shared, others) != _ordered(shared, names):
            words = f"names the columns in another order than line {at + 1}; delete one of the two"
            raise InputError(words, place=Place(str(file), last + 1))


def _names(line: str, delimiter: str) -> tuple[str, ...]:
    """The cells of a line as names of columns; a comment mark before them is none of them."""
    text = line.strip("\r\n ")
    for mark in COMMENTS:
        if text.startswith(mark):
            text = text[len(mark) :].lstrip()
            break
    if not text or (delimiter != " " and delimiter not in text):
        return ()
    names = [name.strip().strip("\"' ") for name in cells_of(text, delimiter)]
    while names and not names[-1]:  # a separator may end the line
        names.pop()
    return tuple(names)


def _bare_names(names: Sequence[str]) -> list[str]:
    """Names without the units in them."""
    return [parts[0] if (parts := head_parts(name)) else name for name in names]


def _ordered(wanted: Sequence[str], names: Sequence[str]) -> list[str]:
    """The wanted names in the order in which a line has them."""
    told = _bare_names(names)
    return sorted(wanted, key=lambda one: names.index(one) if one in names else told.index(one))


def _has(names: Sequence[str], wanted: str) -> bool:
    return wanted in names or any((parts := head_parts(name)) and parts[0] == wanted for name in names)


def _is_row(line: str, delimiter: str, width: int = 0) -> bool:
    """Whether more than half of a line's cells are numbers or times, of as many cells as are asked for."""
    text = bare(line, delimiter)
    cells = cells_of(text, delimiter) if text else []
    if cells and not cells[-1] and len(cells) > width:
        cells = cells[:-1]
    if width and len(cells) != width:
        return False
    told = [cell for cell in cells if cell]
    numbers = sum(
        any(number_in(cell, sign) is not None for sign in signs(delimiter)) or is_time(cell) for cell in told
    )
    return 2 * numbers > len(told)


def _plain(lines: Sequence[str]) -> list[int]:
    """Lines with something in them beside marks, and no comments."""
    return [i for i, line in enumerate(lines) if line.strip(EMPTY) and not line.strip().startswith(COMMENTS)]


def _guessed(file: Path, lines: Sequence[str]) -> tuple[int, tuple[str, ...], str]:
    """The line of names where none are known: the one above the first rows, or the first line if there are none."""
    used = [i for i, line in enumerate(lines) if line.strip(EMPTY)]
    plain = _plain(lines)
    start = _first_rows(lines, plain)
    if start is None:
        delimiter = next(one for one in SEPARATORS if one in lines[plain[0]] or one == " ")
        return plain[0], _names(lines[plain[0]], delimiter), delimiter
    row, delimiter = start
    width = len(_row_cells(lines[row], delimiter))
    above = [i for i in used if i < row]
    if len(above) > 1 and _is_of_units(_names(lines[above[-1]], delimiter)):
        before = _names(lines[above[-2]], delimiter)
        above = above[:-1] if len(before) in (width, width + 1) else above
    for one in (delimiter, *SEPARATORS):
        if one == " " != delimiter:  # white space parts the words of a note, too
            above = _without_notes(lines, above, delimiter, width)
            one = delimiter if above and delimiter in lines[above[-1]] else one
        names = _names(lines[above[-1]], one) if above else ()
        if names and (len(names) == width or (one == delimiter != " " and len(names) > width)):
            lists = [(i, _names(lines[i], one), one) for i in above]
            as_wide = [other for other in lists if len(other[1]) == len(names)]
            _refuse_other_order(file, lines, as_wide, _bare_names(names))
            return above[-1], names, delimiter
    if above and _names(lines[above[-1]], delimiter) and lines[above[-1]].strip()[:1] not in "#%/":
        return above[-1], _names(lines[above[-1]], delimiter), delimiter
    words = "numbers where the column names should be; the first line must name the columns"
    raise InputError(words, place=Place(str(file), row + 1))


def _without_notes(lines: Sequence[str], above: list[int], delimiter: str, width: int) -> list[int]:
    """Lines down to the last one of as many words as a row has cells, parted as rows are; all where there is none."""
    for k in range(len(above), 0, -1):
        names = _names(lines[above[k - 1]], delimiter)
        told = [
            name for name in names if name and not any(number_in(name, sign) is not None for sign in ".,")
        ]
        if len(names) == len(set(told)) == width:
            return above[:k]
    return above


def _row_cells(line: str, delimiter: str) -> list[str]:
    cells = cells_of(bare(line, delimiter), delimiter)
    return cells[:-1] if cells and not cells[-1] else cells


def _first_rows(lines: Sequence[str], plain: Sequence[int]) -> tuple[int, str] | None:
    """The first line of the table, and its separator: rows of numbers of one width begin there."""
    for k, i in enumerate(plain):
        for delimiter in SEPARATORS:
            if delimiter != " " and delimiter not in lines[i]:
                continue
            width = len(_row_cells(lines[i], delimiter))
            below = plain[k : k + ALIKE]
            if width and all(_is_row(lines[j], delimiter, width) for j in below):
                return i, delimiter
    return None


def _is_of_units(cells: Sequence[str]) -> bool:
    """Whether cells are units, a time among them: a lone "t" or "F" may be a name too."""
    known = [unit_in(cell) for cell in cells if cell.strip()]
    return (
        bool(known)
        and None not in known
        and any(one in ("s", "ms", "us", "min", "h") for one in map(_time, known))
    )


def _time(unit: str | None) -> str | None:
    """The usual spelling of a unit of time."""
    return next((one for one in ("s", "ms", "us", "min", "h") if unit and same_unit(unit, one)), None)


def _units_below(
    lines: Sequence[str], at: int, names: Sequence[str], delimiter: str
) -> tuple[tuple[str, ...], int]:
    """The units in the row below the names, if there is one, and the first line that may be a row of numbers.

    A row of empty cells is one of units, of which there are none.
    """
    below = next((i for i in range(at + 1, len(lines)) if bare(lines[i], delimiter)), None)
    if below is None:
        return (), at + 1
    cells = [cell.strip("\"' ") for cell in cells_of(bare(lines[below], delimiter), delimiter)]
    while len(cells) > len(names) and not cells[-1]:  # a separator may end the line
        cells.pop()
    if len(cells) > len(names) or _is_row(lines[below], delimiter):
        return (), at + 1
    units = [unit_in(cell) if cell else "" for cell in cells]
    if None in units:
        return (), at + 1
    return tuple(unit or "" for unit in units) + ("",) * (len(names) - len(units)), below + 1
