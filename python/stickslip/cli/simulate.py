"""The command `stickslip simulate`: one run of a model, in the units of its readings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from stickslip.cli.options import Named, Output, force_option


@click.command(short_help="One run of a model, as CSV and a figure.")
@click.argument("model", type=Named())
@click.option(
    "--belt-speed",
    default=None,
    help="v_b, as in '14 mm/s'; without a unit in that of the belt channel, or in m/s if there is none. Or a formula "
    "of t, '0.5*sin(1.7*t)', or a file: .toml with [[speed]] tables, .csv with columns t and belt.",
)
@click.option(
    "--drive-speed",
    default=None,
    help="Likewise of the drive that pulls at links of a rig of bodies; a .csv has columns t and drive.",
)
@click.option(
    "--drive",
    default=None,
    help="Force on a driven slider: '4 N', a formula of t in newtons, '20*sin(3*t)', or the file of a run, whose drive "
    "moves it again.",
)
@click.option("--t-end", required=True, help="Length of the run: a number in the unit of time, or '60 s'.")
@click.option("--dt", default=None, help="Sampling step of the CSV; a two-thousandth of the run if absent.")
@click.option(
    "--initial",
    default=None,
    help="Start x1,x2,y1,y2, units allowed: '1 mm, 14 mm/s, 0, 0'; at rest if absent. Of other rigs coordinates, then "
    "velocities, then states of laws if they are to be given.",
)
@click.option("--out", type=Output(dir_okay=False), required=True, help="CSV file to write.")
@click.option(
    "--sensors",
    is_flag=True,
    help="Also write accelerations, forces in links and friction at contacts of a rig of bodies or matrices.",
)
@click.option("--figure", is_flag=True, help="Also write the figure beside it, as SVG and PNG.")
@force_option
def simulate(model: Path, force: bool, **given: Any) -> None:
    """Simulate MODEL (a TOML file, or the folder of identify or discover); write t, the state and the mode as CSV.

    Numbers without a unit are in the units of the readings, as the model file's [channels] say. A belt speed is in
    the unit of the belt channel; without one in m/s, even where the readings are in mm. Everything is in SI where
    there are no channels, and a bare number for a rig without units. The columns are in the same units, with the unit
    in their head: t, the state as it is, the mode. Where effects make a sensor read otherwise, what it reads is there
    too, as x1_read and y1_read: to read the file as a recording, name these columns. The mode is 0 in stick, -1 and 1
    in slip with v_w below and above zero. The figure is drawn from at least 120 points a natural period and every
    transition, whatever the step; of a run longer than 1000 periods it shows the last 1000. Of a rig of bodies or
    matrices everything is in SI, there is a mode for every contact, and what is read of NAME is NAME_read.

    \b
    Example:
      stickslip simulate model.toml --belt-speed 0.1 --t-end 1000 --out run.csv --figure
      stickslip simulate identified --belt-speed '14 mm/s' --t-end '60 s' --out run.csv
    """
    from stickslip.cli.running.simulate import perform

    perform(model, force, **given)
