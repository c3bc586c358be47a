"""What is done by `stickslip init`: a rig.toml for recorded files."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from stickslip.cli.printed import console, say_lines, say_written
from stickslip.errors import InputError
from stickslip.files import folder
from stickslip.measured.case import load_case
from stickslip.measured.lacking import LackingError
from stickslip.measured.new_case import Given, new_case, quoted_toml

NAME = "rig.toml"


def perform(
    files: tuple[Path, ...],
    kind: str | None,
    constants: tuple[str, ...],
    channels: tuple[str, ...],
    speeds: tuple[str, ...],
    validate: tuple[str, ...],
    title: str,
    out: Path | None,
    force: bool,
) -> None:
    """Do what `stickslip init` is asked for."""
    place = out or files[0].parent
    given = Given(kind, _named(constants, "--constant"), channels, _speeds(speeds), validate, title)
    text = _asked(files, place, given)
    with folder(place, (NAME,), force=force, inputs=files) as temporary:
        _check(text, temporary, place)
        (temporary / NAME).write_text(text, encoding="utf-8")
    console.print(text, markup=False, soft_wrap=True)
    say_lines(load_case(place / NAME).findings)
    say_written([place / NAME])


def _asked(files: Sequence[Path], place: Path, given: Given) -> str:
    """The text; on a terminal what lacks is asked for until nothing does."""
    while True:
        try:
            return new_case(files, place, given)
        except LackingError as error:
            if not on_terminal():
                raise
            lacking = error
        answer = lacking.begins + click.prompt(lacking.question[:1].upper() + lacking.question[1:], type=str)
        if lacking.option == "--constant":
            given = replace(given, constants={**given.constants, **_named((answer,), "--constant")})
        elif lacking.option == "--channel":
            given = replace(given, channels=(*given.channels, answer))
        else:
            given = replace(given, belt_speeds={**given.belt_speeds, **_speeds((answer,))})


def on_terminal() -> bool:
    """Say whether there is somebody to ask."""
    return sys.stdin.isatty()


def _named(texts: Sequence[str], option: str) -> dict[str, str]:
    """Values by name of "name=value"."""
    named = {}
    for text in texts:
        name, joint, value = text.partition("=")
        if not joint or not value.strip():
            raise InputError("write it as NAME=NUMBER", key=option, value=text)
        named[name.strip()] = value.strip()
    return named


def _speeds(texts: Sequence[str]) -> dict[str, str]:
    """Belt speeds by file; of all others under ""."""
    return {
        (name if joint else ""): (value if joint else name)
        for name, joint, value in (_at(one) for one in texts)
    }


def _at(text: str) -> tuple[str, str, str]:
    name, joint, value = text.rpartition("=")
    return (name, joint, value) if joint else (value, "", "")


def _check(text: str, temporary: Path, place: Path) -> None:
    """Load the case before it is there: its runs seen from the folder that it is made in."""
    trial = temporary / "trial.toml"
    there = quoted_toml(Path(os.path.relpath(place.resolve(), temporary.resolve())).as_posix() + "/")
    trial.write_text(text.replace('\nfile = "', f"\nfile = {there[:-1]}"), encoding="utf-8")
    try:
        load_case(trial, files_from=place)
    finally:
        trial.unlink()
