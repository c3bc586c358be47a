"""Tables in text as a source of columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path

from stickslip.errors import Place
from stickslip.measured.readers.clock import is_time
from stickslip.measured.readers.columns import Columns, Contents, require
from stickslip.measured.readers.dialect import HEAD, Layout, find_layout, number_in
from stickslip.measured.readers.rows import read_rows
from stickslip.measured.readers.unchanged import State, state_of, unchanged

_SEPARATOR = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "white space"}


@dataclass(frozen=True)
class Text:
    """A table in text, found by the names that are wanted of it."""

    file: Path
    wanted: tuple[str, ...] = ()

    @cached_property
    def layout(self) -> Layout:
        """How it is written."""
        with unchanged(self.file, self._before):
            return find_layout(self.file, self.wanted)

    @cached_property
    def _before(self) -> State:
        return state_of(self.file)

    @property
    def contents(self) -> Contents:
        """Its names and the units of a row below them."""
        layout = self.layout
        units = {name: unit for name, unit in zip(layout.header, layout.units, strict=False) if unit}
        facts = [f"text in {layout.encoding.upper()}"]
        facts.append(f"columns between {_SEPARATOR[layout.delimiter]}, named in line {layout.header_line}")
        if layout.encoding == "latin-1":
            facts.append("the encoding is guessed: the bytes are not UTF-8")
        rows = "a row" if layout.above == 1 else f"{layout.above} rows"
        words = f"{rows} of numbers above the names, in line {layout.header_line}, left out"
        doubts = [words] * (layout.above > 0)
        return Contents("a table in text", layout.header, units, facts=tuple(facts), doubts=tuple(doubts))

    def is_words(self, name: str) -> bool:
        """Whether a column holds words, as that of comments does: none of its first cells is a number or a time."""
        layout = self.layout
        at = layout.header.index(name)
        with unchanged(self.file, self._before):
            told = [cells[at] for _, cells in islice(layout.rows(), HEAD) if len(cells) > at and cells[at]]
        return not any(
            is_time(cell)
            or any(number_in("".join(cell.split()), sign) is not None for sign in layout.decimals)
            for cell in told
        )

    def read(self, names: Sequence[str], units: Mapping[str, str]) -> Columns:
        """Return some of the columns, the line of each row known."""
        layout = self.layout
        for name in names:
            require(name, layout.header, Place(str(self.file), layout.header_line, column=name))
        with unchanged(self.file, self._before):
            return read_rows(layout, names, units)
