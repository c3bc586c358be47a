"""The command `stickslip example`: files to begin with."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.options import Output, force_option
from stickslip.cli.practice import PRACTICE

LISTED = "".join(f"\n  {name:14}{what}" for name, (what, _, _) in PRACTICE.items())
HELP = f"""Write the files of an example into a folder. The tutorial and the how-to pages begin with them.

\b
NAME is one of{LISTED}

\b
Example:
  stickslip example practice --out try
"""


@click.command(short_help="Files to begin with: a recording, a case.", help=HELP)
@click.argument("name", type=click.Choice(list(PRACTICE)))
@click.option(
    "--out",
    type=Output(file_okay=False),
    default=Path(),
    help="Folder for the files; this one, if absent.",
)
@force_option
def example(name: str, out: Path, force: bool) -> None:
    """Write the files of an example into a folder."""
    from stickslip.cli.running.example import perform

    perform(name, out, force)
