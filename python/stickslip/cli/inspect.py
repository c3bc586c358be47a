"""The command `stickslip inspect`: what is in a file, before a case is made of it."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.options import Named, Output, force_option


@click.command(short_help="What is in a file: columns, units, rates, gaps, what is doubtful.")
@click.argument("file", type=Named())
@click.option(
    "--figure",
    type=Output(dir_okay=False),
    default=None,
    help="Also draw the columns: a name for SVG and PNG.",
)
@force_option
def inspect(file: Path, figure: Path | None, force: bool) -> None:
    """Say what is in FILE: its columns with units and ranges, its sampling rate, and what is doubtful.

    FILE is anything that a case may hold: CSV and other text, LabVIEW, MATLAB, HDF5, Parquet, WAV.

    \b
    Example:
      stickslip inspect run_01.lvm --figure run_01_columns
    """
    from stickslip.cli.running.inspect import perform

    perform(file, figure, force)
