"""A file that something writes to while it is read is refused: its first lines and its rows may not belong together."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stickslip.errors import InputError, Place

State = tuple[int, int, int] | None


class ChangedError(InputError):
    """A file was changed while it was read: nothing else that is said of it counts."""


def state_of(file: Path) -> State:
    """Return what differs once a file is written to or replaced; None: it is gone."""
    try:
        status = os.stat(file)
    except OSError:
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns


@contextmanager
def unchanged(file: Path, before: State) -> Iterator[None]:
    """Read a file that must be as it was.

    Raises
    ------
    ChangedError
        It was changed since, whatever else seems wrong with it then.
    InputError
        It cannot be read.
    """
    place = Place(str(file))
    changed = "was changed while it was read; read it again when nothing writes to it, or read a copy"
    try:
        yield
    except (InputError, OSError, UnicodeDecodeError) as error:
        if state_of(file) != before:
            raise ChangedError(changed, place=place) from None
        if isinstance(error, OSError):
            raise InputError(f"cannot be read ({error.strerror})", place=place) from None
        raise
    if state_of(file) != before:
        raise ChangedError(changed, place=place)
