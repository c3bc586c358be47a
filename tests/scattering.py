"""Records of a rig whose friction differs from event to event: simulated from mid-stick to mid-stick."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import stickslip as ss

Floats = NDArray[np.float64]
RIG = {"alpha1": 16.0, "alpha2": 8.0, "beta3": 4.0, "eta1": 0.1, "eta12": 0.2}
DT = 0.1


def record(
    model: ss.Model, belt_speed: float, events: int, scatter: float, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Return times and readings (n, 2) of `events` cycles, each with friction of its own."""
    law = model.friction
    state, t, out = (0.1, belt_speed, 0.0, 0.0), 0.0, []
    for _ in range(events):
        level = 1.0 + scatter * rng.standard_normal()
        own = ss.Model(model.rig, friction=scaled(law, level), effects=model.effects)
        run = ss.simulate(
            own, belt_speed=belt_speed, initial=state, t_end=30.0, t_eval=np.arange(0.0, 30.0, DT)
        )
        after = run.transitions.after
        sticks = [i for i, mode in enumerate(after) if mode == 0 and run.transitions.t[i] > 1.0]
        begins = run.transitions.t[sticks[0]]
        ends = run.transitions.t[sticks[0] + 1] if len(after) > sticks[0] + 1 else begins + 1.0
        stop = int(np.ceil(0.5 * (begins + ends) / DT))
        out.append(run.state[:stop][:, [0, 2]])
        state = tuple(float(x) for x in run.state[stop])
        t += stop * DT
    readings = np.concatenate(out)
    return DT * np.arange(len(readings)), readings


def scaled(law: ss.PaperFriction, level: float) -> ss.PaperFriction:
    """Return a law of the same shape, all its forces multiplied."""
    names = ("T_s_minus", "A1", "A2", "T_min_minus", "T_s_plus", "T_min_plus")
    return ss.PaperFriction(**{name: level * getattr(law, name) for name in names})


def case(folder: Path, effects: tuple[ss.Effect, ...], scatter: float, off: float, seed: int) -> Path:
    """Write a case whose declared alpha2 is `off` by a share; return its rig.toml."""
    rng = np.random.default_rng(seed)
    model = ss.Model(ss.Rig(**RIG), friction=ss.PaperFriction(), effects=effects)
    runs = []
    for i, (speed, role) in enumerate(
        [
            (0.08, "train"),
            (0.15, "train"),
            (-0.1, "train"),
            (-0.2, "train"),
            (0.11, "validate"),
            (-0.14, "validate"),
        ]
    ):
        t, readings = record(model, speed, 14, scatter, rng)
        noisy = readings + 1e-3 * rng.standard_normal(readings.shape)
        name = f"run_{i}.csv"
        np.savetxt(folder / name, np.column_stack([t, noisy]), delimiter=",", header="t,x1,y1", comments="")
        runs.append(f'[[run]]\nfile = "{name}"\nrole = "{role}"\nbelt_speed = {speed}\n')
    declared = {**RIG, "alpha2": RIG["alpha2"] * (1 + off)}
    lines = ['title = "scatter"', "[rig]", *(f"{k} = {v}" for k, v in declared.items())]
    lines += ["[noise]", "x1 = 1e-3", "y1 = 1e-3", *runs, "[channels]"]
    lines += [f'{c} = {{ column = "{c}", unit = "1" }}' for c in ("t", "x1", "y1")]
    path = folder / "rig.toml"
    path.write_text("\n".join(lines) + "\n")
    return path
