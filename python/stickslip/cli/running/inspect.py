"""What is done by `stickslip inspect`: what is in a file, before a case is made of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.box import SIMPLE
from rich.markup import escape
from rich.table import Table

from stickslip.cli.printed import console, say_lines, say_table, say_written
from stickslip.declared.units import in_si, same_dimension
from stickslip.errors import quoted
from stickslip.files import chosen
from stickslip.measured.inspection import Column, Inspection
from stickslip.measured.inspection import inspect as look


def perform(file: Path, figure: Path | None, force: bool) -> None:
    """Do what `stickslip inspect` is asked for."""
    drawn = [] if figure is None else _targets(figure)
    with chosen(drawn, {"FILE": file}, force=force, key="--figure"):
        _inspect(file, drawn)


def _inspect(file: Path, drawn: Sequence[Path]) -> None:
    """Say what is in a file, and draw it where that is asked for."""
    found = look(file)
    console.print(
        f"{file}: {'; '.join([found.contents.kind, *found.contents.facts])}", markup=False, soft_wrap=True
    )
    say_table(columns_table(found))
    for line in _of_time(found):
        console.print(line, markup=False, soft_wrap=True)
    if found.doubts:
        console.print("What is doubtful:")
    say_lines([quoted(one, 400) for one in found.doubts])
    if drawn:
        from stickslip.shown.plot.curves import save_figure
        from stickslip.shown.plot.file_columns import columns

        save_figure(columns(found), drawn[0].with_suffix(""))
        say_written(drawn)


def _targets(figure: Path) -> list[Path]:
    """The two files of the figure."""
    stem = figure.with_suffix("") if figure.suffix in (".svg", ".png") else figure
    return [Path(f"{stem}.{kind}") for kind in ("svg", "png")]


def columns_table(found: Inspection) -> Table:
    """The columns, a row each."""
    table = Table(box=SIMPLE, pad_edge=False, show_edge=False)
    table.add_column("column")
    table.add_column("unit")
    for name in ("samples", "first", "least", "greatest"):
        table.add_column(name, justify="right", no_wrap=True)
    for one in found.columns:
        name = escape(quoted(one.head, 60)) + (" (the times)" if one is found.time else "")
        table.add_row(name, escape("?" if one.unit is None else one.unit), *_numbers(one))
    return table


def _numbers(one: Column) -> tuple[str, ...]:
    if one.values is None or not one.values.size:
        return ("no numbers" if one.doubt else "words", "", "", "")
    x = one.values
    return (str(x.size), *(f"{value:.6g}" for value in (x[0], np.min(x), np.max(x))))


def _of_time(found: Inspection) -> list[str]:
    """How long and how dense the times are."""
    if found.time is None or found.time.values is None or found.rate is None:
        return []
    t, unit = found.time.values, found.time.unit
    own = "" if unit is None else f" {unit}"
    rate = f"{found.rate:.6g} samples in 1{own or ', of a unit that the file does not say'}"
    if unit is not None and same_dimension(unit, "s"):
        rate = f"{found.rate / in_si(unit, 's', what='a time'):.6g} samples a second"
    return [f"{found.time.head} lasts {t[-1] - t[0]:.6g}{own} in steps of {1 / found.rate:.6g}{own}: {rate}"]
