"""What is done by `stickslip check`: what the runs of a case can tell, before a long search."""

from __future__ import annotations

from pathlib import Path

from rich.box import SIMPLE
from rich.markup import escape
from rich.table import Table

from stickslip.cli.printed import console, say_findings, say_lines, say_table
from stickslip.declared.scale import scales
from stickslip.fitted.can_tell import Telling, can_tell
from stickslip.measured.case import Case, load_case


def perform(case: Path, files_from: Path | None) -> None:
    """Do what `stickslip check` is asked for."""
    loaded = load_case(case, files_from=files_from)
    say_findings(loaded.findings)
    told = can_tell(loaded)
    say_table(runs_table(told, loaded))
    lacks = [*told.lacks, *ties(told)]
    if told.told:
        console.print("The runs can tell:")
    say_lines(told.told)
    console.print("The runs cannot tell:" if lacks else "Nothing speaks against a search.")
    say_lines(lacks)


def runs_table(told: Telling, case: Case) -> Table:
    """The runs, a row each."""
    belt = scales(case.rig, case.channels)["belt"]
    table = Table(box=SIMPLE, pad_edge=False, show_edge=False)
    table.add_column("run", overflow="fold")  # the ends of names tell runs apart
    table.add_column("role", no_wrap=True)
    for name in ("belt speed", "sticks", "slips", "samples a slip", "slip over noise"):
        table.add_column(name, justify="right")
    for one in told.looks:
        table.add_row(
            escape(one.name),
            one.role,
            belt.of(one.belt_speed, 4),
            str(one.sticks),
            str(one.minus + one.plus),
            f"{one.samples:g}",
            f"{one.size:.3g}" if one.size < 100 else f"{one.size:.0f}",
        )
    return table


def ties(told: Telling) -> list[str]:
    """What the algebra says of effects, a sentence each."""
    lines = []
    for name, share in told.hidden.items():
        lines.append(f"{name}: the numbers of the friction law take up {_rest(share)} of its force")
    for (one, other), share in told.alike.items():
        lines.append(
            f"{one} and {other} act alike: beside the friction law {_rest(share)} of their force is the same"
        )
    return lines


def _rest(share: float) -> str:
    """What is left beside a share."""
    return "all" if share < 0.005 else f"{100 * (1 - share):.0f} %"
