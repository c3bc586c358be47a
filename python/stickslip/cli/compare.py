"""The command `stickslip compare`: a model against a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli.options import Named, belt_option, files_from_option, force_option, out_option

if TYPE_CHECKING:
    from stickslip.fitted.identify import BeltSpeed


@click.command(short_help="A model against a recording: one table, two figures.")
@click.argument("model", type=Named())
@click.argument("case", type=Named())
@out_option
@belt_option
@click.option(
    "--run", "name", default=None, help="Name of the run; the first validate run, else the first, if absent."
)
@files_from_option
@force_option
def compare(
    model: Path,
    case: Path,
    out: Path,
    belt: BeltSpeed,
    name: str | None,
    files_from: Path | None,
    force: bool,
) -> None:
    """Simulate MODEL (a TOML file, or the folder of identify) with the belt speed of a run of CASE; compare the two.

    Writes compare.json, the phase portrait and the time series as SVG and PNG.

    \b
    Example:
      stickslip compare identified/model.toml CASE/rig.toml --out compared
    """
    from stickslip.cli.running.compare import perform

    perform(model, case, out, belt, name, files_from, force)
