"""LabVIEW measurement files (.lvm): segments of a text table, each below a header of its own.

The format is National Instruments' "Specification for the LabVIEW Measurement File". The header says how the rows are
written, and the times where they are not written at all (`X_Columns No`: X0 and Delta_X). How many samples there are is
counted; LabVIEW's own `Samples` is often that of one packet of many.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np

from stickslip.errors import InputError, Place, quoted
from stickslip.measured.heads import unit_in
from stickslip.measured.readers.columns import Columns, Contents, Floats, require
from stickslip.measured.readers.cut_off import last_number
from stickslip.measured.readers.dialect import Layout, number_in, opened, signs
from stickslip.measured.readers.encoding import encoding_of
from stickslip.measured.readers.row_counts import count_rows
from stickslip.measured.readers.rows import read_rows
from stickslip.measured.readers.unchanged import State, state_of, unchanged

MAGIC = "LabVIEW Measurement"
END = "***End_of_Header***"
X = "X_Value"
COMMENT = "Comment"
_SPECIAL = ("***Start_Special***", "***End_Special***")
_BEGINS = ("Channels", "Notes", "Test_Name", "Test_Numbers", "Test_Series", "Samples", "Date", "Y_Unit_Label")

Header = dict[str, list[str]]


@dataclass(frozen=True)
class LvmSegment:
    """One header and the rows below it."""

    layout: Layout
    header: Mapping[str, Sequence[str]]
    times: bool  # whether the rows have an X_Value

    def of(self, key: str, column: str) -> str:
        """Return what the header says of a column."""
        cells, at = self.header.get(key, ()), self.layout.header.index(column)
        return cells[at].strip() if at < len(cells) else ""

    @property
    def names(self) -> list[str]:
        """The columns of numbers: the last one of a row holds the comments."""
        names = list(self.layout.header)
        return names[:-1] if names[-1:] == [COMMENT] else names

    @property
    def units(self) -> dict[str, str]:
        """The unit by column, where the header gives one that is known."""
        said = {name: self.of("Y_Unit_Label", name) for name in self.layout.header if not _is_x(name)}
        units = {name: unit for name, text in said.items() if (unit := unit_in(text)) and unit != "1"}
        dimension = [cell for cell in self.header.get("X_Dimension", ["", "Time"])[1:] if cell]
        if all(cell == "Time" for cell in dimension):
            units |= {name: "s" for name in self.layout.header if _is_x(name)}
        return units

    def read(self, names: Sequence[str], units: Mapping[str, str]) -> dict[str, Floats]:
        """Return columns (n,), the times counted up where the rows have none."""
        if self.times or X not in names:
            return read_rows(self.layout, names, units).values
        others = [name for name in names if name != X]
        values = read_rows(self.layout, others, units).values if others else {}
        count = count_rows(self.layout)[0] if not others else values[others[0]].size
        grids = {self._grid(name) for name in others or self._channels()}
        if len(grids) != 1:
            words = f"channels {', '.join(others or self._channels())} were sampled at different times"
            raise InputError(words, place=Place(str(self.layout.path), self.layout.header_line))
        first, step = grids.pop()
        return {**values, X: first + step * np.arange(count, dtype=np.float64)}

    def _channels(self) -> list[str]:
        return [name for name in self.names if not _is_x(name)]

    def _grid(self, name: str) -> tuple[float, float]:
        """The first time of a channel and its step."""
        found = []
        for key in ("X0", "Delta_X"):
            cell = self.of(key, name)
            value = number_in(cell, ",")
            if value is None or not np.isfinite(value):
                words = f"the rows have no times, and {key} of '{name}' is '{quoted(cell, 30)}'"
                raise InputError(words, place=Place(str(self.layout.path), column=X))
            found.append(value)
        return found[0], found[1]


def _is_x(name: str) -> bool:
    return name == X or (name.startswith(f"{X} ") and name[len(X) + 1 :].isdigit())


@dataclass(frozen=True)
class Joined:
    """Segments one after the other, as one table has lines."""

    segments: Sequence[LvmSegment]

    def line(self, row: int) -> int | None:
        """Return the line of a row, counted from 0 over all segments."""
        for one in self.segments:
            count = count_rows(one.layout)[0]
            if row < count:
                return one.layout.line(row)
            row -= count
        return None


@dataclass(frozen=True)
class Lvm:
    """A LabVIEW measurement file as a source of columns.

    Of several segments, "2/Force" is Force of the second; "Force" is that of all of them, one after the other.
    """

    file: Path

    @cached_property
    def segments(self) -> list[LvmSegment]:
        """Its segments, in order."""
        with unchanged(self.file, self._before):
            return _segments(self.file)

    @cached_property
    def _before(self) -> State:
        return state_of(self.file)

    @property
    def contents(self) -> Contents:
        """The columns of all segments."""
        segments, (first, *more) = self.segments, self.segments
        names, units = first.names, dict(first.units)
        if more:
            if any(one.layout.header != first.layout.header or one.units != units for one in more):
                names, units = [], {}
            for i, one in enumerate(segments, 1):
                names += [f"{i}/{name}" for name in one.names]
                units |= {f"{i}/{name}": unit for name, unit in one.units.items()}
        facts = (f"{len(segments)} segment{'s' * bool(more)}, names in line {first.layout.header_line}",)
        return Contents("a LabVIEW measurement file", tuple(names), units, facts=facts)

    def read(self, names: Sequence[str], units: Mapping[str, str]) -> Columns:
        """Return some of the columns, of one segment or of all joined."""
        known = self.contents.names
        for name in names:
            require(name, known, Place(str(self.file), column=name))
        chosen = self.segments
        if len(chosen) > 1 and all(name.split("/")[0].isdigit() and "/" in name for name in names):
            of = {int(name.partition("/")[0]) for name in names}
            if len(of) > 1:
                words = f"columns of segments {', '.join(map(str, sorted(of)))}; name those of one"
                raise InputError(words, place=Place(str(self.file)))
            chosen = [chosen[of.pop() - 1]]
        bare = {name: name if name in chosen[0].layout.header else name.partition("/")[2] for name in names}
        own = {bare[name]: unit for name, unit in units.items() if name in bare}
        with unchanged(self.file, self._before):
            parts = [one.read(list(bare.values()), own) for one in chosen]
            self._check_order(parts)
            values = {name: np.concatenate([part[inner] for part in parts]) for name, inner in bare.items()}
            doubts = self._doubts(chosen, len(next(iter(values.values()), ())))
            if chosen[-1] is self.segments[-1]:
                doubts += last_number(chosen[-1].layout, list(bare.values()))
        return Columns(self.file, values, Joined(chosen), doubts)

    def _check_order(self, parts: Sequence[Mapping[str, Floats]]) -> None:
        for i, (before, after) in enumerate(pairwise(parts), 2):
            if X in before and after[X][0] <= before[X][-1]:
                words = (
                    f"begins anew at {after[X][0]:g} in segment {i}; name the columns of one, like '{i}/{X}'"
                )
                raise InputError(
                    words, place=Place(str(self.file), self.segments[i - 1].layout.first, column=X)
                )

    def _doubts(self, chosen: Sequence[LvmSegment], count: int) -> tuple[str, ...]:
        told = [number_in(cell, ",") or 0 for one in chosen for cell in one.header.get("Samples", [])[1:2]]
        if count >= sum(told):
            return ()
        return (f"{count} samples where the header tells of {sum(told):g}; was the file cut off?",)


def _segments(file: Path) -> list[LvmSegment]:
    """Go through the lines once: file header, then headers, names and rows in turn."""
    encoding, mark = encoding_of(file)
    declared: Header = {}
    found: list[tuple[Header, int, list[str], int]] = []  # header, line of names, names, last line of rows
    header: Header = {}
    state, separator, number = "file", "\t", 0
    with opened(file, encoding, mark) as stream:
        for number, line in enumerate(stream, start=1):
            if number == 2 or (state == "file" and line.startswith("Separator")):
                separator = (
                    "," if line.rstrip().endswith("Comma") or ("\t" not in line and "," in line) else "\t"
                )
            cells = [cell.strip() for cell in line.rstrip("\r\n").split(separator)]
            key = cells[0]
            if state == "special":
                state = "between" if key == _SPECIAL[1] else state
            elif state == "names" and any(cells):
                found.append((header, number, _unique(cells), number))
                header, state = {}, "rows"
            elif state == "rows" and key not in (*_BEGINS, _SPECIAL[0], END):
                found[-1] = (*found[-1][:3], number)
            elif key == _SPECIAL[0]:
                state = "special"
            elif key == END:
                state = "between" if state == "file" else "names"
            elif state == "file":
                declared[key] = cells
            elif any(cells):
                if number_in(key or "0", ",") is not None:
                    raise InputError("a row of numbers outside a segment", place=Place(str(file), number))
                header[key], state = cells, "header"
    if state not in ("rows", "between") or not found:
        raise InputError("ends within a header; was the file cut off?", place=Place(str(file), number))
    style = (encoding, mark, separator, declared)
    return [_segment(file, style, *one) for one in found]


def _unique(cells: list[str]) -> list[str]:
    """Names, with those of a second and further X_Value numbered."""
    while cells and not cells[-1]:
        cells = cells[:-1]
    seen = 0
    names = []
    for cell in cells:
        seen += cell == X
        names.append(f"{X} {seen}" if cell == X and seen > 1 else cell)
    return names


def _segment(
    file: Path, style: tuple[str, int, str, Header], header: Header, line: int, names: list[str], last: int
) -> LvmSegment:
    encoding, mark, separator, declared = style
    sign = _second(declared, "Decimal_Separator")
    decimals = sign if sign in (".", ",") else signs(separator)
    layout = Layout(
        file,
        encoding,
        mark,
        tuple(names),
        line,
        line + 1,
        separator,
        decimals,
        spare=1 if names and names[-1] == COMMENT else 0,
        last=last,
    )
    return LvmSegment(layout, header, times=_second(declared, "X_Columns") != "No")


def _second(header: Mapping[str, Sequence[str]], key: str) -> str:
    return next(iter(header.get(key, ())[1:2]), "")
