"""Re-simulate cases whose truth is known and report chi-squared per sample: near 1 means that the readings
agree.

Usage: ``python check_readings.py CASES_FOLDER [case_04 ...]`` where the folder has ``answers.json`` (per
case the effects, the true law ``rig``, the noise and the scales). Initial states, hidden states and phases
are fitted to each run: first over a short span, then over the whole.
"""

from __future__ import annotations

import json
import sys
import tomllib
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import rigsim
from readings import Array, simulate
from scipy.optimize import least_squares
from truths import kind

LAW = {"a1": "alpha1", "a2": "alpha2", "b3": "beta3", "e1": "eta1", "e12": "eta12", "coup": "s"}


def values_of(answer: dict[str, Any]) -> tuple[dict[str, float], list[str]]:
    """Simulator's numbers and the names of the phases to fit."""
    values = {LAW.get(k, k): float(v) for k, v in answer["rig"].items()} | {"u_m": 0.28, "u_p": 0.27}
    phases = []
    for effect in answer["effects"]:
        what = kind(effect["name"])
        values |= {what.fields[k]: v for k, v in effect["parameters"].items() if k in what.fields}
        values |= {"pivot_eps": 0.001} if effect["name"] == "pivot_dry_friction" else {}
        phases += [what.phase] if what.phase else []
    return values, phases


def load(folder: Path, scales: dict[str, Any]) -> list[tuple[str, float, Array]]:
    """Runs as (file, belt speed, columns t x1 y1 [belt]) in nondimensional units."""
    rig = tomllib.loads((folder / "rig.toml").read_text())
    unit = 1e-3 / scales["L"] if rig["channels"]["x1"]["unit"] == "mm" else 1.0
    si = rig["channels"]["x1"]["unit"] == "mm"
    time, speed = (scales["w"], 1.0 / (scales["L"] * scales["w"])) if si else (1.0, 1.0)
    runs = []
    for run in rig["run"]:
        data = np.loadtxt(folder / run["file"], delimiter=",", skiprows=1)
        data[:, 0] *= time
        data[:, 1:3] *= unit
        data[:, 3:] *= speed
        runs.append((run["file"], run["belt_speed"] * speed, data))
    return runs


def fit(
    values: dict[str, float], phases: list[str], data: Array, noise: float
) -> tuple[float, float, Array, str]:
    """Chi-squared per sample of x1 and y1 after fitting the start; also the fitted unknowns."""
    hidden = [n for n, on in (("z", "bristle_k"), ("b", "droop_k"), ("lag", "lag_tau")) if values.get(on)]
    t, sign = data[:, 0], np.sign(values["vb"])
    n0 = 12
    slope_x, slope_y = (np.polyfit(t[:n0], data[:n0, i], 2)[1] for i in (1, 2))
    x0, y0 = (np.polyfit(t[:n0], data[:n0, i], 2)[2] for i in (1, 2))

    def model(u: Array, count: int, mode: str) -> tuple[Array, Array]:
        numbers = values | dict(zip(phases, u[4 : 4 + len(phases)], strict=True))
        start = np.zeros(len(rigsim.STATE))
        start[:4] = u[:4]
        for name, value in zip(hidden, u[4 + len(phases) :], strict=True):
            start[{"z": 4, "b": 6, "lag": 7}[name]] = value
        if mode == "stick":
            belt = np.sin(numbers.get("ripple_phi", 0.0)) * numbers.get("ripple_a", 0.0)
            start[1] = values["vb"] * (1.0 + belt) + start[6]
        if values.get("memory_tau"):
            start[5] = 0.0 if mode == "stick" else start[1] - values["vb"]
        x, y, _, _ = simulate(numbers, t[:count], start, h_max=0.01, since=-5.0, extrapolate=True)
        return x, y

    def residual(u: Array, count: int, mode: str) -> Array:
        x, y = model(u, count, mode)
        return np.concatenate([x - data[:count, 1], y - data[:count, 2]]) / noise

    best: tuple[float, Array, str] | None = None
    for mode, phase in product(("stick", "slip"), product(np.arange(8) * np.pi / 4, repeat=len(phases))):
        speed = values["vb"] if mode == "stick" else min(slope_x * sign, values["vb"] * sign - 1e-3) * sign
        u = np.array([x0, speed, y0, slope_y, *phase, *(x0 if h == "lag" else 0.0 for h in hidden)])
        try:
            for count in (120, 400):
                u = least_squares(
                    residual, u, args=(count, mode), x_scale=0.05, loss="soft_l1", max_nfev=15
                ).x
        except (ValueError, np.linalg.LinAlgError):
            continue
        cost = float(np.mean(residual(u, 400, mode) ** 2))
        if best is None or cost < best[0]:
            best = cost, u, mode
    assert best is not None
    _, u, mode = best
    for count in (900, t.size):
        u = least_squares(residual, u, args=(count, mode), x_scale=0.05, loss="soft_l1", max_nfev=20).x
    r = residual(u, t.size, mode).reshape(2, -1) ** 2
    return float(r[0].mean()), float(r[1].mean()), u, mode


def main() -> None:
    folder, chosen = Path(sys.argv[1]), sys.argv[2:]
    for answer in json.loads((folder / "answers.json").read_text())["cases"]:
        if chosen and answer["case"] not in chosen:
            continue
        values, phases = values_of(answer)
        line = []
        for _, vb, data in load(folder / answer["case"], answer["scales"]):
            cx, cy, _u, mode = fit(values | {"vb": vb}, phases, data, answer["noise"])
            line.append(f"{cx:.3f}/{cy:.3f}{mode[1]}")
        names = ",".join(e["name"] for e in answer["effects"]) or "none"
        print(f"{answer['case']} {names:24s} x1/y1: {' '.join(line)}", flush=True)


if __name__ == "__main__":
    main()
