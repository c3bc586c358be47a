"""Laboratory cases of rigs that are not the named ones: a drill string, a chain of blocks, a pin on a disc with an arm.

The motion is the package's core's; what makes a laboratory of it is drawn here: friction of every contact anew at each
stick, constants and gains a little off from what is declared, set-points a little off, noise of the readings.

Over 400 lines: half of it is the three rigs as their files have them, which are read beside what is drawn of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stickslip as ss
from stickslip import _core
from stickslip.declared.effect import Effect
from stickslip.declared.formula.value import value
from stickslip.declared.places import seen
from stickslip.simulated.bodies_lowering import lower_bodies
from stickslip.simulated.general import general

Array = NDArray[np.float64]
LEVEL, STATIC = 0.02, 0.02  # relative scatter of friction as a whole, and of the static limit beside it
OFF = {
    "inertia": 0.01,
    "stiffness": 0.01,
    "damping": 0.10,
}  # standard deviation of true over declared constants
GAIN, SPEED = 0.003, 0.002  # of gains, and of the speed of a run
RUNS = (("train", 1.0), ("train", 1.25), ("validate", 1.1))  # role, and speed over the usual one


@dataclass(frozen=True)
class Plan:
    """A rig as it is declared, and how it is run: everything in SI."""

    rig: Any
    laws: Mapping[str, Any]  # by name; of a rig of matrices the one law, as "friction"
    table: str  # [rig] and [law.*] as a file has them
    moved: str  # "belt_speed" or "drive_speed"
    speed: float
    channels: Mapping[str, tuple[str, float]]  # coordinate: unit, and its size in SI
    noise: float
    dt: float
    lasts: float
    settling: float
    effects: tuple[tuple[str, str, Callable[[np.random.Generator], Mapping[str, float]]], ...]
    start: Mapping[str, float] = field(default_factory=dict)
    others: tuple[
        tuple[str, str, Callable[[np.random.Generator], Mapping[str, float]]], ...
    ] = ()  # drawn if asked for
    # place, and its formula
    unlisted: tuple[tuple[str, Callable[[np.random.Generator], Mapping[str, Any]]], ...] = ()


def _of(
    acts: str, formula: str, **ranges: tuple[float, float]
) -> Callable[[np.random.Generator], Mapping[str, Any]]:
    """Return what draws an effect that is on no list: what it does, by a formula, its numbers from their ranges."""

    def drawn(rng: np.random.Generator) -> Mapping[str, Any]:
        return {acts: formula, **{name: float(rng.uniform(*one)) for name, one in ranges.items()}}

    return drawn


def _sizes(**ranges: tuple[float, float]) -> Callable[[np.random.Generator], Mapping[str, float]]:
    def drawn(rng: np.random.Generator) -> Mapping[str, float]:
        return {name: float(rng.uniform(*one)) for name, one in ranges.items()}

    return drawn


TURN = (0.0, 6.28)


def drill() -> Plan:
    """A table turned by a drive through a spring, a bit that rubs on the ground."""
    rig = ss.BodiesRig(
        body={"table": ss.Body(inertia=0.35), "bit": ss.Body(inertia=0.04)},
        link=[
            ss.Link(between=("table", "bit"), stiffness=12.0, damping=0.01),
            ss.Link(between=("table", "drive"), stiffness=80.0, damping=0.5),
        ],
        contact=[ss.Contact(body="bit", against="ground", law="bit_law")],
    )
    table = """[rig]
kind = "bodies"
[rig.body.table]
inertia = 0.35
[rig.body.bit]
inertia = 0.04
[[rig.link]]
between = ["table", "bit"]
stiffness = 12.0
damping = 0.01
[[rig.link]]
between = ["table", "drive"]
stiffness = 80.0
damping = 0.5
[[rig.contact]]
body = "bit"
against = "ground"
law = "bit_law"
[law.bit_law]
kind = "stribeck"
F_c = 1.3
F_s = 1.9
v_s = 1.2
"""
    laws = {"bit_law": ss.StribeckFriction(F_c=1.2, F_s=2.0, v_s=1.0)}
    effects = (
        ("spring_cubic_k1", "link_1", _sizes(k=(80.0, 140.0))),
        ("sensor_lag", "bit", _sizes(tau=(0.015, 0.03))),
        ("harmonic_forcing", "table", _sizes(a=(0.3, 0.5), w=(20.0, 30.0), phi=TURN)),
    )
    channels = {"table": ("deg", np.pi / 180), "bit": ("deg", np.pi / 180)}
    unlisted = (
        ("link_1", _of("force", "-k*deflection*abs(deflection)", k=(30.0, 45.0))),
        ("link_1", _of("force", "k*exp(-(deflection/d)**2)*deflection", k=(12.0, 18.0), d=(0.12, 0.2))),
    )
    others = (("pivot_dry_friction", "link_1", _sizes(f=(0.08, 0.15))),)
    return Plan(
        rig,
        laws,
        table,
        "drive_speed",
        1.26,
        channels,
        1e-3,
        0.01,
        10.0,
        4.0,
        effects,
        others=others,
        unlisted=unlisted,
    )


def chain() -> Plan:
    """Two blocks on a belt, each held by a leaf spring, tied to each other (Burridge and Knopoff 1967)."""
    rig = ss.BodiesRig(
        body={"a": ss.Body(mass=1.0), "b": ss.Body(mass=1.1)},
        link=[
            ss.Link(between=("a", "ground"), stiffness=40.0, damping=0.2),
            ss.Link(between=("b", "ground"), stiffness=36.0, damping=0.2),
            ss.Link(between=("a", "b"), stiffness=20.0),
        ],
        contact=[ss.Contact(body=name, against="belt", law="rubber") for name in ("a", "b")],
    )
    table = """[rig]
kind = "bodies"
[rig.body.a]
mass = 1.0
[rig.body.b]
mass = 1.1
[[rig.link]]
between = ["a", "ground"]
stiffness = 40.0
damping = 0.2
[[rig.link]]
between = ["b", "ground"]
stiffness = 36.0
damping = 0.2
[[rig.link]]
between = ["a", "b"]
stiffness = 20.0
[[rig.contact]]
body = "a"
against = "belt"
law = "rubber"
[[rig.contact]]
body = "b"
against = "belt"
law = "rubber"
[law.rubber]
kind = "stribeck"
F_c = 3.2
F_s = 4.8
v_s = 0.25
"""
    laws = {"rubber": ss.StribeckFriction(F_c=3.0, F_s=5.0, v_s=0.2)}
    effects = (
        ("spring_cubic_k1", "link_1", _sizes(k=(600.0, 1000.0))),
        ("sensor_lag", "b", _sizes(tau=(0.01, 0.03))),
        ("harmonic_forcing", "b", _sizes(a=(0.5, 0.9), w=(9.0, 14.0), phi=TURN)),
    )
    channels = {"a": ("mm", 1e-3), "b": ("mm", 1e-3)}
    unlisted = (
        ("link_1", _of("force", "-k*max(deflection - d, 0)", k=(25.0, 40.0), d=(0.08, 0.1))),
        ("link_3", _of("force", "-c*max(deflection_rate, 0)", c=(2.5, 4.0))),
        ("a", _of("factor", "1 - h*exp(-((u - m)/w)**2)", h=(0.2, 0.3), m=(0.35, 0.45), w=(0.1, 0.15))),
    )
    others = (("belt_seam", "a", _sizes(a=(0.08, 0.12), L=(0.3, 0.6), phi=TURN)),)
    return Plan(
        rig,
        laws,
        table,
        "belt_speed",
        0.1,
        channels,
        1e-4,
        0.01,
        9.0,
        4.0,
        effects,
        others=others,
        unlisted=unlisted,
    )


def pin() -> Plan:
    """A pin on a disc whose arm has a mode across the disc too, by its matrices."""
    M, C, K = [[0.5, 0.0], [0.0, 0.3]], [[0.4, 0.0], [0.0, 0.3]], [[800.0, 90.0], [90.0, 1500.0]]
    rig = ss.MatricesRig(M=M, C=C, K=K, contact=[1.0, 0.0], names=["along", "across"])
    table = f"""[rig]
kind = "matrices"
M = {M}
C = {C}
K = {K}
contact = [1.0, 0.0]
names = ["along", "across"]
[friction]
kind = "coulomb"
static = 3.7
kinetic = 2.2
"""
    laws = {"friction": ss.CoulombFriction(static=4.0, kinetic=2.0)}
    effects = (
        ("belt_seam", "contact_1", _sizes(a=(0.08, 0.12), L=(0.03, 0.06), phi=TURN)),
        ("sensor_lag", "across", _sizes(tau=(0.003, 0.006))),
        ("spring_cubic_k1", "along", _sizes(k=(3e6, 6e6))),
    )
    channels = {"along": ("um", 1e-6), "across": ("um", 1e-6)}
    unlisted = (
        ("along", _of("force", "-k*max(deflection - d, 0)", k=(250.0, 400.0), d=(2e-3, 3e-3))),
        ("along", _of("reading", "reading + q*reading**3", q=(2.5e3, 4e3))),
    )
    others = (
        ("pivot_dry_friction", "across", _sizes(f=(0.03, 0.06))),
        ("normal_force_feedback:across", "contact_1", _sizes(beta2=(800.0, 1600.0), eta2=(-3.0, 3.0))),
        ("sensor_crosstalk:across", "along", _sizes(c=(0.03, 0.06))),
    )
    return Plan(
        rig,
        laws,
        table,
        "belt_speed",
        0.05,
        channels,
        1e-5,
        0.002,
        3.0,
        0.5,
        effects,
        others=others,
        unlisted=unlisted,
    )


PLANS: Mapping[str, Callable[[], Plan]] = {"drill": drill, "chain": chain, "pin": pin}


def _true_rig(plan: Plan, rng: np.random.Generator) -> Any:
    numbers = {}
    for name, trait in plan.rig.uncertain.items():
        size = plan.rig.numbers[name] * (1 + OFF[trait] * rng.standard_normal())
        numbers |= dict.fromkeys(plan.rig.tied(name), size)
    return plan.rig.with_numbers(numbers)


def _model(plan: Plan, rig: Any, effects: tuple[Effect, ...]) -> ss.Model:
    """The true model; every contact has a law of its own, which is drawn anew at each of its sticks."""
    if "friction" in plan.laws:
        return ss.Model(rig, friction=plan.laws["friction"], effects=effects)
    contacts = [
        ss.Contact(body=one.body, against=one.against, law=f"own_{i}") for i, one in enumerate(rig.contact)
    ]
    laws = {f"own_{i}": plan.laws[one.law] for i, one in enumerate(rig.contact)}
    own = ss.BodiesRig(body=rig.body, link=rig.link, contact=contacts)
    return ss.Model(own, friction=laws, effects=effects)


class Rig:
    """A rig that runs, its friction drawn anew at each stick."""

    def __init__(self, model: ss.Model, speed: Mapping[str, float], rng: np.random.Generator) -> None:
        self.own = general(model, speed.get("belt_speed"), speed.get("drive_speed"))
        self.lowered, self.rng = lower_bodies(self.own, model), rng
        self.numbers = dict(model.friction.numbers)

    def record(self, initial: Array, times: Array) -> tuple[Array, dict[str, Array]]:
        """States at the times (n, d), and what the sensors read that effects act on."""
        layout, count = self.lowered.layout, self.own.of_rig
        values = self.lowered.started(self.own.start(initial, {}, 0.0))
        for j in range(count):
            self._draw(values, j)
        t, modes, out = 0.0, self.own.modes([2] * count), list[Array]()
        while t < times[-1]:
            asked = times[times > t] if out else times[times >= t]
            raw = _core.simulate_bodies(
                **self.lowered.arguments, values=values, modes=modes, t_start=t, t_end=float(times[-1]),
                t_eval=asked, rtol=1e-9, atol=1e-12, locator=_core.Locator.henon,
                seeds=np.zeros((0, len(values))), max_transitions=1_000_000,
            )  # fmt: skip
            if raw["outcome"] != _core.Outcome.finished:
                raise RuntimeError(f"the rig stops at {raw['t'][-1]}")
            rests = ((raw["transition_before"] != 0) & (raw["transition_after"] == 0))[:, :count]
            first = int(np.argmax(rests.any(axis=1))) if rests.any() else None
            stop = float(times[-1]) if first is None else float(raw["transition_t"][first])
            out.append(raw["state"][np.isin(raw["t"], asked) & (raw["t"] <= stop)])
            if first is None:
                break
            state, after = raw["transition_state"][first], raw["transition_after"][first]
            values[layout["initial"] : layout["initial"] + len(state)] = state
            for j in range(count):
                stays = modes[j] == 0 and after[j] == 0
                values[layout["dwell"] + j] = values[layout["dwell"] + j] + stop - t if stays else 0.0
            for j in np.flatnonzero(rests[first]):
                self._draw(values, int(j))
            t, modes = stop, [int(one) for one in after]
        state = np.concatenate(out)
        return state, self._readings(times, state)

    def _draw(self, values: Array, j: int) -> None:
        """Give a contact the friction of its next event."""
        level, more = 1 + LEVEL * self.rng.standard_normal(), 1 + STATIC * self.rng.standard_normal()
        prefix = f"own_{j}." if any("." in name for name in self.numbers) else ""
        for name, size in self.numbers.items():
            short = name.removeprefix(prefix)
            share = {"F_c": level, "kinetic": level, "F_s": level * more, "static": level * more}.get(short)
            if share is not None and name.startswith(prefix):
                values[self.lowered.layout["parameters"] + self.lowered.places[name]] = size * share

    def _readings(self, t: Array, state: Array) -> dict[str, Array]:
        own, n = self.own, len(self.own.equations.names)
        of = {**seen(state.T, n, t, 0.0, 0.0), **own.effects.numbers}  # type: ignore[arg-type]
        of |= dict(zip(own.hidden, state.T[2 * n :], strict=False))
        return {name: np.asarray(value(tree, of)) for name, tree in own.effects.readings.items()}


def write_case(
    folder: Path,
    plan: Plan,
    seed: int,
    *,
    effect: bool,
    other: int | None = None,
    unlisted: int | None = None,
) -> dict[str, Any]:
    """Write a case; return its truth. With `other` or `unlisted` the effect of that number of these acts."""
    rng = np.random.default_rng([seed, 71])
    rig = _true_rig(plan, rng)
    truth: dict[str, Any] = {"case": folder.name, "effects": []}
    drawn: tuple[str, str, Mapping[str, float]] | None = None
    if effect:
        kind, where, sizes = (
            plan.effects[int(rng.integers(len(plan.effects)))] if other is None else plan.others[other]
        )
        drawn = kind, where, sizes(rng)
        truth["effects"] = [{"name": kind.partition(":")[0], "where": where, "parameters": dict(drawn[2])}]
    formula: ss.FormulaEffect | None = None
    if unlisted is not None:
        where, made = plan.unlisted[unlisted]
        given = made(rng)
        formula = ss.effect("formula", called="hidden", where=where, **given)
        truth["effects"] = [{"name": "unlisted", "where": where, "parameters": {}, "acts": given}]
    gains = {channel: 1 + GAIN * rng.standard_normal() for channel in plan.channels}
    truth["gains"] = gains
    truth["constants"] = {name: float(rig.numbers[name]) for name in plan.rig.uncertain}
    folder.mkdir(parents=True, exist_ok=True)
    text = f'title = "{folder.name}"\n{plan.table}[channels]\nt = {{ column = "t", unit = "s" }}\n'
    for channel, (unit, _) in plan.channels.items():
        text += f'{channel} = {{ column = "{channel}", unit = "{unit}" }}\n'
    for i, (role, share) in enumerate(RUNS):
        effects = ()
        if drawn is not None:
            numbers = dict(drawn[2])
            if "phi" in numbers:
                numbers["phi"] = float(rng.uniform(*TURN))
            name_of, _, by = drawn[0].partition(":")
            effects = (ss.effect(name_of, where=drawn[1], **numbers, **({"by": by} if by else {})),)
        if formula is not None:
            effects = (formula,)
        speed = share * plan.speed
        own = Rig(_model(plan, rig, effects), {plan.moved: speed * (1 + SPEED * rng.standard_normal())}, rng)
        whole = np.arange(0.0, plan.settling + plan.lasts, plan.dt)
        n = len(rig.equations.names)
        still = np.zeros(2 * n)
        if plan.moved == "belt_speed":
            still[n:] = speed * np.array(
                [any(c.direction[k] for c in rig.equations.contacts) for k in range(n)]
            )
        state, read = own.record(still, whole)
        kept = whole >= plan.settling if plan.moved == "belt_speed" else whole >= 0
        columns = [whole[kept] - whole[kept][0]]
        for channel, (_, size) in plan.channels.items():
            x = read.get(channel, state[:, rig.state_names.index(channel)])[kept] * gains[channel]
            columns.append((x + plan.noise * rng.standard_normal(len(x))) / size)
        np.savetxt(folder / f"run_{i + 1}.csv", np.column_stack(columns), delimiter=",", fmt="%.9g",
                   header=",".join(["t", *plan.channels]), comments="")  # fmt: skip
        text += f'[[run]]\nfile = "run_{i + 1}.csv"\nrole = "{role}"\n{plan.moved} = {speed!r}\n'
    (folder / "rig.toml").write_text(text, encoding="utf-8")
    return truth
