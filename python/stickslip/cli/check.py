"""The command `stickslip check`: what the runs of a case can tell, before a long search."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.options import Named, files_from_option


@click.command(short_help="What the runs of a case can tell and what they cannot.")
@click.argument("case", type=Named())
@files_from_option
def check(case: Path, files_from: Path | None) -> None:
    """Say what the runs of CASE (rig.toml or its folder) can tell and what they cannot, before a long search.

    It counts sticks and slips, looks at directions, belt speeds and sampling, and at the force of each effect along the
    recorded motion: how much of it the numbers of the friction law take up, and which effects act alike. Effects that
    repeat, that change a reading or that have a state of their own are not judged.

    \b
    Example:
      stickslip check CASE
    """
    from stickslip.cli.running.check import perform

    perform(case, files_from)
