"""The command `stickslip discover`: what the declared model lacks."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.options import Named, Output, files_from_option, force_option


@click.command(short_help="What the declared model lacks: an effect, and how sure.")
@click.argument("case", type=Named())
@click.option("--out", type=Output(), required=True, help="Folder for the results.")
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Of the bootstrap's random numbers.",
)
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    default=None,
    help="Fits side by side; as many as there are cores, if absent. The result is the same.",
)
@files_from_option
@force_option
def discover(
    case: Path, out: Path, seed: int, threads: int | None, files_from: Path | None, force: bool
) -> None:
    """Find what the declared model of CASE (rig.toml or its folder) lacks, and add it.

    Writes report.html, report.json, model_before.toml, model_after.toml and the figures. The exit status is 0 with
    any verdict, "no_effect" included.

    \b
    Example:
      stickslip discover CASE/rig.toml --out found
    """
    from stickslip.cli.running.discover import perform

    perform(case, out, seed, threads, files_from, force)
