"""How often the loop for a driven slider names something that is not there, and whether it finds what is.

    python bench/bench_driven.py PATH/DATA_EMPS.mat [--draws 100] [--planted] [--out FILE.json]

Surrogates: the declared law and the process noise, both fitted to the first half of the record, in the record's own
position loop: same set-point, controller, sampling and encoder step. `--planted` puts one effect at a time into the
same simulation instead. Prints one line a case and a table; the file holds every verdict.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.io import loadmat

import stickslip as ss
from stickslip.declared.model import Model
from stickslip.discovery.driven_slider.loop import discover, model
from stickslip.discovery.driven_slider.search import DrivenSearch
from stickslip.likelihoods.driven_slider.noise import Noise
from stickslip.likelihoods.driven_slider.prepared import balance, declared_mass
from stickslip.measured.case import Case
from stickslip.simulated.driven_slider import Loop, closed_loop

CASE = """title = "EMPS"
[rig]
kind = "driven_slider"
m = 95.1089
[friction]
kind = "coulomb"
[[run]]
file = "DATA_EMPS.mat"
role = "train"
to = 12.42
[[run]]
file = "DATA_EMPS.mat"
role = "validate"
from = 12.42
[channels]
t = {{ column = "t", unit = "s" }}
x1 = {{ column = "qm", unit = "m" }}
drive = {{ column = "vir", unit = "V", scale = {gain!r} }}
"""
QUANTUM = 5e-8  # m, the encoder's step
PLANTED = {
    "viscous_asymmetry": {"c": -10.0},
    "block_quadratic_damping": {"c": 150.0},
    "stribeck_peak": {"dT": 2.0, "v_s": 0.02},
    "viscous_saturation": {"dT": 3.0, "v_s": 0.01},
    "contact_compliance": {"k": 5e4, "c": 0.0},
    "position_load": {"k": 5.0},
    "position_friction": {"r": 0.3},
    "load_drift": {"r": 0.1},
    "friction_drift": {"r": 0.008},
    "drive_gain_drift": {"r": 0.002},
    "drive_nonlinearity": {"q": 1e-4},
    "drive_lag": {"tau": 5e-4},
    "drive_delay": {"delay": 4e-4},
    "position_ripple": {"a": 0.5, "L": 0.005, "phi": 1.0},
    "friction_ripple": {"a": 0.03, "L": 0.004, "phi": 2.0},
    "drive_ripple": {"a": 0.01, "L": 0.0025, "phi": 0.5},
    "harmonic_forcing": {"a": 0.4, "w": 90.0, "phi": 0.3},
    "rig_mass": {"e": 0.01},
}


def main() -> None:
    """Run the bench."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=Path)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed of the first draw")
    parser.add_argument("--planted", action="store_true")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    case, data, declared, noise = fitted(given.data)
    if given.planted:
        rows = []
        for i, (name, numbers) in enumerate(PLANTED.items()):
            truth = declared.with_effects([ss.effect(name, **numbers)])
            (record,) = records(data, truth, noise, [1000 + i])
            rows.append(searched(case, data, record, 1000 + i, name))
        right = sum(row["planted"] in (*row["found"], *row["tied"]) for row in rows)
        alone = sum(row["found"] == [row["planted"]] for row in rows)
        print(f"{right} of {len(rows)} planted effects found or tied; nothing else beside it in {alone}")
    else:
        seeds = list(range(given.first, given.first + given.draws))
        drawn = zip(seeds, records(data, declared, noise, seeds), strict=True)
        rows = [searched(case, data, record, seed, "") for seed, record in drawn]
        named = sum(bool(row["found"]) for row in rows)
        print(f"{named} of {len(rows)} surrogates named something")
    if given.out:
        given.out.write_text(json.dumps(rows, indent=1) + "\n")


def fitted(path: Path) -> tuple[Case, dict[str, np.ndarray], Model, Noise]:
    """The case of the record, its variables, the declared model and the process noise fitted to its first half."""
    data = {k: v.ravel() for k, v in loadmat(path).items() if not k.startswith("__")}
    folder = Path(os.environ.get("TMPDIR", "/tmp")) / f"stickslip_driven_{os.getpid()}"
    folder.mkdir(exist_ok=True)
    (folder / "rig.toml").write_text(CASE.format(gain=float(data["gtau"][0])))
    link = folder / "DATA_EMPS.mat"
    if not link.exists():
        link.symlink_to(path.resolve())
    case = ss.load_case(folder, files_from=path.resolve().parent)
    search = DrivenSearch(balance(case.train, declared_mass(case.rig, case.uncertainty)), lambda _: None)
    return case, data, model(case, search.null), search.null.noise


def records(
    data: dict[str, np.ndarray], truth: Model, noise: Noise, seeds: list[int]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Positions [m] and drives [N] of one simulated record a seed."""
    t = data["t"]
    drawn = [noise.drawn(len(t), np.random.default_rng(seed))[1] for seed in seeds]
    w = truth.rig.mass * np.stack(drawn, axis=1)
    loop = Loop(float(data["gtau"][0]), float(data["kp"][0]), float(data["kv"][0]), quantum=QUANTUM)
    start = (float(data["qm"][0]), float(data["qm"][10] - data["qm"][0]) / (t[10] - t[0]))
    run = closed_loop(truth, loop, t, data["qg"], start=start, noise=w, substeps=4)
    return [(run.x[:, i].copy(), loop.gain * run.command[:, i]) for i in range(len(seeds))]


def searched(
    case: Case, data: dict[str, np.ndarray], record: tuple[np.ndarray, np.ndarray], seed: int, name: str
) -> dict[str, object]:
    """Search one record."""
    began = time.monotonic()
    x, force = record
    t = data["t"]
    runs = []
    for recorded in case.runs:
        at = np.searchsorted(t, recorded.t[0]) + np.arange(len(recorded.t))
        runs.append(replace(recorded, x1=x[at], drive=force[at], findings=()))
    found = discover(replace(case, runs=tuple(runs)), tell=lambda _: None)
    row = {
        "seed": seed,
        "planted": name,
        "found": [e.name for e in found.effects],
        "tied": [a.name for e in found.effects for a in e.alternatives if a.tied],
        "parameters": {e.name: {k: v.value for k, v in e.parameters.items()} for e in found.effects},
        "gain": found.gate.observed,
        "threshold": found.gate.threshold,
        "chi2": [found.residual_before.chi2, found.residual_after.chi2],
        "error": [found.error.before, found.error.after, found.error.floor],
        "seconds": time.monotonic() - began,
    }
    said = f"found {row['found']} tied {row['tied']} gain {row['gain']:.3g} of {row['threshold']:.3g}"
    print(f"{seed:5d} {name or 'nothing':24s} {said}, {row['seconds']:.0f} s", flush=True)
    return row


if __name__ == "__main__":
    main()
