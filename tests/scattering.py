"""Records of rigs whose friction differs from event to event: simulated from mid-stick to mid-stick."""

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import stickslip as ss
from stickslip.declared.effect import FormulaEffect

Acting = ss.Effect | ss.Tabulated | FormulaEffect
Floats = NDArray[np.float64]
RIG = {"alpha1": 16.0, "alpha2": 8.0, "beta3": 4.0, "eta1": 0.1, "eta12": 0.2}
DT = 0.1


def record(
    model: ss.Model,
    belt_speed: float,
    events: int,
    scatter: float,
    rng: np.random.Generator,
    warms: Callable[[float], float] = lambda _: 1.0,
) -> tuple[Floats, Floats]:
    """Return times and readings (n, 2) of `events` cycles, each with friction of its own; the belt's speed `warms`."""
    law = model.friction
    state, t, out = (0.1, belt_speed, 0.0, 0.0), 0.0, []
    for _ in range(events):
        level, speed = 1.0 + scatter * rng.standard_normal(), belt_speed * warms(t)
        state = (state[0], speed, *state[2:])
        own = ss.Model(model.rig, friction=scaled(law, level), effects=model.effects)
        run = ss.simulate(own, belt_speed=speed, initial=state, t_end=30.0, t_eval=np.arange(0.0, 30.0, DT))
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


def in_si(off: float) -> dict[str, float]:
    """RIG as constants in SI, J `off` by a share."""
    k2, omega, r = 100.0, 10.0, 0.1
    k1, c1 = k2 * (RIG["alpha1"] - 1), RIG["eta1"] * k2 / omega
    inertia = RIG["alpha2"] * r**2 * k2 / omega**2 * (1 + off)
    si = {"m": (k1 + k2) / omega**2, "J": inertia, "r": r, "k1": k1, "k2": k2, "k3": k2 * (RIG["beta3"] - 1)}
    return si | {"c1": c1, "c2": RIG["eta12"] * k2 / omega - c1, "length": 0.01}


def case(
    folder: Path,
    effects: tuple[Acting, ...],
    scatter: float,
    off: float,
    seed: int,
    *,
    si: bool = False,
    few: bool = False,
    more: str = "",
    warms: Callable[[float], float] = lambda _: 1.0,
) -> Path:
    """
    Write a case whose declared alpha2, or J of a rig in `si`, is `off` by a share; return its rig.toml.

    Parameters
    ----------
    few : half as many runs, and these short
    more : text of further tables
    warms : the belt's speed over its set-point, by time
    """
    rng = np.random.default_rng(seed)
    model = ss.Model(ss.Rig(**RIG), friction=ss.PaperFriction(), effects=effects)
    runs = []
    every = [
        (0.08, "train"),
        (0.15, "train"),
        (-0.1, "train"),
        (-0.2, "train"),
        (0.11, "validate"),
        (-0.14, "validate"),
    ]
    for i, (speed, role) in enumerate(every[::2] if few else every):
        t, readings = record(model, speed, 9 if few else 14, scatter, rng, warms)
        noisy = readings + 1e-3 * rng.standard_normal(readings.shape)
        name = f"run_{i}.csv"
        np.savetxt(folder / name, np.column_stack([t, noisy]), delimiter=",", header="t,x1,y1", comments="")
        runs.append(
            f'[[run]]\nfile = "{name}"\nrole = "{role}"\nbelt_speed = {speed * (0.1 if si else 1.0)}\n'
        )
    declared = in_si(off) if si else {**RIG, "alpha2": RIG["alpha2"] * (1 + off)}
    lines = ['title = "scatter"', "[rig]", *(f"{k} = {v}" for k, v in declared.items())]
    lines += ["[noise]", "x1 = 1e-3", "y1 = 1e-3", *runs, "[channels]"]
    lines += [f'{c} = {{ column = "{c}", unit = "1" }}' for c in ("t", "x1", "y1")]
    lines += [more]
    path = folder / "rig.toml"
    path.write_text("\n".join(lines) + "\n")
    return path


MASS, STIFFNESS, STATIC, KINETIC = 0.9, 1400.0, 8.0, 5.2  # of a block, in SI
FORCE_NOISE = 0.008  # N
SPEEDS = {"run_0": 0.035, "run_1": 0.055, "run_2": 0.09, "run_3": 0.07}  # m/s; the last is not trained on
PERIOD = 2 * math.pi * math.sqrt(MASS / STIFFNESS)
Surface = Callable[[Floats], Floats]  # relative friction at places along the belt


def even(_: Floats) -> Floats:
    """Friction that is the same along the belt."""
    return np.zeros_like(_)


def uneven(scatter: float, length: float, rng: np.random.Generator) -> Surface:
    """A smooth Gaussian field along the belt, by 40 random waves."""
    waves, turn = rng.standard_normal(40) / length, rng.uniform(0, 2 * math.pi, 40)
    size = scatter * math.sqrt(2 / 40)
    return lambda s: size * np.cos(np.multiply.outer(s, waves) + turn).sum(axis=-1)


def block_record(
    model: ss.Model,
    belt_speed: float,
    events: int,
    scatter: float,
    rng: np.random.Generator,
    surface: Surface = even,
    memory: float = 0.0,
) -> tuple[Floats, Floats]:
    """Times and deflections of `events` slips of a block, each with levels of its own on an uneven belt."""
    dt, law = PERIOD / 150, model.friction
    assert isinstance(law, ss.CoulombFriction)
    state: tuple[float, ...] = (0.5 * law.kinetic / model.rig.stiffness, belt_speed)
    t, slid, out = 0.0, 0.0, []
    own = rng.standard_normal(2)
    for _ in range(events):
        own = memory * own + math.sqrt(1 - memory**2) * rng.standard_normal(2)
        static, kinetic = (
            law.static * (1 + scatter * own[0]),
            law.kinetic * (1 + scatter * (0.6 * own[0] + 0.8 * own[1])),
        )
        top = law.static / model.rig.stiffness
        x = np.linspace(-0.2 * top, 1.3 * top, 20)
        field = ss.tabulated("contact", "x1", x, surface(slid + top - x))
        there = ss.Model(
            model.rig,
            friction=ss.CoulombFriction(static=static, kinetic=min(kinetic, static)),
            effects=(*(later(one, t, belt_speed) for one in model.effects), field),
        )
        last = 20 * PERIOD
        run = ss.simulate(
            there, belt_speed=belt_speed, initial=state, t_end=last, t_eval=np.arange(0.0, last, dt)
        )
        begins = run.transitions.t[np.flatnonzero(run.transitions.after == 0)]
        begins = begins[begins > 0.2 * PERIOD][0]
        stop = math.ceil((begins + 0.4 * PERIOD) / dt)
        slid += state[0] + belt_speed * stop * dt - run.state[stop, 0]
        out.append(run.state[:stop, 0])
        state = tuple(float(one) for one in run.state[stop, :2])
        if any("dwell" in one.kind.hidden for one in model.effects if isinstance(one, ss.Effect)):
            state = (*state, stop * dt - begins)  # it has stuck that long
        t += stop * dt
    x = np.concatenate(out)
    return dt * np.arange(len(x)), x


def later(one: Acting, t: float, belt_speed: float) -> Acting:
    """The effect as it is a time later; a formula of no time is the same."""
    if isinstance(one, FormulaEffect):
        return one
    turn = {"belt_seam": lambda p: 2 * math.pi * belt_speed / p["L"]}.get(one.name, lambda p: p.get("w", 0.0))
    if "phi" not in one.parameters:
        return one
    return one.replace(phi=one.parameters["phi"] + turn(one.parameters) * t)


def block_runs(
    folder: Path,
    runs: Iterable[tuple[str, float, list[Acting], tuple[float, float]]],
    end: float,
    rng: np.random.Generator,
) -> Path:
    """
    Write a case of a block's whole runs, `c` for validation; return its rig.toml.

    Parameters
    ----------
    runs : name, speed, what acts beside a Coulomb law, and the start
    end : of each
    rng : of the noise
    """
    t = np.arange(0.0, end, 1.5e-3)
    lines = [f'[rig]\nkind = "block_on_belt"\nm = {MASS}\nk = {STIFFNESS}']
    for name, speed, effects, start in runs:
        rig, law = (
            ss.BlockOnBelt(mass=MASS, stiffness=STIFFNESS),
            ss.CoulombFriction(static=STATIC, kinetic=KINETIC),
        )
        model = ss.Model(rig, friction=law, effects=effects)
        run = ss.simulate(model, belt_speed=speed, initial=start, t_end=end, t_eval=t)
        force = STIFFNESS * run.state[:, 0] + FORCE_NOISE * rng.standard_normal(len(t))
        np.savetxt(
            folder / f"{name}.csv", np.column_stack([t, force]), delimiter=",", header="t,F", comments=""
        )
        role = "validate" if name == "c" else "train"
        lines.append(f'[[run]]\nfile = "{name}.csv"\nrole = "{role}"\nbelt_speed = {speed}')
    lines.append(f'[friction]\nkind = "coulomb"\nstatic = {STATIC}\nkinetic = {KINETIC}')
    lines.append('[channels]\nt = { column = "t", unit = "s" }\nspring_force = { column = "F", unit = "N" }')
    lines.append(f"[noise]\nspring_force = {FORCE_NOISE}")
    (folder / "rig.toml").write_text("\n".join(lines))
    return folder / "rig.toml"


def block_case(
    folder: Path,
    effects: tuple[Acting, ...] = (),
    *,
    few: bool = False,
    more: str = "",
    seed: int,
    scatter: float = 0.02,
    length: float | None = None,
    memory: float = 0.0,
    off: Mapping[str, float] = {},
    read: Callable[[Floats, Floats], Floats] = lambda _, x: x,
) -> Path:
    """
    Write a case of a block whose spring force is recorded; return its rig.toml.

    Parameters
    ----------
    effects : that act
    few : fewer runs, and these short
    more : text of further tables
    seed : of scatter and noise
    scatter : relative, of every event; along the belt where it has a `length`
    memory : correlation of events that follow each other
    off : declared over true `mass` and `stiffness`, and the sensor's `gain`, less 1
    read : what the sensor makes of times and deflections
    """
    rng = np.random.default_rng(seed)
    model = ss.Model(
        ss.BlockOnBelt(mass=MASS, stiffness=STIFFNESS),
        friction=ss.CoulombFriction(static=STATIC, kinetic=KINETIC),
        effects=effects,
    )
    surface = even if length is None else uneven(scatter, length, rng)
    lines = ['title = "block"', "[rig]", 'kind = "block_on_belt"']
    lines += [
        f"m = {MASS * (1 + off.get('mass', 0.0))}",
        f"k = {STIFFNESS * (1 + off.get('stiffness', 0.0))}",
    ]
    for name, speed in [*SPEEDS.items()][1 if few else 0 :]:
        turned = ss.Model(
            model.rig,
            friction=model.friction,
            effects=tuple(
                one.replace(phi=rng.uniform(0, 2 * math.pi)) if "phi" in one.parameters else one
                for one in effects
            ),
        )
        t, x = block_record(
            turned, speed, 8 if few else 15, scatter if length is None else 0.0, rng, surface, memory
        )
        force = STIFFNESS * read(t, x) * (1 + off.get("gain", 0.0)) + FORCE_NOISE * rng.standard_normal(
            len(t)
        )
        np.savetxt(
            folder / f"{name}.csv", np.column_stack([t, force]), delimiter=",", header="t,F", comments=""
        )
        role = "validate" if name == "run_3" else "train"
        lines += ["[[run]]", f'file = "{name}.csv"', f'role = "{role}"', f"belt_speed = {speed}"]
    lines += [
        "[channels]",
        't = { column = "t", unit = "s" }',
        'spring_force = { column = "F", unit = "N" }',
        more,
    ]
    path = folder / "rig.toml"
    path.write_text("\n".join(lines) + "\n")
    return path
