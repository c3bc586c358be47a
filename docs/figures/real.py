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

from stickslip.discovery.result import Found
from stickslip.discovery.slider.held import constants_of, held
from stickslip.discovery.slider.loop import discover
from stickslip.fitted.block_events.cycle import LOG_W2, S, positions
from stickslip.fitted.block_events.table import Measured, cut, measure, natural_rate, prepare
from stickslip.measured.case import Case, load_case
from stickslip.shown.plot.curves import LIMIT, MEASURED, SIMULATED, STYLE, save_figure
from stickslip.shown.report.figures import after_name
from stickslip.shown.report.write import write_report

HERE = Path(__file__).resolve().parent
SHARED = Path(os.environ.get("STICKSLIP_SHARED", "."))
COLOURS = (MEASURED, "#CC79A7", "#E69F00")


def main() -> None:
    """Discover, print what docs/real.md quotes, draw."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else SHARED / "data" / "paper_slider"
    with tempfile.TemporaryDirectory() as made:
        case = _case(folder, Path(made))
        found = discover(case, progress=print)
        if len(sys.argv) > 2:
            write_report(found, case, sys.argv[2])
    said(found)
    runs = [measure(prepare(one)) for one in case.runs]
    with mpl.rc_context(STYLE):
        save_figure(noise_of(runs), HERE / "real_events")
        save_figure(single_events(runs, found), HERE / "real_slips")


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


def noise_of(runs: list[Measured]) -> Figure:
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


def _words(one: Measured) -> str:
    """The run as docs/real.md calls it: its pull, and where its part of the record begins."""
    _, _, start = one.run.name.partition("_from_")
    return f"pull {1e6 * one.run.belt_speed:.0f} µm/s" + (f", from {start} s" if start else "")


def _start(one: Measured) -> float:
    """Time of the run's first sample in its file; runs cut by time follow each other."""
    return float(one.run.name.rpartition("_from_")[2]) if "_from_" in one.run.name else _origin(one)


def _origin(one: Measured) -> float:
    """First times of the three records."""
    return {42: 93.9095, 1100: 3.5895, 4300: 0.9395}[round(1e6 * one.run.belt_speed)]


def single_events(runs: list[Measured], found: Found) -> Figure:
    """Median slips of the validate runs, each with its own friction, declared and with what was found."""
    models = ((SIMULATED, (0, (4, 2)), "declared model"), (LIMIT, "-", after_name(found)))
    chosen = [one for one in runs if one.run.role == "validate"]
    figure = Figure(figsize=(9.4, 3.4), layout="constrained")
    for ax, one in zip(figure.subplots(1, len(chosen)), chosen, strict=True):
        was, now = (held(one, constants_of(model, one)) for model in (found.before, found.after))
        rms = np.sqrt(np.nanmean(now.residual**2, axis=1))
        i = int(np.argsort(rms)[len(rms) // 2])
        a, b = one.events.window[i]
        t = 1e3 * (one.run.t[a:b] - one.run.t[a])
        windows = cut(one.run, one.events.window)
        ax.plot(t, 1e6 * one.run.x[a:b], ".", ms=3, color=MEASURED, label="measured")
        for h, (colour, style, name) in zip((was, now), models, strict=True):
            ax.plot(
                t, 1e6 * positions(h.p, windows.t)[i, : b - a], color=colour, ls=style, lw=1.2, label=name
            )
        ax.set_title(_words(one), fontsize=9)
        ax.set_xlabel("time [ms]")
    figure.axes[0].set_ylabel("deflection read [µm]")
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=3)
    return figure


if __name__ == "__main__":
    main()
