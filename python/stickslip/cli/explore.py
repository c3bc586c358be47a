"""The command `stickslip explore`: a model with sliders, in the browser."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.options import Named, Output, force_option


@click.command(short_help="A model with sliders, redrawn live in the browser.")
@click.argument("model", type=Named())
@click.option(
    "--belt-speed", default=None, help="v_b to begin with, as in '14 mm/s'; that of the run, of a CASE."
)
@click.option("--run", "name", default=None, help="Run of a CASE to lay beneath; the first, if absent.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port; a free one, if absent.")
@click.option(
    "--screenshot", type=Output(dir_okay=False), default=None, help="Write a PNG of the page, and end."
)
@force_option
def explore(
    model: Path, belt_speed: str | None, name: str | None, port: int, screenshot: Path | None, force: bool
) -> None:
    """Open a page with sliders for MODEL (a TOML file, the folder of a result, or a case's rig.toml).

    The speed of the belt (or of the drive that pulls a rig of bodies) and every number of rig, law and effects have a
    slider; phase portrait, friction characteristic and signal follow. Of a case, a recorded run lies beneath. The page
    is for this machine alone; its address holds a token. Ctrl-C ends it.

    \b
    Example:
      stickslip explore model.toml --belt-speed 0.1
      stickslip explore CASE/rig.toml --run run_02
      stickslip explore drillstring.toml --belt-speed '5 rad/s' --screenshot page.png
    """
    from stickslip.cli.running.explore import perform

    perform(model, belt_speed, name, port, screenshot, force)
