"""Binary files as sources of columns: each parsed by a kept-up library, in a process of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from stickslip.declared.units import same_dimension
from stickslip.errors import InputError, Place, quoted
from stickslip.measured.heads import head_parts, unit_in
from stickslip.measured.readers import process
from stickslip.measured.readers.columns import Columns, Contents, Floats, checked, require
from stickslip.measured.readers.memory import ratio
from stickslip.measured.readers.process import PROCESS, EndedError
from stickslip.measured.readers.titles import titles_of, unnamed
from stickslip.measured.readers.unchanged import State, state_of, unchanged


@dataclass(frozen=True)
class Format:
    """A kind of binary file.

    Attributes
    ----------
    name
        As a person calls it.
    parser
        The module of `parsers` that reads it.
    library
        What it needs besides numpy and scipy; "" for nothing.
    outline
        Says what is wrong with a file whose headers and lengths show it, before anything is parsed.
    """

    name: str
    parser: str
    library: str = ""
    outline: Callable[[Path], str | None] | None = None


@dataclass(frozen=True)
class Container:
    """A binary file as a source of columns."""

    file: Path
    format: Format

    @cached_property
    def contents(self) -> Contents:
        """What the file holds."""
        head = self._head
        units = {name: unit for name, said in head.get("units", {}).items() if (unit := _known(said))}
        titles = titles_of(head["known"], head.get("words", {}))
        return Contents(
            f"a {self.format.name} file",
            tuple(head["known"]),
            units,
            also=_also(titles) | head.get("also", {}),
            facts=tuple(head.get("facts", ())),
            doubts=tuple(head.get("doubts", ())),
            paths=head.get("paths", False),
            titles=titles,
            unnamed=unnamed(head["known"], titles),
        )

    @cached_property
    def _before(self) -> State:
        return state_of(self.file)

    @cached_property
    def _head(self) -> dict[str, Any]:
        return self._answer(())[0]

    def read(self, names: Sequence[str], units: Mapping[str, str]) -> Columns:
        """Return some of the columns, times that are no numbers in their declared unit."""
        also, titles = self.contents.also, self.contents.titles
        own = {
            name: name if name in self.contents.names else also.get(name, name)
            for name in dict.fromkeys(names)
        }
        for name in own.values():
            if name in self._head.get("words", {}):
                words = "words; a channel is a real vector of numbers"
                raise InputError(words, place=Place(str(self.file), column=name))
            known = self.contents.names
            if name not in known:  # which columns there are is said by their words, as one asks for them
                known = tuple(titles[one] if titles.get(one) in also else one for one in known)
            require(name, known, Place(str(self.file), column=name))
        head, columns = self._answer(tuple(own.values()))
        if len(columns) != len(own):  # the parser found other names than before
            raise InputError("was changed while it was read; read it again", place=Place(str(self.file)))
        values = dict(zip(own, columns, strict=True))
        for name in own:
            if own[name] in head.get("times", ()):
                values[name] = self._timed(name, values[name], units.get(name, "1"))
        return checked(self.file, values)

    def _timed(self, name: str, seconds: Floats, unit: str) -> Floats:
        place = Place(str(self.file), column=name)
        if not same_dimension(unit, "s"):
            words = f"dates or spans of time, but the channel is declared in '{unit}'; give a unit of time"
            raise InputError(words, place=place)
        return seconds * ratio("s", unit, place)

    def _answer(self, names: Sequence[str]) -> tuple[dict[str, Any], list[Floats]]:
        """What the parser's process says of the file, and the columns."""
        name, place = self.format.name, Place(str(self.file))
        with unchanged(self.file, self._before):
            if self.format.outline is not None and (wrong := self.format.outline(self.file)):
                raise InputError(wrong, place=place)
            try:
                head, columns = PROCESS.ask(self.format.parser, name, self.file, names)
            except EndedError as ended:
                raise InputError(quoted(str(ended), 180), place=place) from None
            self._refuse(head)
        return head, columns

    def _refuse(self, head: Mapping[str, Any]) -> None:
        """Say why the parser gave no columns, if it gave none."""
        name, place = self.format.name, Place(str(self.file))
        if "lacking" in head:
            words = f"a {name} file needs {self.format.library}: pip install 'stickslip[files]'"
            raise InputError(words, place=place)
        if "memory" in head:
            words = f"it needs more than {process.MEMORY / 2**30:.3g} GiB of memory; a damaged {name} file, or too long"
            raise InputError(f"{words} a record: save it in parts", place=place)
        if "damaged" in head:
            words = f"not a {name} file, or a damaged one ({quoted(head['damaged'], 150)})"
            raise InputError(words, place=place)
        if "fault" in head:
            raise InputError(quoted(head["fault"], 180), place=Place(str(self.file), column=head["column"]))


def _also(titles: Mapping[str, str]) -> dict[str, str]:
    """Columns by their titles, with the unit in one and without, where only one has it."""
    known = [*titles.items()]
    known += [(name, parts[0]) for name, title in titles.items() if (parts := head_parts(title))]
    told = [title for _, title in known]
    return {title: name for name, title in known if told.count(title) == 1}


def _known(said: str) -> str | None:
    """The unit that a file gives, if it is one; no word is no unit."""
    unit = unit_in(said) if said.strip() else None
    return None if unit == "1" else unit
