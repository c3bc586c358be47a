"""The command `stickslip demo`: the whole job on a real recording, then a story of discovery."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.options import Output, force_option


@click.command(short_help="All of it on a real recording, then a story of discovery.")
@click.option(
    "--out",
    type=Output(file_okay=False),
    default=Path("demo"),
    show_default=True,
    help="Folder for the results.",
)
@click.option("--first-half", is_flag=True, help="Stop after the slider.")
@force_option
def demo(out: Path, first_half: bool, force: bool) -> None:
    """Do the whole job on a recording that comes with the package: a slider of paper on paper.

    Then tell the paper's own story: a rig whose measured portrait is rotated, its stick phase irregular, and why.

    \b
    Example:
      stickslip demo --out demo
    """
    from stickslip.cli.running.demo import perform

    perform(out, first_half, force)
