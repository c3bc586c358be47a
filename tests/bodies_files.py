"""A case of a rig of bodies in a folder: rig.toml and runs as a laboratory writes them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PIN = """title = "a pin on a disc"

[rig]
kind = "matrices"
M = [[0.5, 0.0], [0.0, 0.3]]
C = [[0.4, 0.0], [0.0, 0.3]]
K = [[800.0, 90.0], [90.0, 1500.0]]
contact = [1.0, 0.0]
names = ["along", "across"]

[friction]
kind = "coulomb"
static = {static}
kinetic = {kinetic}

[channels]
t = {{ column = "t", unit = "ms" }}
along = {{ column = "x", unit = "mm" }}
across = {{ column = "y", unit = "mm" }}
"""
RUN = """
[[run]]
file = "{file}"
role = "{role}"
belt_speed = "50 mm/s"
"""


def written(
    folder: Path, runs: Sequence[tuple[str, Floats, Floats]], static: float = 3.4, kinetic: float = 2.3
) -> Path:
    """Write runs (role, times, readings) of the pin, in ms and mm, and their rig.toml; return its path."""
    text = PIN.format(static=static, kinetic=kinetic)
    for i, (role, t, readings) in enumerate(runs):
        file = f"run_{i + 1}.csv"
        rows = np.column_stack([1e3 * t, 1e3 * readings])
        np.savetxt(folder / file, rows, delimiter=",", header="t,x,y", comments="", fmt="%.7f")
        text += RUN.format(file=file, role=role)
    (folder / "rig.toml").write_text(text, encoding="utf-8")
    return folder / "rig.toml"
