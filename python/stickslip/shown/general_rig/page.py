"""report.html of a rig of bodies or matrices: one file with its figures inside."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from stickslip.discovery.general_rig.result import GeneralFound
from stickslip.discovery.plain import Json
from stickslip.measured.case import Case
from stickslip.shown.general_rig.figures import drawn
from stickslip.shown.pages.shared import shared
from stickslip.shown.pages.skeleton import Saved, render, saved
from stickslip.shown.report import words


def draw(found: GeneralFound, folder: Path) -> dict[str, Saved]:
    """Draw the figures as SVG and PNG and for the page."""
    return {name: saved(figure, folder, name) for name, figure in drawn(found).items()}


def page(
    found: GeneralFound,
    case: Case,
    report: Mapping[str, Json],
    drawings: Mapping[str, Saved],
    command: str | None = None,
) -> str:
    """The page as one self-contained HTML text, of the same parts as the other rigs' reports."""
    more = {"called": words.called, "own_names": {one.name for one in case.candidates}}
    given = shared(found, case, report, drawings, command)
    return render("stickslip.shown.general_rig", "report.html.j2", given | more)
