"""The command `stickslip init`: a rig.toml for recorded files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from stickslip.cli.options import Named, Output, force_option
from stickslip.declared.rig_kinds import NAMED, RIG_KINDS


class Kind(click.Choice[str]):
    """The kinds of rigs whose constants are a list. Another kind is refused with what to do instead."""

    def __init__(self) -> None:
        super().__init__(list(NAMED))

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the kind."""
        return value if value in RIG_KINDS else super().convert(value, param, ctx)


@click.command(short_help="A first rig.toml for recorded files.")
@click.argument("files", type=Named(), nargs=-1, required=True)
@click.option(
    "--rig",
    "kind",
    type=Kind(),
    default=None,
    help="Kind of rig; guessed if absent. One of bodies is written by hand: see 'stickslip example bodies'.",
)
@click.option(
    "--constant", "constants", multiple=True, help="A constant of the rig: m=42.3 (SI), 'm=42300 g'."
)
@click.option(
    "--channel",
    "channels",
    multiple=True,
    help="A channel: x1=COLUMN, x1=COLUMN:UNIT or x1=COLUMN:UNIT:SCALE.",
)
@click.option(
    "--belt-speed", "speeds", multiple=True, help="Set-point of all runs, '12 mm/s'; of one: FILE='12 mm/s'."
)
@click.option("--validate", multiple=True, help="A file to validate on; the last one, if absent.")
@click.option("--title", default="", help="Title of the case; its folder's name, if absent.")
@click.option(
    "--out", type=Output(file_okay=False), default=None, help="The case's folder; that of FILES, if absent."
)
@force_option
def init(
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
    """Write a rig.toml for the recordings FILES, which lie in the case's folder or below it.

    Columns are taken for channels by their units and names, belt speeds are read from the record where they are not
    given. What is doubtful is a comment of the file. On a terminal, what is not known is asked.

    \b
    Example:
      stickslip init run_01.csv run_02.csv --constant m=0.0307 --constant k=168
    """
    from stickslip.cli.running.init import perform

    perform(files, kind, constants, channels, speeds, validate, title, out, force)
