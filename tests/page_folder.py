"""The folder in which a reader of a page works: what `stickslip example` writes, all of it in one place."""

from __future__ import annotations

from pathlib import Path

from stickslip.cli.practice import write_lvm, write_simulated
from stickslip.data import example


def prepare(folder: Path) -> None:
    """Write the files that pages name which speak of a reader's own files."""
    write_simulated(folder)
    write_lvm(folder)
    name = "k168Nm_v1100.mat"
    (folder / name).write_bytes((example("paper_slider") / name).read_bytes())
