"""What a reader gives: the columns of a file by name, their units as the file says them, and what was guessed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import InputError, Place, did_you_mean, quoted
from stickslip.measured.heads import head_parts

Floats = NDArray[np.float64]


class Lines(Protocol):
    """What knows the line of a row of a text file."""

    def line(self, row: int) -> int | None:
        """Return the line of a row of data, counted from 0."""


@dataclass(frozen=True)
class Columns:
    """What was read of a file: some of its columns, each (n,), by name."""

    path: Path
    values: dict[str, Floats]
    layout: Lines | None = None  # None: a file that has no lines
    doubts: tuple[str, ...] = ()  # what was guessed while reading
    averaged: int = 1  # rows of the file that each number is the mean of
    turns: Mapping[str, tuple[int, int]] = field(default_factory=dict)  # of means, as `Part.turns`

    def place(self, column: str | None = None, row: int | None = None) -> Place:
        """Return the place of a column, or of a row of the file, for an error."""
        line = None if self.layout is None or row is None else self.layout.line(row)
        return Place(str(self.path), line, column=column)


@dataclass(frozen=True)
class Contents:
    """What a file holds, before its columns are read.

    Attributes
    ----------
    kind
        The format, as a person calls it.
    names
        Its columns, in its order.
    units
        The unit that the file itself gives for a column, outside the column's name.
    also
        Other names by which a column may be called, with the name it has here.
    facts
        What else is known of the file, for a person.
    doubts
        What was guessed: it becomes a finding of the recording.
    paths
        Whether names are paths: what stands before the last slash is where a column is.
    titles
        What the file calls a column elsewhere, by its name: a list of words beside a matrix.
    unnamed
        Columns that only have a place, in their order, by what holds them: those of a matrix, or a cell of vectors.
    """

    kind: str
    names: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    also: Mapping[str, str] = field(default_factory=dict)
    facts: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    paths: bool = False
    titles: Mapping[str, str] = field(default_factory=dict)
    unnamed: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def head(self, name: str) -> tuple[str, str] | None:
        """Return the name and the unit in the head of a column; None if it has no unit."""
        if name in self.titles:
            return head_parts(self.titles[name])
        return head_parts(name.rpartition("/")[2] if self.paths else name)


class Source(Protocol):
    """A file that has been looked into."""

    @property
    def contents(self) -> Contents:
        """What it holds."""

    def read(self, names: Sequence[str], units: Mapping[str, str]) -> Columns:
        """Return some of its columns; `units` are those declared, for times that are no numbers."""


def require(name: str, known: Sequence[str], place: Place) -> None:
    """Refuse the name of a column that is not there just once."""
    count = list(known).count(name)
    if count == 0:
        there = quoted(", ".join(known)) if known else "no columns"
        words = f"missing; the file has {there}; {did_you_mean(name, known)}"
        raise InputError(words.split("; it must be")[0].split("; none is known")[0], place=place)
    if count > 1:
        raise InputError(f"there {count} times; which one is meant? rename the others", place=place)


def checked(file: Path, values: dict[str, Floats]) -> Columns:
    """Return columns that are finite and equally long, of a file without lines."""
    for name, column in values.items():
        wrong = np.flatnonzero(~np.isfinite(column))
        if wrong.size:
            words = f"{column[wrong[0]]} at sample {wrong[0]}; every sample needs a finite number"
            raise InputError(words, place=Place(str(file), column=name))
    lengths = {name: column.size for name, column in values.items()}
    if len(set(lengths.values())) > 1:
        words = ", ".join(f"{name} has {size} samples" for name, size in lengths.items())
        raise InputError(f"{words}; channels must be equally long", place=Place(str(file)))
    return Columns(file, values)
