"""The figures and numbers of docs/real.md: `python docs/figures/real.py [FOLDER]`.

FOLDER holds k168Nm_v42.mat, k168Nm_v1100.mat and k168Nm_v4300.mat of github.com/npusteln/stickslip (data_raw,
CeCILL-B); left out, $STICKSLIP_SHARED/data/paper_slider.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import stickslip as ss
from stickslip.discovery.result import Found, RunView
from stickslip.fitted.block_events.cycle import LOG_W2, S
from stickslip.fitted.block_events.table import MeasuredBlock, measure, natural_rate, prepare
from stickslip.measured.case import Case, load_case
from stickslip.shown.plot.curves import LIMIT, MEASURED, SIMULATED, STYLE, save_figure
from stickslip.shown.report.write import write_report

HERE = Path(__file__).resolve().parent
SHARED = Path(os.environ.get("STICKSLIP_SHARED", "."))
WIDE = 90  # samples
COLOURS = (MEASURED, "#CC79A7", "#E69F00")


def main() -> None:
    """Discover, print what docs/real.md quotes, draw."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else SHARED / "data" / "paper_slider"
    with tempfile.TemporaryDirectory() as made:
        case = _case(folder, Path(made))
        found = ss.discover(case, progress=print, threads=1)
        if len(sys.argv) > 2:
            write_report(found, case, sys.argv[2])
    said(found)
    runs = [measure(prepare(one)) for one in case.runs]
    with mpl.rc_context(STYLE):
        save_figure(noise_of(runs), HERE / "real_events")
        save_figure(single_events(found), HERE / "real_slips")


def _case(folder: Path, made: Path) -> Case:
    shutil.copy(HERE.parent / "paper_slider.toml", made / "rig.toml")
    for speed in (42, 1100, 4300):
        shutil.copy(folder / f"k168Nm_v{speed}.mat", made)
    return load_case(made / "rig.toml")


def said(found: Found) -> None:
    """Print the numbers of the page."""
    for effect in found.effects:
        print(effect.name, {n: (i.value, i.low, i.high) for n, i in effect.parameters.items()})
        print("  ", effect.evidence.sentence, "held out", effect.evidence.held_out_ratio)
        print("  ", [(a.name, round(a.odds, 4), a.exact) for a in effect.alternatives])
    for run in found.error.runs:
        print(run.run, run.one_cycle)
    print("error", found.error.before, found.error.after, found.error.floor, "seconds", found.seconds)
    print(found.residual_before.sentence, "->", found.residual_after.sentence)
    print(*found.messages, sep="\n")


def noise_of(runs: list[MeasuredBlock]) -> Figure:
    """Levels, rates of the sticks and frequencies of the slips of every event, against the travel of the belt."""
    figure = Figure(figsize=(9.4, 6.4), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    for speed, colour in zip(sorted({one.run.belt_speed for one in runs}), COLOURS, strict=True):
        name = f"{1e6 * speed:.0f} µm/s"
        for i, one in enumerate(r for r in runs if r.run.belt_speed == speed):
            e, run = one.events, one.run
            start = 1e3 * speed * (_start(one) - min(_start(r) for r in runs if r.run.belt_speed == speed))
            at = start + 1e3 * e.travel
            label = name if i == 0 else None
            axes[0].plot(
                at, 1e3 * run.rig.stiffness * e.p[:, S], ".-", ms=3, lw=0.7, color=colour, label=label
            )
            axes[1].plot(start + 1e3 * speed * one.sticks.t, one.sticks.rate, ".", ms=3, color=colour)
            size = 2 + 8 * np.sqrt(e.slip / e.slip.max())
            w = np.exp(0.5 * e.p[:, LOG_W2]) / natural_rate(run.rig)
            axes[2].scatter(at, w, s=size, color=colour)
    axes[0].set_ylabel("breakaway force [mN]")
    axes[1].set_ylabel("rise of the sticks / set-point")
    axes[1].set_ylim(0.7, 1.4)
    axes[2].set_ylabel(r"slip frequency / $\sqrt{k/m}$")
    axes[2].set_ylim(0.3, 2.6)
    for ax in axes[1:]:
        ax.axhline(1.0, color="black", lw=1.0, ls=(0, (4, 2)))
    axes[2].set_xlabel("travel of the pull [mm]")
    figure.legend(loc="outside upper center", ncols=3)
    return figure


def _start(one: MeasuredBlock) -> float:
    """Time of the run's first sample in its file; runs cut by time follow each other."""
    return float(one.run.name.rpartition("_from_")[2]) if "_from_" in one.run.name else _origin(one)


def _origin(one: MeasuredBlock) -> float:
    """First times of the three records."""
    return {42: 93.9095, 1100: 3.5895, 4300: 0.9395}[round(1e6 * one.run.belt_speed)]


def single_events(found: Found) -> Figure:
    """A middling stretch of each train run that was fitted, measured and as the declared model moves through it."""
    runs = [run for run in found.runs if run.role == "train"]
    figure = Figure(figsize=(9.4, 5.2), layout="constrained")
    rows = figure.subplots(2, len(runs), squeeze=False)
    for column, run in zip(rows.T, runs, strict=True):
        a, b = _stretch(run)
        t, x, fit = 1e3 * (run.t[a:b] - run.t[a]), run.measured["x1"][a:b], run.after["x1"][a:b]
        column[0].plot(t, 1e6 * x, ".", ms=3, color=MEASURED, label="measured")
        column[0].plot(t, 1e6 * fit, color=LIMIT, lw=1.2, label="with friction of its own")
        column[0].set_title(f"pull {1e6 * run.belt_speed:.0f} µm/s", fontsize=9)
        column[1].plot(t, (x - fit) / run.noise["x1"], ".", ms=3, color=SIMULATED)
        column[1].axhline(0.0, color="black", lw=1.0, ls=(0, (4, 2)))
        column[1].set_xlabel("time [ms]")
    rows[0, 0].set_ylabel("deflection read [µm]")
    rows[1, 0].set_ylabel("left, over the noise")
    handles, names = rows[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=2)
    return figure


def _stretch(run: RunView) -> tuple[int, int]:
    """The slip that is fitted half as well as the others, with the sticks around it."""
    slips = np.flatnonzero((run.mode_after[:-1] == 0) & (run.mode_after[1:] != 0))
    spans = [(max(i - WIDE, 0), min(i + 2 * WIDE, len(run.t))) for i in slips.tolist()]
    spans = [(a, b) for a, b in spans if np.isfinite(run.after["x1"][a:b]).all()]
    left = [float(np.mean((run.measured["x1"][a:b] - run.after["x1"][a:b]) ** 2)) for a, b in spans]
    return spans[int(np.argsort(left)[len(left) // 2])]


if __name__ == "__main__":
    main()
