"""The command `stickslip forecast`: the readings that follow a recording."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.options import Named, Output, force_option


@click.command(short_help="The readings that follow a recording.")
@click.argument("model", type=Named())
@click.argument("run", type=Named())
@click.option(
    "--belt-speed",
    default=None,
    help="v_b of RUN and of what follows it, in the belt channel's unit, or with one: '12 mm/s'.",
)
@click.option("--drive-speed", default=None, help="The same of the drive of a rig of bodies or matrices.")
@click.option(
    "--drive",
    default=None,
    help="Force on a driven slider after RUN: '4 N', a formula of t, or the file of a run; t is that of RUN.",
)
@click.option("--horizon", required=True, help="How far ahead, in the unit of the run's time, or '20 s'.")
@click.option("--out", type=Output(dir_okay=False), required=True, help="CSV file to write.")
@click.option("--figure", is_flag=True, help="Also draw the forecast after the end of the run, beside OUT.")
@force_option
def forecast(
    model: Path,
    run: Path,
    belt_speed: str | None,
    drive_speed: str | None,
    drive: str | None,
    horizon: str,
    out: Path,
    figure: bool,
    force: bool,
) -> None:
    """Forecast the readings that follow RUN (a CSV of the past) by MODEL (model_after.toml).

    Writes t, x1, y1 in the run's units and at its sampling rate, from the next sample on, and
    the 95 % band of the readings to come (x1_low, x1_high, y1_low, y1_high).

    \b
    Example:
      stickslip forecast found/model_after.toml CASE/run_07.csv --belt-speed 0.0140 --horizon 20 --out next.csv
    """
    from stickslip.cli.running.forecast import perform

    perform(model, run, (belt_speed, drive_speed, drive), horizon, out, figure, force)
