"""The columns of any file that can be read; its content chooses the format, its name where that says nothing."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from numpy.typing import ArrayLike

from stickslip.errors import InputError, Place, did_you_mean
from stickslip.measured.readers import memory
from stickslip.measured.readers.columns import Columns, Contents, Source
from stickslip.measured.readers.container import Container, Format
from stickslip.measured.readers.formats import LVM, kind_of
from stickslip.measured.readers.lvm import Lvm
from stickslip.measured.readers.text import Text

__all__ = ["Columns", "Contents", "Held", "Source", "column_names", "open_table", "read_columns"]


@dataclass(frozen=True)
class Held:
    """Columns in memory, each (n,), by name; what they are called stands for a file's path."""

    called: str
    values: Mapping[str, ArrayLike]

    def __fspath__(self) -> str:
        return self.called

    @property
    def contents(self) -> Contents:
        """Their names."""
        return Contents("columns in memory", tuple(self.values))

    def read(self, names: Sequence[str], units: Mapping[str, str]) -> Columns:
        """Return some of the columns, copied, in the units given by name, as those of a file."""
        asked = {name: units.get(name, "1") for name in names}
        return Columns(Path(self.called), memory.read(self.called, self.values, asked))


def open_table(path: str | os.PathLike[str], wanted: Sequence[str] = ()) -> Source:
    """Look into a file.

    Parameters
    ----------
    path
        The file, or columns in memory.
    wanted
        Names of columns that will be asked for: they find their line in a table in text.

    Raises
    ------
    InputError
        No such file, or not one that can be read.
    """
    if isinstance(path, Held):
        return path
    file = _existing(path)
    kind = kind_of(file)
    if isinstance(kind, Format):
        return Container(file, kind)
    return Lvm(file) if kind == LVM else Text(file, tuple(wanted))


def column_names(path: str | os.PathLike[str], wanted: Sequence[str] = ()) -> tuple[str, ...]:
    """Return the names of the columns of a file.

    Raises
    ------
    InputError
        No such file, or not one that can be read.
    """
    return open_table(path, wanted).contents.names


def read_columns(
    path: str | os.PathLike[str], names: Sequence[str], units: Mapping[str, str] | None = None
) -> Columns:
    """Read columns of a file, by the names it has for them.

    Parameters
    ----------
    path
        The file, or columns in memory.
    names
        Columns to read.
    units
        Declared unit by column, which times and columns in memory with a unit of their own are turned into; "1" if
        not given.

    Raises
    ------
    InputError
        No such file, a column missing or there twice, an empty cell, NaN or text: the line and column.
    """
    return open_table(path, names).read(names, units or {})


def _existing(path: str | os.PathLike[str]) -> Path:
    file = Path(path)
    try:
        there = file.exists()
    except OSError as error:  # a name that is too long
        raise InputError(f"cannot be read ({error.strerror})", place=Place(str(file))) from None
    if file.is_dir():
        raise InputError("a folder, not a file", place=Place(str(file)))
    if not there:
        if file.is_symlink():
            raise InputError("a link that leads to no file", place=Place(str(file)))
        siblings = [one.name for one in file.parent.glob(f"*{file.suffix}")] if file.parent.is_dir() else []
        hint = f"; {did_you_mean(file.name, sorted(siblings)[:8])}" if siblings else ""
        raise InputError(f"no such file{hint}", place=Place(str(file)))
    if not file.is_file():  # a pipe would be waited for, a device never ends
        raise InputError("no file on a disk; save the recording as one", place=Place(str(file)))
    return file
