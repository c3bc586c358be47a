"""Read a case's folder into nondimensional numbers, for the rivals; no import of the package."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UNITS = {
    "1": 1.0, "s": 1.0, "ms": 1e-3, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "m/s": 1.0, "mm/s": 1e-3
}  # fmt: skip


@dataclass(frozen=True)
class Record:
    """One run, nondimensional."""

    file: str
    role: str
    belt_speed: float
    t: Array
    x1: Array
    y1: Array


@dataclass(frozen=True)
class Recorded:
    """A case: the rig's numbers, the runs, and the noise where it is declared."""

    rig: dict[str, float]
    runs: list[Record]
    noise: float | None


def nondimensional(rig: dict[str, float]) -> tuple[dict[str, float], float, float]:
    """The numbers of (2.1), the length scale and the angular frequency (1, 1 for a nondimensional rig)."""
    if "alpha1" in rig:
        return {k: float(v) for k, v in rig.items() if k != "coupling"}, 1.0, 1.0
    w = math.sqrt((rig["k1"] + rig["k2"]) / rig["m"])
    k2 = rig["k2"]
    numbers = {
        "alpha1": 1.0 + rig["k1"] / k2,
        "alpha2": w**2 * rig["J"] / (rig["r"] ** 2 * k2),
        "beta3": 1.0 + rig["k3"] / k2,
        "eta1": rig["c1"] * w / k2,
        "eta12": (rig["c1"] + rig["c2"]) * w / k2,
    }
    return numbers, rig["length"], w


def read_case(folder: Path) -> Recorded:
    """Every run of a case."""
    told = tomllib.loads((folder / "rig.toml").read_text())
    rig, length, w = nondimensional(told["rig"])
    channels = told["channels"]
    unit = {name: UNITS[c["unit"]] for name, c in channels.items()}
    speed = unit.get("belt", 1.0) / (length * w)
    runs = []
    for run in told["run"]:
        with (folder / run["file"]).open() as file:
            names = file.readline().strip().split(",")
            data = np.loadtxt(file, delimiter=",")
        column = {n: data[:, names.index(c["column"])] for n, c in channels.items()}
        t = column["t"] * unit["t"] * w
        x1, y1 = (column[n] * unit[n] / length for n in ("x1", "y1"))
        runs.append(Record(run["file"], run["role"], run["belt_speed"] * speed, t, x1, y1))
    noise = told.get("noise", {}).get("x1")
    return Recorded(rig, runs, None if noise is None else float(noise) * unit["x1"] / length)
