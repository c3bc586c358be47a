"""The command `stickslip demo`: the whole job on a real recording, then a story of discovery."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli import compare, identify
from stickslip.cli.options import Output, force_option
from stickslip.cli.paper_slider import run
from stickslip.cli.printed import console, say_written
from stickslip.files import folder
from stickslip.progress import shares


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
    with folder(out, (*identify.WRITTEN, *compare.WRITTEN), force=force) as temporary:
        with shares("demo") as tell:
            result = run(tell)
        identify.fill_identified(result.found, temporary)
        compare.fill_comparison(result.comparison, temporary)
    written = [out / name for name in (*identify.WRITTEN, *compare.WRITTEN)]
    for paragraph in result.before:
        console.print(paragraph + "\n")
    console.print(identify.estimates_table(result.found))
    console.print(compare.comparison_table(result.comparison))
    compare.say_verdict(result.comparison)
    for paragraph in result.after:
        console.print(paragraph + "\n")
    if not first_half:
        from stickslip.cli.rotated_portrait import story

        written += story(out, console, force=force).paths
    say_written(written)
