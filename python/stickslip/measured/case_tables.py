"""The tables of the file of a case: their keys, what its runs are called, and what of them must not collide."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

from stickslip.declared.prescribed import Given
from stickslip.declared.toml_file import Document
from stickslip.errors import nearest

LONGEST = 255  # bytes of a file's name on every usual file system


class _Strict(BaseModel):
    """A table of a case: none of its keys is misspelt, and none is of another kind."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


class StepTable(_Strict):
    """A step of a prescribed speed."""

    start: float | str = Field(alias="from")
    value: float | str


def _kind_of_speed(given: object) -> str:
    return "[steps]" if isinstance(given, list) else "[one]"


SpeedGiven = Annotated[
    Annotated[float | str, Tag("[one]")] | Annotated[list[StepTable], Tag("[steps]")],
    Discriminator(_kind_of_speed),
]


class RunTable(_Strict):
    """A [[run]] of a case."""

    file: str
    role: Literal["train", "validate"]
    belt_speed: SpeedGiven | None = None
    drive_speed: SpeedGiven | None = None
    start: float | None = Field(default=None, alias="from")
    end: float | None = Field(default=None, alias="to")
    rig: dict[str, float] = {}
    name: str | None = None

    def speed(self, key: str) -> Given | None:
        """Return "belt_speed" or "drive_speed" as it is written."""
        given = getattr(self, key)
        if isinstance(given, list):
            return [{"from": one.start, "value": one.value} for one in given]
        return given  # type: ignore[no-any-return]


class CaseTable(_Strict):
    """The file rig.toml; what is declared in its tables is checked where it is made."""

    title: str = ""
    rig: dict[str, object]
    friction: dict[str, object] = {}
    law: dict[str, object] = {}
    noise: dict[str, object] = {}
    uncertainty: dict[str, object] = {}
    candidate: list[dict[str, object]] = []
    run: Annotated[list[RunTable], Field(min_length=1)]
    channels: dict[str, dict[str, object]]


def check_runs(document: Document, runs: list[RunTable], allowed: Path) -> None:
    """Refuse names and windows that collide, and files that are not there or lie elsewhere."""
    folder = document.path.parent
    for i, run in enumerate(runs):
        if len(Path(run.file).name) > LONGEST:
            raise document.error("no such file; no name is as long", "run", i, "file", value=run.file)
        if not (folder / run.file).resolve().is_relative_to(allowed.resolve()):
            words = "lies outside the case's folder; copy it there, or name the folder with --files-from"
            raise document.error(words, "run", i, "file", value=run.file)
        if (folder / run.file).is_dir():
            words = "a folder; give the CSV or .mat file of the run"
            raise document.error(words, "run", i, "file", value=run.file)
        if not (folder / run.file).is_file():
            here = {one.name for one in folder.iterdir() if one.suffix in (".csv", ".mat")}
            guess = nearest(run.file, sorted(here - {one.file for one in runs}))
            hint = f"did you mean '{guess}'?" if guess else "give it relative to rig.toml"
            raise document.error(f"no such file; {hint}", "run", i, "file", value=run.file)
        if run.start is not None and run.end is not None and run.start >= run.end:
            raise document.error(f"must be above from = {run.start:g}", "run", i, "to", value=run.end)
        for j, earlier in enumerate(runs[:i]):
            if run.name is not None and earlier.name == run.name:
                raise document.error(
                    f"[[run]] {j + 1} has this name already", "run", i, "name", value=run.name
                )
            if earlier.file != run.file or not _overlap(earlier, run):
                continue
            which = f"[[run]] {j + 1} has these samples already"
            if earlier.role != run.role:
                which += f", as '{earlier.role}'; what is validated must not be trained on"
            else:
                which += "; give each run once, or windows with from and to that do not overlap"
            raise document.error(which, "run", i, "file", value=run.file)


def _overlap(a: RunTable, b: RunTable) -> bool:
    low = max(-float("inf") if one.start is None else one.start for one in (a, b))
    high = min(float("inf") if one.end is None else one.end for one in (a, b))
    return low < high


def told_apart(names: Sequence[str]) -> list[str]:
    """Names of runs, those of several numbered: results are looked up by them."""
    taken, out = set(names), []
    for name in names:
        own = name
        if names.count(name) > 1:
            own = next(one for k in count(1) if (one := f"{name}_{k}") not in taken)
            taken.add(own)
        out.append(own)
    return out


def names_of(runs: Sequence[RunTable]) -> list[str]:
    """Their own, or those of their files and windows; the folders of files that are called alike tell them apart."""
    short = [_name_of(run, Path(run.file).stem) for run in runs]
    given = [run.name is not None for run in runs]
    return told_apart(
        [
            _name_of(run, Path(run.file).with_suffix("").as_posix())
            if short.count(name) > 1 and not own
            else name
            for run, name, own in zip(runs, short, given, strict=True)
        ]
    )


def _name_of(run: RunTable, name: str) -> str:
    """Its own, or that of its file and its window."""
    if run.name is not None:
        return run.name
    name += "" if run.start is None else f"_from_{run.start:g}"
    return name + ("" if run.end is None else f"_to_{run.end:g}")
