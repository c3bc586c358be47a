"""report.html: one file with its figures inside, for a person."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from stickslip.discovery.plain import Json
from stickslip.discovery.result import Found, Verdict
from stickslip.discovery.workers import Workers
from stickslip.measured.case import Case
from stickslip.shown.pages.filters import number
from stickslip.shown.pages.shared import shared
from stickslip.shown.pages.skeleton import Saved, render, saved
from stickslip.shown.report import (
    figures,
    figures_friction,
    figures_motion,
    figures_numbers,
    figures_residual,
    words,
)
from stickslip.shown.report.motion import residual
from stickslip.shown.report.units import Axes, axes_of

Drawer = Callable[[Found, Axes], Figure]
FIGURES: Mapping[str, Drawer] = {
    "errors": figures_numbers.errors,
    "motion": figures_motion.motion,
    "portrait": figures.portrait,
    "friction": figures_friction.friction,
    "residual_in_time": figures_residual.in_time,
    "residual_spectrum": figures_residual.spectrum,
    "residual_against_variable": figures_residual.against_variable,
    "residual_parts": figures_numbers.parts,
    "ranking": figures_numbers.ranking,
    "learned_curve": figures_residual.curve,
}


def draw(found: Found, case: Case, folder: Path) -> dict[str, Saved]:
    """Draw every figure the result has something for, as SVG and PNG and for the page."""
    names = [name for name in FIGURES if _wanted(name, found)]
    workers = Workers.at_hand()
    try:
        drawn = workers.map(partial(_saved, found, axes_of(case), folder), names)
    except BaseException:
        workers.stop()  # nobody draws into a folder that is about to go
        raise
    return dict(zip(names, drawn, strict=True))


def _saved(found: Found, axes: Axes, folder: Path, name: str) -> Saved:
    return saved(FIGURES[name](found, axes), folder, name)


def _wanted(name: str, found: Found) -> bool:
    if name == "learned_curve":
        return any(effect.curve is not None for effect in found.effects)
    if name == "residual_parts":
        return bool(found.residual_before.parts)
    if name == "ranking":
        return len(found.ranking) > 1
    if name == "residual_spectrum":
        return len(found.spectrum.get("frequency", ())) > 2
    return bool(found.runs)


def page(
    found: Found,
    case: Case,
    report: Mapping[str, Json],
    drawings: Mapping[str, Saved],
    command: str | None = None,
) -> str:
    """The page as one self-contained HTML text: no other file and no network is needed to read it.

    `command` is the one that made it; without it, one that would.
    """
    given = shared(found, case, report, drawings, command)
    return render(
        "stickslip.shown.report",
        "report.html.j2",
        given
        | {
            "axes": axes_of(case),
            "single": figures_numbers.single_events(found),
            "tile": _tile(found),
            "one_cycle": "error of single events"
            if figures_numbers.single_events(found)
            else "forecast error, one cycle",
            "floor": words.floor(found, single=figures_numbers.single_events(found)),
            "Verdict": Verdict,
            "kind": words.kind,
            "contained": words.joined(figures_friction.contained(found)),
            "place": words.PLACE,
            "excursion": excursion(found, axes_of(case)),
        },
    )


def _tile(found: Found) -> str:
    """What `error` is, in few words."""
    return (
        "error of single events (NRMSE)" if figures_numbers.single_events(found) else "forecast error (NRMSE)"
    )


def excursion(found: Found, axes: Axes) -> str:
    """Where the residual is largest on the train runs, in words."""
    which = "after" if found.effects else "before"
    worst = ("", "", 0.0, 0.0)
    for run in found.runs:
        for channel in run.measured if run.role == "train" else ():
            z = residual(run, which, channel)
            if np.isfinite(z).any():
                at = int(np.nanargmax(np.abs(z)))
                if abs(z[at]) > abs(worst[2]):
                    worst = (run.name, channel, float(z[at]), float(run.t[at]))
    name, channel, size, at_time = worst
    if not name:
        return ""
    unit = "" if axes.t.unit == "1" else f" {axes.t.unit}"
    when = f"{axes.t.size * at_time:.3g}{unit}"
    return (
        f"The largest that is left over: {number(size, 2)} times the noise, in {channel} of {name} at {when}."
    )
