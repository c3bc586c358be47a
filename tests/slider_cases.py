"""Cases of a block on a belt in SI, simulated by the core and written to files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.measured.case import Case, load_case
from stickslip.simulated.simulate import simulate

MASS, STIFFNESS, STATIC, KINETIC = 1.2, 850.0, 6.0, 4.2  # kg, N/m, N
NOISE = 1e-5  # m
LAW = CoulombFriction(static=STATIC, kinetic=KINETIC)


def rig_of(ratio: float) -> BlockOnBelt:
    return BlockOnBelt(mass=MASS, stiffness=STIFFNESS, damping=2 * ratio * np.sqrt(MASS * STIFFNESS))


def case_of(
    rig: BlockOnBelt,
    folder: Path,
    *,
    said: Sequence[float | str] = (),
    friction: str = "",
    sign: float = 1.0,
    law: CoulombFriction = LAW,
    length: float = 8.0,
    step: float = 1e-3,
) -> Case:
    """Three runs simulated by the core, at 10, 20 and 30 mm/s times `sign`; `said` is what the case says instead."""
    rng = np.random.default_rng(3)
    model = Model(rig, friction=law)
    declared = friction or f'kind = "coulomb"\nstatic = {STATIC}\nkinetic = {KINETIC}'
    lines = [
        f'[rig]\nkind = "block_on_belt"\nm = {MASS}\nk = {STIFFNESS}\nc = {rig.damping}',
        f"[friction]\n{declared}" if declared != "none" else "",
    ]
    t = np.arange(0, length, step)
    for mm, role, speed in zip(
        (10, 20, 30), ("train", "train", "validate"), said or ("10 mm/s", "20 mm/s", "30 mm/s"), strict=True
    ):
        run = simulate(model, belt_speed=sign * mm * 1e-3, initial=(0, 0), t_end=length, t_eval=t)
        x = run.state[:, 0] + NOISE * rng.standard_normal(len(t))
        np.savetxt(
            folder / f"b{mm}.csv", np.column_stack([t, 1e3 * x]), delimiter=",", header="t,x1", comments=""
        )
        text = f'"{speed}"' if isinstance(speed, str) else speed
        lines.append(f'[[run]]\nfile = "b{mm}.csv"\nrole = "{role}"\nbelt_speed = {text}')
    lines.append('[channels]\nt = { column = "t", unit = "s" }\nx1 = { column = "x1", unit = "mm" }\n')
    (folder / "rig.toml").write_text("\n".join(lines), encoding="utf-8")
    return load_case(folder / "rig.toml")
