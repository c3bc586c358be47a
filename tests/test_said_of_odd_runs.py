"""Names of runs that look like markup are said as they are."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from rich.console import Console

import found_by_hand
import stickslip as ss
from stickslip.cli.running.check import runs_table
from stickslip.cli.running.discover import errors_table

NAME = "run [/4] [bold]x"


def printed(table: object) -> str:
    console = Console(width=200)
    with console.capture() as read:
        console.print(table)
    return read.get()


def test_the_name_of_a_run_is_no_markup(tmp_path: Path) -> None:
    """A search of minutes ended in a traceback at its table of errors; `check` lost what stood in brackets."""
    case = ss.load_case(found_by_hand.write_case(tmp_path, si=True))
    found = found_by_hand.found(case, verdict="effect_found")
    runs = tuple(dataclasses.replace(one, run=NAME) for one in found.error.runs)
    odd: Any = dataclasses.replace(found, error=dataclasses.replace(found.error, runs=runs))
    assert NAME in printed(errors_table(odd))
    look = SimpleNamespace(
        name=NAME, role="train", belt_speed=0.1, sticks=3, minus=2, plus=0, samples=12.0, size=30.0
    )
    told: Any = SimpleNamespace(looks=[look])
    assert NAME in printed(runs_table(told, case))
