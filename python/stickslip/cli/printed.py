"""What every command prints: to one console, findings before the work and files after it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table

console = Console(highlight=False)
WIDEST = 10_000  # columns of a table in a file


def say_table(table: Table, to: Console = console) -> None:
    """Print a table of which nothing is cut.

    Into a file or a pipe it is printed as wide as it is. On a terminal columns that may wrap are made narrower; the
    terminal itself wraps what is still too wide.
    """
    options = to.options.update(width=WIDEST, max_width=WIDEST)
    wide = to.measure(table, options=options).maximum
    for column in table.columns if to.is_terminal else ():
        if not column.no_wrap:
            sizes = [Measurement.get(to, options, cell) for cell in (column.header, *column.cells)]
            wide -= max(one.maximum for one in sizes) - max(one.minimum for one in sizes)
    if wide > to.width:
        to = Console(file=to.file, highlight=False, width=wide, force_terminal=to.is_terminal)
    to.print(table)


def say_findings(findings: Iterable[str]) -> None:
    """Say what is odd about the readings, before anything is made of them."""
    told = tuple(findings)
    if told:
        console.print("What the check of the recordings says:")
    say_lines(told)


def say_lines(lines: Iterable[str]) -> None:
    """Print messages, a line each."""
    for line in lines:
        console.print(f"- {line}", soft_wrap=True, markup=False)


def say_written(paths: Iterable[Path]) -> None:
    """Name the files written."""
    console.print("written:")
    for path in paths:
        console.print(f"  {path}", soft_wrap=True, markup=False)
