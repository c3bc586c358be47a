"""What is done by `stickslip example`: files to begin with."""

from __future__ import annotations

from pathlib import Path

from stickslip.cli.practice import PRACTICE
from stickslip.cli.printed import say_written
from stickslip.files import folder


def perform(name: str, out: Path, force: bool) -> None:
    """Do what `stickslip example` is asked for."""
    _, files, write = PRACTICE[name]
    with folder(out, files, force=force) as temporary:
        write(temporary)
    say_written([out / one for one in files])
