"""Draw one case: a rig, a law, its runs, and the effects hidden in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import laboratory
import numpy as np
import rigsim
from numpy.typing import NDArray
from readings import NO_WANDER, Array, simulate
from truths import kind

TABLE_1 = {
    "Ts_m": 5.94, "A1": 3.2345, "A2": 2.8736, "t1": 0.0342, "t2": 0.3053, "Tmin_m": 1.42, "Ts_p": 3.63,
    "Tmin_p": 0.86
}  # fmt: skip
REFERENCE_RIG = {"alpha1": 16.0, "alpha2": 8.0, "beta3": 4.0, "eta1": 0.1, "eta12": 0.2}


@dataclass(frozen=True)
class Conditions:
    """How a case is recorded. The defaults are the ordinary laboratory case."""

    samples: int = 2501
    dt: float = 0.04
    train: tuple[float, ...] = (0.06, 0.10, 0.16, -0.06, -0.10, -0.15)
    validate: tuple[float, ...] = (0.13, -0.08)
    speed_spread: float = 0.1
    spread: float = 0.2  # of the rig and the law around the reference, uniform
    noise: tuple[float, float] = (0.0005, 0.002)
    jitter: float = 0.0  # of the sampling interval, as a fraction of it
    outliers: float = 0.0  # share of samples
    si: bool | None = None  # None: by lot
    belt: bool | None = None
    declare_friction: bool | None = None
    declare_noise: bool | None = None
    odd_units: bool = False
    laboratory: float = 0.0  # size of a laboratory's imperfections, 1 the usual one; 0: a clean room
    name: str = "ordinary"


@dataclass(frozen=True)
class Run:
    """One record, nondimensional: times, readings with noise, and the set-point."""

    role: str
    belt_speed: float
    t: Array
    x1: Array
    y1: Array
    belt: Array | None
    start: Array
    since: float
    phases: dict[str, float]
    modes: NDArray[np.int64]
    wander: Array


@dataclass(frozen=True)
class Case:
    """A drawn case: nondimensional truth, scales and runs."""

    effects: list[dict[str, Any]]
    values: dict[str, float]
    noise: float
    scales: dict[str, Any]
    declared: dict[str, float] | None
    declare_noise: bool
    conditions: Conditions
    runs: list[Run] = field(default_factory=list)
    imperfections: laboratory.Imperfections | None = None


def draw_law(rng: np.random.Generator, spread: float) -> dict[str, float]:
    """Rig and friction law around the reference rig and Table 1, kept plausible."""
    while True:
        half = spread / 2
        values = {k: v * rng.uniform(1 - spread, 1 + spread) for k, v in REFERENCE_RIG.items()}
        values |= {k: v * rng.uniform(1 - half, 1 + half) for k, v in TABLE_1.items()}
        values |= {k: TABLE_1[k] * rng.uniform(1 - spread, 1 + spread) for k in ("t1", "t2")}
        values |= {"s": 1.0, "u_m": 0.28, "u_p": 0.27}
        onset = (
            values["Ts_m"]
            - values["A1"] * np.exp(-0.28 / values["t1"])
            - values["A2"] * np.exp(-0.28 / values["t2"])
        )
        if values["eta12"] > 1.3 * values["eta1"] and onset > 1.5 * values["Tmin_m"]:
            return {k: float(v) for k, v in values.items()}


def draw_scales(rng: np.random.Generator, si: bool) -> dict[str, Any]:
    """Length, frequency, stiffness and radius that turn (2.1) into SI."""
    return {
        "on": si,
        "L": float(rng.uniform(0.007, 0.03)),
        "w": float(rng.uniform(8.0, 24.0)),
        "k2": float(rng.uniform(50.0, 400.0)),
        "r": float(rng.uniform(0.05, 0.15)),
    }


def effect_values(effects: Sequence[dict[str, Any]]) -> dict[str, float]:
    """The simulator's numbers of the drawn effects."""
    values: dict[str, float] = {}
    for effect in effects:
        fields = kind(effect["name"]).fields
        values |= {fields[k]: v for k, v in effect["parameters"].items()}
        values |= {"pivot_eps": effect["pivot_eps"]} if "pivot_eps" in effect else {}
    return values


def draw_effects(rng: np.random.Generator, names: Sequence[str]) -> list[dict[str, Any]]:
    """Effects with drawn parameters and the truth a report is held to."""
    drawn = []
    for name in names:
        what = kind(name)
        effect: dict[str, Any] = {
            "name": name,
            "where": what.where,
            "depends_on": list(what.depends_on),
            "parameters": what.draw(rng),
        }
        if name == "pivot_dry_friction":
            effect["pivot_eps"] = float(rng.choice([0.0, 0.001]))
        drawn.append(effect)
    return drawn


def draw_run(
    rng: np.random.Generator,
    values: dict[str, float],
    names: Sequence[str],
    role: str,
    speed: float,
    noise: float,
    c: Conditions,
    lab: laboratory.Imperfections | None = None,
) -> Run:
    """Simulate one record; half of them start in the middle of the motion, the others on a carried block."""
    vb = speed * rng.uniform(1 - c.speed_spread, 1 + c.speed_spread)
    phases = {kind(n).phase: float(rng.uniform(0, 2 * np.pi)) for n in names if kind(n).phase}
    t: Array = np.arange(c.samples, dtype=np.float64) * c.dt
    if c.jitter:
        t[1:] += rng.uniform(-c.jitter, c.jitter, c.samples - 1) * c.dt
    wander = NO_WANDER
    if "contact_wandering_friction" in names:
        steps = rng.standard_normal(int(t[-1]) + 3)
        wander = np.zeros(steps.size)
        for i in range(1, steps.size):
            wander[i] = 0.93 * wander[i - 1] + 0.37 * steps[i]  # unit variance, about 14 time units long
    if lab is not None:
        wander = laboratory.field(rng, abs(vb) * (c.samples * c.dt + 30.0), lab)
    start = np.zeros(len(rigsim.STATE))
    start[0] = np.sign(vb) * rng.uniform(0, 0.15)
    start[1] = vb if rng.random() < 0.5 else vb * rng.uniform(0.0, 1.0)
    start[2] = rng.normal(0, 0.05)
    start[7] = start[0] + values.get("crosstalk_c", 0.0) * start[2]
    numbers = values | phases | {"vb": vb} | ({} if lab is None else laboratory.numbers(rng, lab))
    start[10] = start[2]
    if values.get("memory_tau"):
        start[5] = start[1] - vb
    lead = float(rng.uniform(0.5, 25.0)) if rng.random() < 0.5 else max(0.5, 1.5 * values.get("delay", 0.0))
    if any(values.get(k) for k in ("warm_a", "belt_warm_a", "drift_r", "belt_drift_r")):
        lead = 0.5
    times = np.concatenate([[-lead], t])
    x1, y1, belt, modes = simulate(numbers, times, start, since=-lead, wander=wander)
    x1, y1, belt, modes = x1[1:], y1[1:], belt[1:], modes[1:]
    if not (np.all(np.isfinite(x1)) and np.abs(x1).max() < 3.0):
        raise ArithmeticError("the drawn motion runs away")
    x1, y1, belt = (
        a + s * rng.standard_normal(t.size) for a, s in ((x1, noise), (y1, noise), (belt, 2 * noise))
    )
    for channel in (x1, y1):
        hit = rng.random(t.size) < c.outliers
        channel[hit] += rng.choice([-1, 1], hit.sum()) * rng.uniform(8, 60, hit.sum()) * noise
    if lab is not None:
        x1, y1 = (laboratory.as_read(rng, a, g, noise, lab) for a, g in zip((x1, y1), lab.gains, strict=True))
    return Run(role, float(vb), t, x1, y1, belt, start, -lead, phases, modes, wander)


def draw_case(rng: np.random.Generator, names: Sequence[str], conditions: Conditions) -> Case:
    """A case with the named effects (listed or not)."""
    c = conditions

    def lot(choice: bool | None, share: float) -> bool:
        return bool(rng.random() < share) if choice is None else choice

    for _ in range(30):
        law = draw_law(rng, c.spread)
        effects = draw_effects(rng, names)
        noise = float(np.exp(rng.uniform(*np.log(c.noise))))
        scales = draw_scales(rng, lot(c.si, 0.65))
        belt = lot(c.belt, 0.4)
        declared = {k: TABLE_1[k] for k in TABLE_1} if lot(c.declare_friction, 0.3) else None
        lab = laboratory.draw(rng, c.laboratory) if c.laboratory else None
        case = Case(
            effects,
            law | effect_values(effects),
            noise,
            scales,
            declared,
            lot(c.declare_noise, 0.7),
            c,
            [],
            lab,
        )
        try:
            for role, speeds in (("train", c.train), ("validate", c.validate)):
                case.runs.extend(draw_run(rng, case.values, names, role, v, noise, c, lab) for v in speeds)
        except ArithmeticError:
            continue
        if not belt:
            case.runs[:] = [Run(**(vars(r) | {"belt": None})) for r in case.runs]
        return case
    raise ArithmeticError(f"no bounded motion found for {names}")


def without(values: dict[str, float], names: Sequence[str]) -> dict[str, float]:
    """The same numbers with the named effects taken away."""
    gone = {f for n in names for f in kind(n).fields.values()}
    return {k: v for k, v in values.items() if k not in gone}
