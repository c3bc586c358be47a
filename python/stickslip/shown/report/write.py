"""All files of a report at once: made in a folder beside the target, then moved into place."""

from __future__ import annotations

import json
import os
from pathlib import Path

from stickslip.declared.toml_file import write_text
from stickslip.discovery.driven_slider.result import DrivenFound
from stickslip.discovery.general_rig.result import GeneralFound
from stickslip.discovery.result import Found
from stickslip.files import folder
from stickslip.measured.case import Case
from stickslip.shown.driven_slider import page as driven
from stickslip.shown.general_rig import page as general
from stickslip.shown.report.contents import contents
from stickslip.shown.report.files import NAMES, written
from stickslip.shown.report.page import draw, page


def write_report(
    found: Found, case: Case, out: str | os.PathLike[str], *, force: bool = False, command: str | None = None
) -> list[Path]:
    """Write report.json, report.html, model_before.toml, model_after.toml and the figures into a folder.

    Parameters
    ----------
    found : Found
        What `discover` returned.
    case : Case
        What it was given.
    out : path
        Folder; made if absent. Files of an earlier result in it are replaced, figures that this one has not are
        removed, others are left alone.
    force : bool
        Replace files of these names that no earlier result put there, too.
    command : str, optional
        The command that the page says makes it again; one of this case, if absent.

    Returns
    -------
    list of Path
        What was written; report.html first.

    Raises
    ------
    InputError
        The folder cannot be written to, or holds somebody's own files of these names. Nothing half-written is left.
    """
    with folder(Path(out), NAMES, force=force) as temporary:
        fill(temporary, found, case, command)
    return written(Path(out))


def fill(into: Path, found: Found, case: Case, command: str | None = None) -> None:
    """Write every file of the report into an existing folder."""
    report = contents(found, case)
    write_text(into / "report.json", json.dumps(report, indent=1, allow_nan=False, ensure_ascii=False) + "\n")
    found.before.save(into / "model_before.toml")
    found.after.save(into / "model_after.toml")
    if isinstance(found, DrivenFound):
        drawings = driven.draw(found, into / "figures")
        write_text(into / "report.html", driven.page(found, case, report, drawings, command))
        return
    if isinstance(found, GeneralFound):
        drawings = general.draw(found, into / "figures")
        write_text(into / "report.html", general.page(found, case, report, drawings, command))
        return
    drawings = draw(found, case, into / "figures")
    write_text(into / "report.html", page(found, case, report, drawings, command))
