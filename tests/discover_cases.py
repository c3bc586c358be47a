"""Small cases made by simulation, for the tests of discovery."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stickslip.declared.effect import AnyEffect, effect
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.declared.units import Channel
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.left import Left, left
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.fitted.data import Data, prepare
from stickslip.likelihoods.fit import null
from stickslip.measured.case import Case
from stickslip.measured.recording import Recording, Role
from stickslip.simulated.simulate import simulate

RIG = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
LAW = PaperFriction(T_s_minus=6.2, T_s_plus=3.5, T_min_minus=1.5, A1=3.0)
SPEEDS = (0.06, 0.13, -0.07, -0.14, 0.1)
FEW = (0.13, -0.14, 0.1)
NOISE = 1e-3


def make_case(
    effects: tuple[AnyEffect, ...] = (),
    *,
    length: float = 48.0,
    dt: float = 0.05,
    noise: float = NOISE,
    seed: int = 1,
    speeds: tuple[float, ...] = SPEEDS,
    crosstalk: float = 0.0,
    jitter: float = 0.0,
    turned: bool = True,
) -> Case:
    """Runs of LAW with effects on the motion; the last is for validation. `crosstalk` adds c y1 to the x1 reading.

    Each run has a phase of its own unless not `turned`.
    """
    rng = np.random.default_rng(seed)
    runs = []
    for i, speed in enumerate(speeds):
        own = tuple(
            one.replace(phi=float(rng.uniform(0, 6))) if turned and "phi" in one.parameters else one
            for one in effects
        )
        t = np.arange(0.0, length, dt)
        t[1:-1] += jitter * dt * rng.uniform(-1, 1, len(t) - 2)
        start = (np.sign(speed) * 0.1, 0.5 * speed, 0.05 * rng.standard_normal(), 0.0)
        model = Model(RIG, friction=LAW, effects=own)
        run = simulate(model, belt_speed=speed, initial=start, t_end=length, t_eval=t, rtol=1e-8, atol=1e-9)
        x1 = run.state[:, 0] + crosstalk * run.state[:, 2] + noise * rng.standard_normal(len(t))
        y1 = run.state[:, 2] + noise * rng.standard_normal(len(t))
        role: Role = "validate" if i == len(speeds) - 1 else "train"
        runs.append(recording(f"run_{i}", role, speed, t, x1, y1, noise))
    channels = {name: Channel(name) for name in ("t", "x1", "y1")}
    return Case(
        "made", RIG, PaperFriction(), {"x1": noise, "y1": noise}, tuple(runs), channels, Path("rig.toml")
    )


def recording(
    name: str, role: Role, speed: float, t: np.ndarray, x1: np.ndarray, y1: np.ndarray, noise: float
) -> Recording:
    """A nondimensional recording."""
    channels = {one: Channel(one) for one in ("t", "x1", "y1")}
    raw = {"t": t, "x1": x1, "y1": y1}
    factors = dict.fromkeys(raw, 1.0)
    given = {"x1": noise, "y1": noise}
    return Recording(name, role, RIG, speed, t, x1, y1, None, raw, channels, factors, given, Path("made.csv"))


def left_by_law(case: Case, data: list[Data] | None = None) -> Left:
    """What the declared law alone, fitted to the train runs, leaves."""
    bench = bench_of(case, prepare(case.train) if data is None else data)
    return left(bench, null(bench.windows(), bench.policy))


def spring_bench() -> BeltBench:
    """Return three short runs of a rig whose spring stiffens, cut into windows."""
    case = make_case((effect("spring_cubic_k1", k=4.0),), length=24.0, speeds=(0.1, -0.12, 0.09))
    return bench_of(case, prepare(case.train))
