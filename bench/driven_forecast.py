"""Forecasts of a driven slider on the EMPS record: how long it takes to simulate, and how much its bands hold.

    python bench/driven_forecast.py PATH/DATA_EMPS.mat

The model is the published one; every forecast is of 0.3 s after a cut, from the readings before it.
"""

from __future__ import annotations

import os
import tempfile
import time
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import numpy as np
from scipy.io import loadmat

import stickslip as ss
from bench_driven import CASE
from stickslip.fitted.driven import forecast_driven

AHEAD = 0.3  # s
CUTS = range(3000, 12_000, 500)  # samples
TIMES = 5


@click.command()
@click.argument("record", type=click.Path(exists=True, dir_okay=False, path_type=Path))
def main(record: Path) -> None:
    """Print a table."""
    model = ss.Model(
        ss.DrivenSlider(mass=95.1089, damping=203.5034),
        friction=ss.CoulombFriction(static=20.3935, kinetic=20.3935),
    )
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "rig.toml"
        gain = float(loadmat(record)["gtau"].ravel()[0])
        case.write_text(CASE.format(gain=gain).replace("DATA_EMPS.mat", str(record.resolve())))
        run = ss.load_case(case, files_from="/").train[0]
    drive, seconds = (run.t, run.drive), []
    for _ in range(TIMES):
        start = time.perf_counter()
        ss.simulate(model, drive=drive, initial=(float(run.x1[0]), 0.0), t_end=float(run.t[-1]), t_eval=run.t)
        seconds.append(time.perf_counter() - start)
    click.echo(f"{len(run.t)} samples that hold: simulated in {np.median(seconds):.2f} s")
    click.echo("| after | error of the last position | half of the band there | held |\n|---|---|---|---|")
    held = []
    for cut in CUTS:
        past = replace(run, t=run.t[:cut], x1=run.x1[:cut], drive=run.drive[:cut])
        made = forecast_driven(model, past, drive, AHEAD)
        true = run.x1[cut : cut + len(made.t)]
        held.append(np.mean((true >= made.low) & (true <= made.high)))
        error, half = abs(made.mean - true)[-1], (made.high - made.mean)[-1]
        click.echo(
            f"| {run.t[cut - 1]:.2f} s | {1e3 * error:.2f} mm | {1e3 * half:.2f} mm | {100 * held[-1]:.0f} % |"
        )
    click.echo(f"\nbands hold {100 * np.mean(held):.0f} % of the readings to come")


if __name__ == "__main__":
    main()
