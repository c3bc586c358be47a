"""All files of a report at once: made in a folder beside the target, then moved into place."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stickslip.declared.toml_file import write_text
from stickslip.discovery.driven_slider.result import DrivenFound
from stickslip.discovery.result import Found
from stickslip.errors import InputError
from stickslip.measured.case import Case
from stickslip.shown.driven_slider import page as driven
from stickslip.shown.driven_slider.figures import FIGURES as DRIVEN
from stickslip.shown.report.contents import contents
from stickslip.shown.report.page import FIGURES, draw, page


def write_report(found: Found, case: Case, out: str | os.PathLike[str]) -> list[Path]:
    """Write report.json, report.html, model_before.toml, model_after.toml and the figures into a folder.

    Parameters
    ----------
    found : Found
        What `discover` returned.
    case : Case
        What it was given.
    out : path
        Folder; made if absent. Files of these names in it are replaced, figures of an earlier result that this one
        has not are removed, others are left alone.

    Returns
    -------
    list of Path
        What was written; report.html first.

    Raises
    ------
    InputError
        The folder cannot be written to. Nothing half-written is left.
    """
    with folder(Path(out)) as temporary:
        fill(temporary, found, case)
    return written(Path(out))


def written(out: Path) -> list[Path]:
    """The files of a report in a folder; report.html first."""
    figures = sorted(one for one in (out / "figures").glob("*.*") if _ours(one))
    names = ("report.html", "report.json", "model_before.toml", "model_after.toml")
    return [*(out / name for name in names), *figures]


def _ours(figure: Path) -> bool:
    """Whether a figure is one that a report may have; others are somebody's own."""
    return figure.suffix in (".svg", ".png") and figure.stem in {*FIGURES, *DRIVEN}


def fill(into: Path, found: Found, case: Case) -> None:
    """Write every file of the report into an existing folder."""
    report = contents(found, case)
    write_text(into / "report.json", json.dumps(report, indent=1, allow_nan=False, ensure_ascii=False) + "\n")
    found.before.save(into / "model_before.toml")
    found.after.save(into / "model_after.toml")
    if isinstance(found, DrivenFound):
        drawings = driven.draw(found, into / "figures")
        write_text(into / "report.html", driven.page(found, case, report, drawings))
        return
    drawings = draw(found, case, into / "figures")
    write_text(into / "report.html", page(found, case, report, drawings))


@contextmanager
def folder(target: Path) -> Iterator[Path]:
    """A temporary folder beside the target, whose files are moved into the target on success.

    Raises
    ------
    InputError
        The place is a file, or cannot be written to; said before any work is done.
    """
    if target.exists() and not target.is_dir():
        raise InputError("is a file; give a folder", key="--out", value=str(target))
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}."))
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", key="--out", value=str(target)) from None
    try:
        yield temporary
        _move(temporary, target)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", key="--out", value=str(target)) from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _move(temporary: Path, target: Path) -> None:
    if not target.exists():
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o777 & ~mask)
        temporary.rename(target)
        return
    new = {file.relative_to(temporary) for file in temporary.rglob("*")}
    for file in sorted(temporary.rglob("*")):
        if file.is_file():
            there = target / file.relative_to(temporary)
            there.parent.mkdir(parents=True, exist_ok=True)
            file.replace(there)
    for figure in (target / "figures").glob("*.*"):
        if _ours(figure) and figure.relative_to(target) not in new:
            figure.unlink()  # of an earlier result: beside the new page it would tell another story
