"""The numbers of a table in text: at full speed, and where something is no number, again to say in which line."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stickslip.declared.units import same_dimension
from stickslip.errors import InputError, Place, quoted
from stickslip.measured.readers.clock import is_time, seconds
from stickslip.measured.readers.columns import Columns, Floats
from stickslip.measured.readers.cut_off import last_number, told_count, unended
from stickslip.measured.readers.dialect import Layout, bare, cells_of, number_in, odd_blank, opened, rows_from
from stickslip.measured.readers.filled_columns import FilledColumns, neighbours
from stickslip.measured.readers.memory import ratio
from stickslip.measured.readers.row_counts import count_rows, fits

CHUNK = 1 << 18  # rows that are parsed at once
_WRITTEN = re.compile(r"[+-]?([0-9]+[.,]?[0-9]*|[.,][0-9]+)([eE][+-]?[0-9]+)?")
How = tuple[int, int, bool]  # rows, neighbours that are averaged, whether the cells are bare


def read_rows(layout: Layout, names: Sequence[str], units: Mapping[str, str]) -> Columns:
    """Return columns (n,) by name; one declared in a unit of time may hold clock times or dates.

    Raises
    ------
    InputError
        A row has too many or too few cells, or a cell is not a finite number: the line and column.
    """
    names = list(dict.fromkeys(names))
    given = len(layout.header)
    layout, count, plain = _rectangular(layout, names)
    if not count:
        raise InputError("no rows below the column names", place=Place(str(layout.path), layout.header_line))
    values: dict[str, Floats] = {}
    k = 1 if layout.last else neighbours(count, len(names))  # segments are joined, row by row
    turns: dict[str, tuple[int, int]] = {}
    for decimal in layout.decimals:
        if (all_alike := _parsed(layout, names, decimal, (count, k, plain))) is not None:
            values, turns = all_alike.values, all_alike.turns
            break
    else:
        for name in names:
            part = _one(layout, name, names, units.get(name, "1"), (count, k, plain))
            values |= part.values
            turns |= part.turns
    for name, column in values.items():
        if not np.isfinite(column).all():
            raise_first_fault(layout, names)
            raise InputError("holds an empty cell", place=Place(str(layout.path), column=name))
    doubts = [f"each row ends before the last {given - len(layout.header)} of {given} names"]
    doubts = doubts if len(layout.header) < given else []
    if k > 1:
        doubts.append(f"{count} rows are too many to hold; {k} neighbours averaged: {count // k} samples")
    if not layout.last:  # the whole file: of one in segments its reader asks
        doubts += [*last_number(layout, names), *told_count(layout, count)]
    return Columns(layout.path, values, layout, tuple(doubts), k, turns)


def _one(layout: Layout, name: str, names: Sequence[str], unit: str, how: How) -> FilledColumns:
    """A column with a decimal sign of its own, or one of times."""
    for decimal in layout.decimals:
        if (column := _parsed(layout, [name], decimal, how)) is not None:
            return column
    at = layout.header.index(name)
    if is_time(next((cells[at] for _, cells in layout.rows() if len(cells) > at), "")):
        part = FilledColumns([name], *how[:2])
        part.add([_times(layout, name, unit)])
        return part
    raise_first_fault(layout, names)
    _raise_odd_line(layout, name)
    words = "holds a cell that cannot be read as a number"
    raise InputError(words, place=Place(str(layout.path), column=name))


def _raise_odd_line(layout: Layout, name: str) -> None:
    """Raise the first line that only a person reads: a comment among the rows, an open quotation mark, odd digits."""
    at, place = layout.header.index(name), str(layout.path)
    with opened(layout.path, layout.encoding, layout.mark) as stream:
        for number, line in enumerate(stream, start=1):
            if number < layout.first or (layout.last and number > layout.last) or not line.strip():
                continue
            if not (text := bare(line, layout.delimiter)):
                if line.lstrip().startswith("#"):
                    continue
                words = "a comment among the rows; delete it, or begin it with #"
                raise InputError(words, place=Place(place, number))
            if text.count('"') % 2:
                raise InputError("a quotation mark is opened and not closed", place=Place(place, number))
            cell = cells_of(text, layout.delimiter)[at]
            if _WRITTEN.fullmatch(cell) is None:
                words = f"'{quoted(cell, 30)}' has a character that numbers are not written with"
                raise InputError(words, place=Place(place, number, column=name))


def _times(layout: Layout, name: str, unit: str) -> Floats:
    at = layout.header.index(name)
    cells = [cells[at] for _, cells in layout.rows()]
    times, wrong = seconds(cells)
    if times is None:
        words = f"'{quoted(cells[wrong], 30)}' is no time like '{quoted(cells[0], 30)}' above"
        raise InputError(words, place=Place(str(layout.path), layout.line(wrong), column=name))
    if not same_dimension(unit, "s"):
        words = f"clock times or dates, as '{quoted(cells[0], 30)}', but the channel is declared in '{unit}'"
        raise InputError(f"{words}; give a unit of time", place=Place(str(layout.path), column=name))
    return times * ratio("s", unit, Place(str(layout.path), column=name))


def _parsed(layout: Layout, names: Sequence[str], decimal: str, how: How) -> FilledColumns | None:
    """The columns, all with one decimal sign, k neighbours averaged; None where a cell is no such number."""
    import pandas as pd

    count, k, plain = how
    places = [layout.header.index(name) for name in names]
    kept = FilledColumns(names, count, k)
    try:
        with layout.path.open("rb") as stream:
            stream.seek(rows_from(layout))  # quotation marks above would bind
            for frame in pd.read_csv(
                stream,
                sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
                decimal=decimal,
                dtype=np.float64,
                header=None,
                names=list(range(max(places) + 1)),  # the cells were counted already
                usecols=places,
                nrows=count if layout.last else None,
                comment=None if plain else "#",
                encoding=layout.encoding,
                index_col=False,
                skipinitialspace=not plain,
                on_bad_lines="error",
                chunksize=CHUNK,
            ):
                kept.add([frame[place].to_numpy(dtype=np.float64) for place in places])
    except (ValueError, pd.errors.ParserWarning):  # pandas' parser errors are ValueErrors
        return None
    if kept.rows != count:  # a quotation mark that has swallowed line ends
        words = f"{count} lines but {kept.rows} rows: a quotation mark is opened and not closed on its line"
        raise InputError(words, place=Place(str(layout.path)))
    return kept


def _rectangular(layout: Layout, names: Sequence[str]) -> tuple[Layout, int, bool]:
    """Count the cells of every row; return the layout, its spare names known, the number of rows, are they bare."""
    count, wrong, plain = count_rows(layout)
    if wrong < 0:
        return layout, count, plain
    cells = next(cells for i, (_, cells) in enumerate(layout.rows()) if i == 0)
    spare = len(layout.header) - len(cells) + (not cells[-1])
    if wrong == 0 and spare > 0 and layout.delimiter != " ":
        # all rows end early alike: the last names have no cells, as LabVIEW's "Comment"
        kept = replace(
            layout, header=layout.header[:-spare], units=layout.units[: len(layout.header) - spare]
        )
        count, short, plain = count_rows(kept)
        if short < 0 and all(name in kept.header for name in names):
            return kept, count, plain
    raise_first_fault(layout, names)
    raise InputError("rows of several lengths", place=Place(str(layout.path)))


def raise_first_fault(layout: Layout, names: Sequence[str]) -> None:
    """Raise the first cell that is not a finite number, or the first row that is too short or too long."""
    width = len(layout.header)
    at = {name: layout.header.index(name) for name in names if name in layout.header}
    seen = dict.fromkeys(at, "")  # the decimal sign of each column, once it has shown one
    rows = layout.rows()
    for row, (number, cells) in enumerate(rows):
        if not fits(cells, width - layout.spare, width):
            count = "1 cell" if len(cells) == 1 else f"{len(cells)} cells"
            what = f"{count} where the header names {width} columns"
            if layout.delimiter == "," and len(cells) == 2 * width:
                what += "; decimal commas? separate the columns by semicolons then"
            elif len(cells) < width and next(rows, None) is None and unended(layout):
                what += ", and the file ends there: cut off? delete the line"
            raise InputError(what, place=Place(str(layout.path), number))
        for name, column in at.items():
            cell = cells[column] if column < len(cells) else ""
            sign = next((one for one in layout.decimals if one in cell), "")
            fault = _cell_fault(cell, sign or layout.decimals[0])
            if fault is None and sign and seen[name] not in ("", sign):
                fault = f"{quoted(cell, 30)}, but above the column has the decimal sign '{seen[name]}'"
            seen[name] = seen[name] or sign
            if fault is None:
                continue
            if row == 0 and all(cell and number_in(cell, sign or ".") is None for cell in cells):
                fault += ", as in the whole line; delete it (units are declared with the channels)"
            raise InputError(fault, place=Place(str(layout.path), number, column=name))


def _cell_fault(cell: str, decimal: str) -> str | None:
    if not cell:
        return "empty cell; every sample needs a number (cut the run there or interpolate)"
    if blank := odd_blank(cell):
        return f"'{quoted(cell, 30)}' has {blank}; write numbers without blanks, thousands too"
    value = number_in(cell, decimal)
    if value is None:
        return f"'{quoted(cell, 30)}' is text; every sample needs a number"
    if not np.isfinite(value):
        return f"{quoted(cell, 30)}; every sample needs a finite number (cut the run there or interpolate)"
    return None
