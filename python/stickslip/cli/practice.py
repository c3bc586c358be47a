"""Files to practise on: a LabVIEW file of the slider that comes with the package, and small simulated recordings.

The simulated ones are of a block on a belt with the constants of the slider, which sticks and slips a dozen times.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stickslip.data import example

if TYPE_CHECKING:
    from stickslip.declared.effect import Tabulated

MASS, STIFFNESS = 0.0307, 168.0  # kg, N/m
STATIC, KINETIC = 0.111, 0.070  # N
WEIGHT = 0.301167  # N: what makes newtons of the slider's record, its force over its weight
NOISE = 1e-3  # mm, on every reading
RUNS = {"run_01.csv": ("train", 12.0), "run_07.csv": ("validate", 14.0)}  # role, belt speed [mm/s]
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
BODIES = """title = "a slider that a drive pulls by a spring"

[rig]
kind = "bodies"
body.slider.mass = "0.5 kg"  # a table for every body: its mass, or its inertia if it turns

[[rig.link]]                 # a spring and a damper between two bodies, "drive", or "ground"
between = ["slider", "drive"]
stiffness = "500 N/m"
damping = "0.2 N s/m"

[[rig.contact]]              # what rubs: a body against the ground, the belt, or another body
body = "slider"
against = "ground"

[friction]                   # where a fit begins; of several contacts [law.NAME] each
kind = "coulomb"
static = "1.8 N"
kinetic = "1.3 N"

[channels]                   # a position has the name of its body, a velocity v_NAME, an acceleration a_NAME
t = { column = "t", unit = "s" }
slider = { column = "slider", unit = "mm" }

[[run]]
file = "run_01.csv"
role = "train"
drive_speed = "10 mm/s"

[[run]]
file = "run_02.csv"
role = "validate"
drive_speed = "15 mm/s"
"""
LVM = """LabVIEW Measurement\t
Writer_Version\t2
Reader_Version\t2
Separator\tTab
Decimal_Separator\t.
Multi_Headings\tNo
X_Columns\tOne
Time_Pref\tRelative
***End_of_Header***\t
\t
Channels\t1\t
Samples\t{count}\t
Y_Unit_Label\tNewtons\t
Y_Dimension\tForce\t
X_Dimension\tTime\t
X0\t{first:.7f}\t
Delta_X\t{step:.7f}\t
***End_of_Header***\t\t
X_Value\tForce\tComment
"""


def write_lvm(folder: Path) -> None:
    """Write slider.lvm: the recording of the paper slider, as LabVIEW writes a measurement file."""
    import scipy.io

    record = scipy.io.loadmat(example("paper_slider") / "k168Nm_v1100.mat")
    t, force = record["t"].ravel(), WEIGHT * record["Fnorm"].ravel()
    head = LVM.format(count=t.size, first=t[0], step=(t[-1] - t[0]) / (t.size - 1))
    with (folder / "slider.lvm").open("w", encoding="utf-8", newline="\r\n") as file:
        file.write(head)
        np.savetxt(file, np.column_stack([t, force]), "%.7f", "\t")


def write_slider(folder: Path) -> None:
    """Copy the case of the paper slider."""
    for path in sorted(example("paper_slider").iterdir()):
        shutil.copyfile(path, folder / path.name)


def write_simulated(folder: Path) -> None:
    """Write RUN.csv; ROUGH.csv, whose friction scatters; the cases CASE and LIGHT, whose mass is declared too small."""
    write_run(folder / "RUN.csv", speed=12.0, seed=0)
    write_run(folder / "ROUGH.csv", speed=12.0, seed=3, t_end=2.4, effects=(rough(2.4),))
    text = CASE
    for name in ("CASE", "LIGHT"):
        (folder / name).mkdir()
    for name, (role, speed) in RUNS.items():
        write_run(folder / "CASE" / name, speed=speed, seed=int(name[5]), t_end=0.95)
        shutil.copyfile(folder / "CASE" / name, folder / "LIGHT" / name)
        text += f'\n[[run]]\nfile = "{name}"\nrole = "{role}"\nbelt_speed = "{speed:g} mm/s"\n'
    (folder / "CASE" / "rig.toml").write_text(text, encoding="utf-8")
    (folder / "LIGHT" / "rig.toml").write_text(text.replace("30.7 g", "25 g"), encoding="utf-8")


def write_run(
    path: Path, *, speed: float, seed: int, t_end: float = 1.4, effects: tuple[Tabulated, ...] = ()
) -> None:
    """Write simulated readings: time [s], and deflection [mm] with noise; `speed` of the belt in mm/s."""
    from stickslip.declared.friction.coulomb import CoulombFriction
    from stickslip.declared.model import Model
    from stickslip.declared.rig import BlockOnBelt
    from stickslip.simulated.simulate import simulate

    rig, law = (
        BlockOnBelt(mass=MASS, stiffness=STIFFNESS),
        CoulombFriction(static=STATIC, kinetic=KINETIC),
    )
    t, belt = np.arange(0.0, t_end, 0.00125), 1e-3 * speed
    model = Model(rig, friction=law, effects=effects)
    run = simulate(model, belt_speed=belt, initial=(0, belt), t_end=t_end, t_eval=t)
    x = 1e3 * run.x1 + NOISE * np.random.default_rng(seed).standard_normal(t.size)
    np.savetxt(path, np.column_stack([t, x]), "%.6f", ",", header="t [s],x1 [mm]", comments="")


def write_bodies(folder: Path) -> None:
    """Write a case of bodies: a slider that a drive pulls by a spring, and two simulated runs of it."""
    from stickslip.declared.friction.coulomb import CoulombFriction
    from stickslip.declared.model import Model
    from stickslip.declared.rigs.bodies import BodiesRig
    from stickslip.declared.rigs.parts import Body, Contact, Link
    from stickslip.simulated.simulate import simulate

    (folder / "rig.toml").write_text(BODIES, encoding="utf-8")
    rig = BodiesRig(
        body={"slider": Body(mass=0.5)},
        link=[Link(between=("slider", "drive"), stiffness=500.0, damping=0.2)],
        contact=[Contact(body="slider")],
    )
    model = Model(rig, friction=CoulombFriction(static=2.0, kinetic=1.2))
    t = np.arange(0.0, 6.0, 0.004)
    for name, speed, seed in (("run_01", 0.010, 1), ("run_02", 0.015, 2)):
        x = 1e3 * simulate(model, drive_speed=speed, t_end=6.0, t_eval=t).state[:, 0]
        x += NOISE * np.random.default_rng(seed).standard_normal(t.size)
        rows = np.column_stack([t, x])
        np.savetxt(folder / f"{name}.csv", rows, "%.6f", ",", header="t [s],slider [mm]", comments="")


def rough(t_end: float, share: float = 0.03) -> Tabulated:
    """Return friction that wanders by a share of itself, from one slip to the next."""
    from stickslip.declared.effect import tabulated

    values = share * np.random.default_rng(3).standard_normal(24)
    return tabulated("contact", "t", np.linspace(0.0, t_end, 24), values)


PRACTICE: Mapping[
    str, tuple[str, tuple[str, ...], Callable[[Path], None]]
] = {  # what it is; its files; who writes
    "labview": ("slider.lvm, a measured slider of paper on paper", ("slider.lvm",), write_lvm),
    "paper_slider": (
        "the same slider as a case: its MATLAB file and rig.toml",
        ("LICENSE.CeCILL-B.txt", "SOURCE.md", "k168Nm_v1100.mat", "rig.toml"),
        write_slider,
    ),
    "bodies": (
        "a case of a rig of bodies, its rig.toml with comments",
        ("rig.toml", "run_01.csv", "run_02.csv"),
        write_bodies,
    ),
    "practice": (
        "small simulated recordings, RUN.csv and ROUGH.csv, and the cases CASE and LIGHT",
        (
            "RUN.csv",
            "ROUGH.csv",
            *(f"{case}/{name}" for case in ("CASE", "LIGHT") for name in (*RUNS, "rig.toml")),
        ),
        write_simulated,
    ),
}
