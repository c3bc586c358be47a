"""Bad inputs and the one line each gets: a registry, and the table of the docs made from it.

A module of tests/bad_inputs registers what it tries:

    @bad_input("simulate", "a tolerance of 0")
    def tolerance_0(folder: Path) -> None:
        ss.simulate(MODEL, belt_speed=0.1, initial=(0, 0, 0, 0), t_end=1, rtol=0)

The function may write files into `folder`, an empty one, before it does the wrong thing.
test_bad_input.py runs them all; `python tests/bad_input.py` rewrites docs/bad-input.md.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from stickslip.errors import StickslipError

TABLE = Path(__file__).resolve().parent.parent / "docs" / "bad-input.md"
Attempt = Callable[[Path], object]


@dataclass(frozen=True)
class Row:
    area: str
    tried: str
    attempt: Attempt

    def message(self, folder: Path) -> str:
        """Do the wrong thing in `folder` and return the error's line."""
        try:
            self.attempt(folder)
        except StickslipError as error:
            return str(error).replace(f"{folder}/", "")
        raise AssertionError(f"{self.area}: {self.tried}: was accepted")


@cache
def said(row: Row) -> str:
    """Do the wrong thing in a folder of its own and return the error's line."""
    with tempfile.TemporaryDirectory() as folder:
        return row.message(Path(folder))


ROWS: list[Row] = []


def bad_input(area: str, tried: str) -> Callable[[Attempt], Attempt]:
    """Register an attempt under a heading of the table."""

    def register(attempt: Attempt) -> Attempt:
        ROWS.append(Row(area, tried, attempt))
        return attempt

    return register


def load_rows() -> list[Row]:
    """Import every module of tests/bad_inputs and return what they register."""
    here = str(Path(__file__).resolve().parent)
    if here not in sys.path:
        sys.path.insert(0, here)
    import bad_input as registry  # this module under its own name, also when it is run as a script
    import bad_inputs

    for module in sorted(one.name for one in pkgutil.iter_modules(bad_inputs.__path__)):
        importlib.import_module(f"bad_inputs.{module}")
    return registry.ROWS


def table(rows: list[Row]) -> str:
    """Render the page: a table for each area, in the order the areas were met."""
    lines = [
        "# Bad input",
        "",
        "What is tried, and the one line it gets. The tests that try it write this page:",
        "`python tests/bad_input.py`.",
    ]
    for area in dict.fromkeys(row.area for row in rows):
        lines += ["", f"## {area}", "", "| tried | error |", "|---|---|"]
        for row in (one for one in rows if one.area == area):
            message = said(row).replace("|", "\\|")
            lines.append(f"| {row.tried} | `{message}` |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    TABLE.write_text(table(load_rows()), encoding="utf-8")
    print(TABLE)
