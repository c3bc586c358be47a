"""The command `stickslip identify`: the friction law, from the recordings of a case."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli.options import Named, belt_option, files_from_option, force_option, out_option

if TYPE_CHECKING:
    from stickslip.fitted.identify import BeltSpeed


@click.command(short_help="The friction law, from the recordings of a case.")
@click.argument("case", type=Named())
@out_option
@belt_option
@files_from_option
@force_option
def identify(case: Path, out: Path, belt: BeltSpeed, files_from: Path | None, force: bool) -> None:
    """Identify the friction law from the train runs of CASE (rig.toml or its folder).

    Writes model.toml, identified.json and the friction characteristic as SVG and PNG.

    \b
    Example:
      stickslip identify CASE/rig.toml --out identified
    """
    from stickslip.cli.running.identify import perform

    perform(case, out, belt, files_from, force)
