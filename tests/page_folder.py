"""The folder in which a reader of a page works: recordings and small cases, simulated in a moment.

A block on a belt with the constants of the paper slider, which sticks and slips a dozen times in 1.4 s.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

import stickslip as ss

ROOT = Path(__file__).parent.parent
RIG = ss.BlockOnBelt(mass=0.0307, stiffness=168.0)
LAW = ss.CoulombFriction(static=0.111, kinetic=0.070)  # N
CASE = """title = "a small case"

[rig]
kind = "block_on_belt"
m = "30.7 g"
k = "168 N/m"

[friction]
kind = "coulomb"
static = 0.11
kinetic = 0.07

[noise]
x1 = 0.001

[channels]
t = { column = "t", unit = "s" }
x1 = { column = "x1", unit = "mm" }
"""


def write_run(
    path: Path, *, speed: float, seed: int, t_end: float = 1.4, effects: tuple[ss.Tabulated, ...] = ()
) -> None:
    """Simulated readings of time [s] and deflection [mm], with 1 um of noise; `speed` in m/s."""
    model, t = ss.Model(RIG, friction=LAW, effects=effects), np.arange(0.0, t_end, 0.00125)
    run = ss.simulate(model, belt_speed=speed, initial=(0, speed), t_end=t_end, t_eval=t)
    x = 1e3 * run.x1 + 1e-3 * np.random.default_rng(seed).standard_normal(t.size)
    np.savetxt(path, np.column_stack([t, x]), "%.6f", ",", header="t [s],x1 [mm]", comments="")


def rough(t_end: float, share: float = 0.03) -> ss.Tabulated:
    """Friction that wanders by a share of itself, from one slip to the next."""
    values = share * np.random.default_rng(3).standard_normal(24)
    return ss.tabulated("contact", "t", np.linspace(0.0, t_end, 24), values)


def prepare(folder: Path) -> None:
    """Write the files that the pages name.

    RUN.csv; ROUGH.csv, whose friction scatters; the case CASE with a run to train on and one to validate; LIGHT, the
    same with a mass declared too small; the recording that comes with the package.
    """
    write_run(folder / "RUN.csv", speed=0.012, seed=0)
    write_run(folder / "ROUGH.csv", speed=0.012, seed=3, t_end=2.4, effects=(rough(2.4),))
    text = CASE
    for name in ("CASE", "LIGHT"):
        (folder / name).mkdir()
    for name, speed, role in (("run_01", 0.012, "train"), ("run_07", 0.014, "validate")):
        write_run(folder / "CASE" / f"{name}.csv", speed=speed, seed=int(name[-1]), t_end=0.95)
        shutil.copy(folder / "CASE" / f"{name}.csv", folder / "LIGHT")
        text += f'\n[[run]]\nfile = "{name}.csv"\nrole = "{role}"\nbelt_speed = "{1e3 * speed:g} mm/s"\n'
    (folder / "CASE" / "rig.toml").write_text(text, encoding="utf-8")
    (folder / "LIGHT" / "rig.toml").write_text(text.replace("30.7 g", "25 g"), encoding="utf-8")
    shutil.copy(ROOT / "examples/paper_slider/k168Nm_v1100.mat", folder)
