"""What is done by `stickslip demo`: the whole job on a real recording, then a story of discovery."""

from __future__ import annotations

from pathlib import Path

from stickslip.cli.paper_slider import run
from stickslip.cli.printed import console, say_table, say_written
from stickslip.cli.running import compare, identify
from stickslip.files import folder
from stickslip.progress import shares


def perform(out: Path, first_half: bool, force: bool) -> None:
    """Do what `stickslip demo` is asked for."""
    with folder(out, (*identify.WRITTEN, *compare.WRITTEN), force=force) as temporary:
        with shares("demo") as tell:
            result = run(tell)
        identify.fill_identified(result.found, temporary)
        compare.fill_comparison(result.comparison, temporary)
    written = [out / name for name in (*identify.WRITTEN, *compare.WRITTEN)]
    for paragraph in result.before:
        console.print(paragraph + "\n")
    say_table(identify.estimates_table(result.found))
    say_table(compare.comparison_table(result.comparison))
    compare.say_verdict(result.comparison)
    for paragraph in result.after:
        console.print(paragraph + "\n")
    if not first_half:
        from stickslip.cli.rotated_portrait import story

        written += story(out, console, force=force).paths
    say_written(written)
