"""The command `stickslip sweep`: a TOML file says what varies, a Zarr store holds the result."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.options import Named, Output


@click.command(short_help="A model over a grid of its numbers, into a Zarr store.")
@click.argument("file", type=Named())
@click.option("--out", type=Output(), required=True, help="Zarr store to write or go on with.")
@click.option("--threads", type=click.IntRange(min=1), default=None, help="All that there are if absent.")
def sweep(file: Path, out: Path, threads: int | None) -> None:
    """Simulate a model over a grid of its numbers, as FILE (sweep.toml) says, into a Zarr store.

    Stopped at any moment and started again with the same line, it computes what is missing. The store needs zarr:
    pip install 'stickslip[sweep]'. examples/sweep of the repository is one to begin with.

    \b
    model = "model.toml"            # or the tables [rig], [friction], [[effect]] here
    [sweep]
    t_end = 200
    after = 100
    initial = [0.1, 0.1, 0, 0]
    observe = ["stick_fraction", "period"]
    [over]
    belt_speed = { start = 0.02, stop = 0.3, count = 64 }
    alpha1 = [8, 16, 40]

    \b
    Example:
      stickslip sweep sweep.toml --out result.zarr
    """
    from stickslip.cli.running.sweep import perform

    perform(file, out, threads)
