"""report.html of a driven slider: one file with its figures inside."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

from jinja2 import BaseLoader, Environment, StrictUndefined
from markupsafe import Markup

from stickslip.discovery.driven_slider.result import DrivenFound
from stickslip.discovery.result import Json
from stickslip.measured.case import Case
from stickslip.shown.driven_slider.figures import drawn
from stickslip.shown.plot.curves import save_figure
from stickslip.shown.report import words
from stickslip.shown.report.page import inline, number, percent, span


def draw(found: DrivenFound, folder: Path) -> dict[str, Path]:
    """Draw the figures as SVG and PNG; return the SVG of each."""
    return {name: save_figure(figure, folder / name)[0] for name, figure in drawn(found).items()}


def page(found: DrivenFound, case: Case, report: Mapping[str, Json], drawings: Mapping[str, Path]) -> str:
    """The page as one self-contained HTML text, in the style of the other rigs' reports."""
    environment = Environment(
        loader=BaseLoader(), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"num": number, "span": span, "percent": percent, "tied": words.ties}
    other = (files("stickslip.shown.report") / "report.html.j2").read_text(encoding="utf-8")
    style = re.search(r"<style>.*?</style>", other, re.DOTALL)
    text = (files("stickslip.shown.driven_slider") / "report.html.j2").read_text(encoding="utf-8")
    return environment.from_string(text).render(
        found=found,
        case=case,
        report=report,
        style=Markup(style[0]) if style else "",
        headline=words.headline(found),
        sureness=words.sureness(found),
        alarms=words.alarms(found),
        clean=words.clean_sentence(found),
        caveats=words.caveats(found),
        plain=words.plain,
        place=words.PLACE,
        figures={name: inline(path, name) for name, path in drawings.items()},
    )
