"""What every command prints: to one console, findings before the work and files after it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rich.console import Console

console = Console(highlight=False)


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
