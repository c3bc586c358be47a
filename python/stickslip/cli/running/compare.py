"""What is done by `stickslip compare`: a model against a recording."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from rich.box import SIMPLE
from rich.table import Table

from stickslip.cli.printed import console, say_findings, say_table, say_written
from stickslip.declared.model import load_model
from stickslip.declared.toml_file import write_text
from stickslip.errors import InputError
from stickslip.files import folder
from stickslip.fitted.compare import Comparison
from stickslip.likelihoods.bodies_compare import RigComparison
from stickslip.likelihoods.compare import compare as run
from stickslip.measured.case import load_case
from stickslip.progress import shares

if TYPE_CHECKING:
    from stickslip.fitted.identify import BeltSpeed

WRITTEN = (
    "compare.json",
    *(f"{figure}.{kind}" for figure in ("phase_portrait", "time_series") for kind in ("svg", "png")),
)


def perform(
    model: Path,
    case: Path,
    out: Path,
    belt: BeltSpeed,
    name: str | None,
    files_from: Path | None,
    force: bool,
) -> None:
    """Do what `stickslip compare` is asked for."""
    if _is_case(model) and not _is_case(case):
        words = f"the model comes first: stickslip compare {case} {model} --out {out}"
        raise InputError(words, key="MODEL", value=str(model))
    law, loaded = load_model(model), load_case(case, files_from=files_from)
    first = next((r for r in loaded.runs if r.role == "validate"), loaded.runs[0])
    recording = first if name is None else loaded.run(name)
    say_findings(tuple(f"{recording.name}: {finding}" for finding in recording.findings))
    others = sum(r.role == "validate" for r in loaded.runs) - 1
    if name is None and others > 0:
        console.print(f"{recording.name}, the first of {others + 1} validate runs; --run names another")
    with folder(out, WRITTEN, force=force, inputs=(*loaded.files, model)) as temporary:
        with shares("comparing") as tell:
            result = run(law, recording, belt_speed=belt, progress=tell)
        fill_comparison(result, temporary)
    say_table(comparison_table(result))
    say_verdict(result)
    say_written([out / name for name in WRITTEN])


def comparison_table(c: Comparison | RigComparison) -> Table:
    """Simulated against measured."""
    table = Table(
        title=f"simulated against measured: {c.recording.name}",
        box=SIMPLE,
        pad_edge=False,
        collapse_padding=True,  # 80 columns are enough
        show_edge=False,
    )
    table.add_column("quantity", no_wrap=True)
    for name in ("measured", "simulated", "off by", "scatter"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    for r in c.rows:
        table.add_row(r.quantity, *r.cells, "" if r.unit == "1" else r.unit)
    return table


def say_verdict(c: Comparison | RigComparison) -> None:
    """Print what the comparison comes to."""
    console.print()
    for line in c.verdict():
        console.print(f"- {line}", markup=False)


def fill_comparison(c: Comparison | RigComparison, into: Path) -> None:
    """Write the files of a comparison."""
    from stickslip.shown.plot import curves as plot

    write_text(into / "compare.json", json.dumps(c.to_dict(), indent=1))
    if isinstance(c, RigComparison):
        from stickslip.shown.plot import bodies

        plot.save_figure(bodies.portraits(c), into / "phase_portrait")
        plot.save_figure(bodies.beside(c), into / "time_series")
        return
    plot.save_figure(plot.phase_portrait(c), into / "phase_portrait")
    plot.save_figure(plot.time_series(c), into / "time_series")


def _is_case(path: Path) -> bool:
    """Is it a case's folder or its rig.toml, by the look of it?"""
    if path.is_dir():
        return (path / "rig.toml").is_file()
    return path.is_file() and "[[run]]" in path.read_text(encoding="utf-8", errors="replace")
