"""What is done by `stickslip discover`: what the declared model lacks."""

from __future__ import annotations

import importlib
import re
import shlex
from collections.abc import Iterable
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

import stickslip
from stickslip.cli.printed import console, say_table, say_written
from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.rig import Rig
from stickslip.declared.si import scales_of
from stickslip.discovery.result import Found
from stickslip.discovery.workers import Workers
from stickslip.files import folder
from stickslip.measured.case import Case, load_case
from stickslip.progress import stages
from stickslip.shown.report import words
from stickslip.shown.report.contents import si_text
from stickslip.shown.report.files import NAMES, written
from stickslip.shown.report.units import axes_of

# it takes a second to load, and is not needed before the search has ended
DRAWING = "stickslip.shown.report.write"


def perform(
    case: Path, out: Path, seed: int, threads: int | None, files_from: Path | None, force: bool
) -> None:
    """Do what `stickslip discover` is asked for."""
    loaded = load_case(case, files_from=files_from)
    effects = len(CATALOGUE) if isinstance(loaded.rig, Rig) else 0  # the other rigs' are weighed all at once
    with (
        folder(out, NAMES, force=force, inputs=loaded.files) as temporary,
        stages("discovering", effects) as tell,
    ):
        for finding in folded(loaded.findings):
            tell(f"note: {finding}")
        Workers.load_later(DRAWING)
        found = stickslip.discover(loaded, progress=tell, seed=seed, threads=threads)
        tell("drawing the report")
        importlib.import_module(DRAWING).fill(temporary, found, loaded, _again(case, out, seed, files_from))
    say(found, loaded, console)
    say_written(written(out))


def _again(case: Path, out: Path, seed: int, files_from: Path | None) -> str:
    """The command that makes this result again; --threads changes nothing."""
    words = ["stickslip", "discover", str(case), "--out", str(out)]
    words += ["--seed", str(seed)] if seed else []
    words += ["--files-from", str(files_from)] if files_from else []
    return shlex.join(words)


def folded(findings: Iterable[str]) -> list[str]:
    """Findings, the first of those that differ only in their run and their numbers for all of these."""
    alike: dict[str, list[str]] = {}
    for one in findings:
        alike.setdefault(re.sub(r"\d[\d.e+-]*", "0", one.partition(": ")[2]), []).append(one)
    return [
        first if not more else f"{first} (and alike in {len(more)} other run{'s' if more[1:] else ''})"
        for first, *more in alike.values()
    ]


def say(found: Found, case: Case, to: Console) -> None:
    """Print the verdict, how sure it is, the errors, and what to do next."""
    to.print(f"[bold]{words.headline(found)}[/bold]")
    for line in (*words.sureness(found), words.clean_sentence(found)):
        to.print(f"- {line}", markup=False)
    if found.effects:
        say_table(effects_table(found, case), to)
    say_table(errors_table(found), to)
    for line in found.messages:
        to.print(f"- {line}", markup=False)
    if found.experiments:
        best = found.experiments[0]
        enough = "" if best.sufficient else " (not enough by itself)"
        axis = axes_of(case).x2
        unit = "" if axis.unit == "1" else f" {axis.unit}"
        at = "" if best.belt_speed is None else f" at belt speed {axis.size * best.belt_speed:.3g}{unit}"
        to.print(
            f"Next experiment: {best.what}{at}, to tell {' from '.join(best.between)}{enough}.", markup=False
        )


def effects_table(found: Found, case: Case) -> Table:
    """The effects found, with their numbers and intervals."""
    wrong = all(effect.of_rig for effect in found.effects)
    table = Table(title="wrong in the declared rig" if wrong else "what the declared model lacks")
    table.add_column("number", no_wrap=True)
    si = scales_of(case.rig, case.channels) is not None
    for name in ("value", "95 % interval", *(("in SI",) if si else ())):
        table.add_column(name, justify="right", no_wrap=True)
    for effect in found.effects:
        if not effect.of_rig:
            table.add_row(f"[bold]{effect.name}[/bold]")
        for parameter, one in effect.parameters.items():
            own = (si_text(effect, parameter, case),) if si else ()
            table.add_row(f"  {parameter}", *words.spanned(one), *own)
        if effect.curve is not None:
            table.add_row("  a curve", effect.curve.guess or "-")
    return table


def errors_table(found: Found) -> Table:
    """Error on the validate runs, before and after, with its floor."""
    table = Table(title="error on runs never fitted", caption=found.error.metric)
    table.add_column("run")
    for name in ("before", "after", "floor"):
        table.add_column(name, justify="right")
    for run in found.error.runs:
        table.add_row(
            escape(run.run), *(words.short(run.one_cycle[k], 3) for k in ("before", "after", "floor"))
        )
    e = found.error
    table.add_row("all", *(words.short(v, 3) for v in (e.before, e.after, e.floor)), style="bold")
    return table
