"""report.html: one file with its figures inside, for a person."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import partial
from importlib.resources import files
from pathlib import Path

import numpy as np
from jinja2 import BaseLoader, Environment, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from stickslip.discovery.result import Found, Interval, Json, Rival, Verdict
from stickslip.discovery.workers import Workers
from stickslip.measured.case import Case
from stickslip.shown.plot.curves import save_figure
from stickslip.shown.report import figures, figures_friction, figures_numbers, figures_residual, words
from stickslip.shown.report.motion import residual
from stickslip.shown.report.units import Axes, axes_of

ROUNDING = 1e-12  # of a cycle, of a signal: no error is so small
Drawer = Callable[[Found, Axes], Figure]
FIGURES: Mapping[str, Drawer] = {
    "errors": figures_numbers.errors,
    "portrait": figures.portrait,
    "friction": figures_friction.friction,
    "residual_in_time": figures_residual.in_time,
    "residual_spectrum": figures_residual.spectrum,
    "residual_against_variable": figures_residual.against_variable,
    "residual_parts": figures_numbers.parts,
    "ranking": figures_numbers.ranking,
    "learned_curve": figures_residual.curve,
}


def draw(found: Found, case: Case, folder: Path) -> dict[str, Path]:
    """Draw every figure the result has something for, as SVG and PNG; return the SVG of each."""
    names = [name for name in FIGURES if _wanted(name, found)]
    workers = Workers.at_hand()
    try:
        drawn = workers.map(partial(_saved, found, axes_of(case), folder), names)
    except BaseException:
        workers.stop()  # nobody draws into a folder that is about to go
        raise
    return dict(zip(names, drawn, strict=True))


def _saved(found: Found, axes: Axes, folder: Path, name: str) -> Path:
    return save_figure(FIGURES[name](found, axes), folder / name)[0]


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


def page(found: Found, case: Case, report: Mapping[str, Json], drawings: Mapping[str, Path]) -> str:
    """The page as one self-contained HTML text: no other file and no network is needed to read it."""
    environment = Environment(
        loader=BaseLoader(), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "num": number,
        "error": error,
        "span": span,
        "valued": valued,
        "interval": interval,
        "percent": percent,
        "tied": words.ties,
        "guessed": words.guessed,
        "sentence": words.sentence,
        "beneath": beneath,
        "numbers": numbers,
    }
    text = (files("stickslip.shown.report") / "report.html.j2").read_text(encoding="utf-8")
    return environment.from_string(text).render(
        found=found,
        case=case,
        report=report,
        axes=axes_of(case),
        single=figures_numbers.single_events(found),
        tile=_tile(found),
        one_cycle="error of single events"
        if figures_numbers.single_events(found)
        else "forecast error, one cycle",
        floor=words.floor(found, single=figures_numbers.single_events(found)),
        Verdict=Verdict,
        headline=words.headline(found),
        sureness=words.sureness(found),
        alarms=words.alarms(found),
        clean=words.clean_sentence(found),
        caveats=words.caveats(found, axes_of(case)),
        kind=words.kind,
        contained=words.joined(figures_friction.contained(found)),
        place=words.PLACE,
        excursion=excursion(found, axes_of(case)),
        figures={name: inline(path, name) for name, path in drawings.items()},
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


def inline(path: Path, prefix: str) -> Markup:
    """An SVG for a place in a page: its header dropped, its names made its own, scaled to the page's width."""
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    text = text.replace("url(#", f"url(#{prefix}-").replace('href="#', f'href="#{prefix}-')
    text = re.sub(r'<svg ([^>]*?)\bwidth="([\d.]+)pt"', r'<svg \1style="max-width:\2pt"', text, count=1)
    text = re.sub(r'(<svg [^>]*?)\bheight="[\d.]+pt"', r'\1role="img"', text, count=1)
    return Markup(text)  # drawn by us from numbers; names in it are escaped by matplotlib


def number(value: float | None, digits: int = 4) -> str:
    """A number for a table, with a power of ten where it is far from 1; a dash where there is none."""
    return words.short(value, digits)


def error(value: float) -> str:
    """An error for a table; what is only rounding is 0."""
    return number(0.0 if abs(value) < ROUNDING else value, 3)


def span(one: Interval | None) -> str:
    """A 95 % interval for a table."""
    if one is None or (one.low is None and one.high is None):
        return "–"
    return words.spanned(one)[1]


def valued(one: Interval) -> str:
    """A value with the digits that its interval leaves it."""
    return words.spanned(one)[0]


def interval(row: Mapping[str, float | None]) -> Interval:
    """The interval of a row of the table of all numbers."""
    return Interval(float(row["value"] or 0.0), row.get("low"), row.get("high"))


def beneath(one: Mapping[str, float]) -> bool:
    """Is the difference of before and after below the floor?"""
    return abs(one["before"] - one["after"]) < one["floor"]


def numbers(rival: Rival) -> str:
    """A rival's numbers: by their own names where it is one effect; phases, which differ by run, are left out."""
    single = len(rival.names) == 1
    return ", ".join(
        f"{name.rpartition('.')[2] if single else name} = {number(value, 3)}"
        for name, value in rival.parameters.items()
        if not name.endswith(".phi")
    )


def percent(value: float | None) -> str:
    """A share as percent, two digits."""
    return "–" if value is None or value != value else f"{number(100 * value, 2)}\u00a0%"  # NaN
