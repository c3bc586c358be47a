"""Laboratory cases of a block on a belt whose spring's force is recorded, drawn with the simulator of (2.1).

A block is (2.1) without its second coordinate: coupling and eta1 are 0. Its friction is Coulomb's, so that nothing but
what is hidden depends on the speed. Numbers of answers.json are in SI, as a report's are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import laboratory
import numpy as np
from draw import Conditions, Run, draw_effects, draw_run, effect_values
from truths import MISDECLARED

LISTED = (
    "block_viscous_damping",
    "block_quadratic_damping",
    "spring_cubic_k1",
    "harmonic_forcing",
    "stribeck_peak",
    "static_aging",
    "friction_drift",
    "belt_seam",
    "belt_speed_ripple",
    "belt_load_droop",
    "sensor_lag",
    "sensor_nonlinearity",
    "sensor_drift",
    *MISDECLARED,
)
"""What of the list a block on a belt has, and can tell: with bristles and no friction that falls it would not stick."""
UNLISTED = (
    "block_quadratic_spring",
    "block_end_stop",
    "block_cubic_damping",
    "block_one_way_damping",
    "block_hysteretic_spring",
    "block_pulsating_stiffness",
    "contact_worn_patch",
    "contact_load_by_x1",
    "contact_speed_bump",
    "contact_viscous",
    "contact_warm_up",
    "belt_warm_up",
    "x1_cubic",
)
CONDITIONS = Conditions(train=(0.06, 0.10, 0.16), validate=(0.13,), noise=(0.0008, 0.002), speed_spread=0.15)
ROUGHLY = (5.5, 3.3)  # static and kinetic friction as declared, whatever the truth is
# force, length and time in the unit of a number; of readings of a force those that are of a length are of a force
DIMENSIONS = {
    ("block_viscous_damping", "c"): (1, -1, 1),
    ("block_quadratic_damping", "c"): (1, -2, 2),
    ("spring_cubic_k1", "k"): (1, -3, 0),
    ("harmonic_forcing", "a"): (1, 0, 0),
    ("harmonic_forcing", "w"): (0, 0, -1),
    ("stribeck_peak", "dT"): (1, 0, 0),
    ("stribeck_peak", "v_s"): (0, 1, -1),
    ("static_aging", "dT"): (1, 0, 0),
    ("static_aging", "tau"): (0, 0, 1),
    ("friction_drift", "r"): (0, 0, -1),
    ("belt_seam", "L"): (0, 1, 0),
    ("belt_speed_ripple", "w"): (0, 0, -1),
    ("belt_load_droop", "k"): (-1, 1, -1),
    ("belt_load_droop", "tau"): (0, 0, 1),
    ("sensor_lag", "tau"): (0, 0, 1),
    ("sensor_nonlinearity", "q"): (0, -1, 0),
    ("sensor_drift", "r"): (0, 1, -1),
}


@dataclass(frozen=True)
class BlockCase:
    """
    A drawn case.

    Attributes
    ----------
    effects : with their parameters as the simulator has them
    values : the simulator's numbers
    noise : of the readings
    mass, frequency, length : kg, rad/s and m that turn them into SI
    off : declared over true mass and stiffness
    declare_noise : whether the file has it
    conditions, runs, imperfections : as recorded
    """

    effects: list[dict[str, Any]]
    values: dict[str, float]
    noise: float
    mass: float
    frequency: float
    length: float
    off: tuple[float, float]
    declare_noise: bool
    conditions: Conditions
    runs: list[Run]
    imperfections: laboratory.Imperfections

    @property
    def stiffness(self) -> float:
        """Of the spring, N/m."""
        return self.mass * self.frequency**2

    @property
    def force(self) -> float:
        """The bracket's unit of force, N."""
        return self.stiffness * self.length / self.values["alpha1"]


def draw_block(rng: np.random.Generator) -> dict[str, float]:
    """A block of unit mass and stiffness, with Coulomb's friction in the units of (2.1)."""
    values = {"alpha1": 16.0, "alpha2": 8.0, "beta3": 4.0, "eta1": 0.0, "eta12": 0.2, "s": 0.0}
    for side in ("m", "p"):
        values[f"Ts_{side}"] = rng.uniform(4.6, 6.4)
        values[f"Tmin_{side}"] = values[f"Ts_{side}"] * rng.uniform(0.52, 0.74)
    # what decays with the speed decays at once, so that all speeds have the same friction
    values |= {
        "A1": values["Ts_m"] - values["Tmin_m"],
        "A2": 0.0,
        "t1": 1e9,
        "t2": 1e9,
        "u_m": 0.0,
        "u_p": 1e-9,
    }
    return {name: float(x) for name, x in values.items()}


def draw_case(rng: np.random.Generator, names: Sequence[str], c: Conditions) -> BlockCase:
    """A case with the named effects (listed or not)."""
    for _ in range(30):
        effects = draw_effects(rng, names)
        values = draw_block(rng) | effect_values([e for e in effects if e["name"] not in MISDECLARED])
        noise = float(np.exp(rng.uniform(*np.log(c.noise))))
        mass, frequency, length = (
            float(np.exp(rng.uniform(*np.log(r)))) for r in ((0.1, 2.0), (20.0, 60.0), (0.005, 0.02))
        )
        lab = laboratory.draw(rng, c.laboratory)
        wrong = {e["name"]: e["parameters"]["e"] for e in effects if e["name"] in MISDECLARED}
        off = tuple(
            lab.constants[one] / (1 + wrong.get(name, 0.0))
            for one, name in (("alpha1", "rig_mass"), ("beta3", "rig_stiffness"))
        )
        moving = [n for n in names if n not in MISDECLARED]
        try:
            runs = [
                draw_run(rng, values, moving, role, v, noise, c, lab)
                for role, speeds in (("train", c.train), ("validate", c.validate))
                for v in speeds
            ]
        except ArithmeticError:
            continue
        told = bool(rng.random() < 0.5)
        both = off[0], off[1]
        return BlockCase(effects, values, noise, mass, frequency, length, both, told, c, runs, lab)
    raise ArithmeticError(f"no bounded motion found for {names}")


def write_case(folder: Path, case: BlockCase) -> None:
    """Write rig.toml and the runs of one case."""
    folder.mkdir(parents=True)
    reads = case.stiffness * case.length  # N
    static, kinetic = (one * case.force for one in ROUGHLY)
    lines = [
        f'title = "{folder.name}"', "", "[rig]", 'kind = "block_on_belt"',
        f"m = {case.mass * case.off[0]:.6g}  # kg", f"k = {case.stiffness * case.off[1]:.6g}  # N/m", "",
        "[friction]", 'kind = "coulomb"', f"static = {static:.4g}", f"kinetic = {kinetic:.4g}",
    ]  # fmt: skip
    if case.declare_noise:
        lines += ["", "[noise]", f"spring_force = {case.noise * reads:.4g}"]
    for i, run in enumerate(case.runs, 1):
        file = f"run_{i:02d}.csv"
        speed = run.belt_speed * case.length * case.frequency
        lines += ["", "[[run]]", f'file = "{file}"', f'role = "{run.role}"', f"belt_speed = {speed:.8g}"]
        columns = np.column_stack([run.t / case.frequency, run.x1 * reads])
        np.savetxt(folder / file, columns, "%.8g", ",", header="t,F", comments="")
    lines += ["", "[channels]", 't = { column = "t", unit = "s" }']
    lines += ['spring_force = { column = "F", unit = "N" }', ""]
    (folder / "rig.toml").write_text("\n".join(lines))


def answer_of(name: str, group: str, case: BlockCase) -> dict[str, Any]:
    """The truth about one case, in the order a scorer wants it."""
    return {
        "case": name,
        "class": group,
        "conditions": case.conditions.name,
        "effects": [e | {"parameters": in_si(case, e["name"], e["parameters"])} for e in case.effects],
        # every speed is positive, so that the block slips with v_w < 0
        "law": {"static": case.values["Ts_m"] * case.force, "kinetic": case.values["Tmin_m"] * case.force},
        "noise": case.noise * case.stiffness * case.length,
        "off": case.off,
        "laboratory": case.imperfections.told(),
    }


def in_si(case: BlockCase, name: str, parameters: Mapping[str, float]) -> dict[str, float]:
    """An effect's numbers in SI."""
    units = (case.force, case.length, 1.0 / case.frequency)
    if name.startswith("sensor_"):  # what is read is a force
        units = (case.force, case.stiffness * case.length, 1.0 / case.frequency)
    out = {}
    for key, value in parameters.items():
        powers = DIMENSIONS.get((name, key), (0, 0, 0))
        out[key] = float(value * np.prod([u**p for u, p in zip(units, powers, strict=True)]))
    return out
