"""Rigs of bodies as laboratories have them: declared to the package, and once more for the simulator apart from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import stickslip as ss
from bodies_lab import Laboratory, at_rest, coulomb, riding, stribeck

Floats = NDArray[np.float64]
Force = Callable[[float, Floats], Floats]


@dataclass(frozen=True)
class Case:
    """A rig, what moves it, and its readings."""

    model: ss.Model
    laboratory: Callable[..., Laboratory]
    speeds: Mapping[str, float]
    initial: Floats
    dt: float
    settling: float  # what is left out at the start
    lasts: float
    channels: tuple[str, ...]
    noise: float
    scales: Mapping[str, float] = field(default_factory=dict)


def drill() -> Case:
    """A table turned through a shaft, and a bit that rubs on the ground."""
    speed, J, k, c = 1.26, (0.35, 0.04), (12.0, 80.0), (0.01, 0.5)
    rig = ss.BodiesRig(
        body={"table": ss.Body(inertia=J[0]), "bit": ss.Body(inertia=J[1])},
        link=[
            ss.Link(between=("table", "bit"), stiffness=k[0], damping=c[0]),
            ss.Link(between=("table", "drive"), stiffness=k[1], damping=c[1]),
        ],
        contact=[ss.Contact(body="bit", against="ground", law="bit_law")],
    )
    law = ss.StribeckFriction(F_c=1.2, F_s=2.0, v_s=1.0)

    def laboratory(more: Force | None = None, **other: object) -> Laboratory:
        def pulled(t: float, z: Floats) -> Floats:
            force = np.array([k[1] * speed * t + c[1] * speed, 0.0])
            return force if more is None else force + more(t, z)

        return Laboratory(
            M=np.diag(J),
            C=np.array([[c[0] + c[1], -c[0]], [-c[0], c[0]]]),
            K=np.array([[k[0] + k[1], -k[0]], [-k[0], k[0]]]),
            D=np.array([[0.0, 1.0]]),
            laws=[stribeck(1.2, 2.0, 1.0)],
            kinetic=[],
            static=[],
            V=[at_rest],
            force=np.zeros(2),
            more=pulled,
            **other,  # type: ignore[arg-type]
        )

    channels = ("table", "bit")
    return Case(ss.Model(rig, friction={"bit_law": law}), laboratory, {"drive_speed": speed}, np.zeros(4),
                0.01, 0.0, 40.0, channels, 1e-3)  # fmt: skip


def chain() -> Case:
    """Three blocks on a belt, each held by a leaf spring and tied to its neighbours (Burridge and Knopoff 1967)."""
    speed, m, leaf, tie, damping = 0.1, (1.0, 1.1, 0.9), (40.0, 36.0, 44.0), 30.0, 0.1
    names = ("a", "b", "c")
    links = [
        ss.Link(between=(name, "ground"), stiffness=k, damping=damping)
        for name, k in zip(names, leaf, strict=True)
    ]
    links += [ss.Link(between=pair, stiffness=tie) for pair in (("a", "b"), ("b", "c"))]
    rig = ss.BodiesRig(
        body={name: ss.Body(mass=size) for name, size in zip(names, m, strict=True)},
        link=links,
        contact=[ss.Contact(body=name, against="belt", law="rubber") for name in names],
    )
    law = ss.StribeckFriction(F_c=3.0, F_s=5.0, v_s=0.2)
    K = np.diag(leaf) + tie * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])

    def laboratory(more: Force | None = None, **other: object) -> Laboratory:
        return Laboratory(
            M=np.diag(m), C=damping * np.eye(3), K=K, D=np.eye(3), laws=[stribeck(3.0, 5.0, 0.2)] * 3,
            kinetic=[], static=[], V=[riding(speed)] * 3, force=np.zeros(3), more=more, **other,  # type: ignore[arg-type]
        )  # fmt: skip

    return Case(ss.Model(rig, friction={"rubber": law}), laboratory, {"belt_speed": speed},
                np.array([0.02, -0.01, 0.0, speed, speed, speed]), 0.01, 5.0, 60.0, names, 1e-4)  # fmt: skip


def pin() -> Case:
    """A pin on a disc whose arm has a mode across the disc too, by its matrices."""
    speed = 0.05
    M, C, K = [[0.5, 0.0], [0.0, 0.3]], [[0.4, 0.0], [0.0, 0.3]], [[800.0, 90.0], [90.0, 1500.0]]
    rig = ss.MatricesRig(M=M, C=C, K=K, contact=[1.0, 0.0], names=["along", "across"])
    law = ss.CoulombFriction(static=4.0, kinetic=2.0)

    def laboratory(more: Force | None = None, **other: object) -> Laboratory:
        return Laboratory(
            M=np.array(M), C=np.array(C), K=np.array(K), D=np.array([[1.0, 0.0]]),
            laws=[coulomb(4.0, 2.0)], kinetic=[], static=[], V=[riding(speed)], force=np.zeros(2), more=more,
            **other,  # type: ignore[arg-type]
        )  # fmt: skip

    return Case(ss.Model(rig, friction=law), laboratory, {"belt_speed": speed}, np.array([0.0, 0.0, speed, 0.0]),
                0.002, 0.5, 12.0, ("along", "across"), 1e-5)  # fmt: skip


CASES: Mapping[str, Callable[[], Case]] = {"drill": drill, "chain": chain, "pin": pin}


def one_block() -> ss.BodiesRig:
    """A block on a belt by its parts: 0.5 kg on 500 N/m."""
    return ss.BodiesRig(
        body={"x": ss.Body(mass=0.5)},
        link=[ss.Link(between=("x", "ground"), stiffness=500.0)],
        contact=[ss.Contact(body="x", against="belt")],
    )


def recorded(
    case: Case,
    seed: int,
    *,
    level: float = 0.0,
    static: float = 0.0,
    noise: float = 1.0,
    more: Force | None = None,
    lasts: float | None = None,
) -> tuple[Floats, Floats]:
    """Times (n,) and readings (n, channels) of a run, with noise."""
    rng = np.random.default_rng(seed)
    laboratory = case.laboratory(more, level_sd=level, static_sd=static, rng=rng)
    times = np.arange(0.0, case.settling + (lasts or case.lasts), case.dt)
    states = laboratory.record(case.initial, times)
    names = case.model.rig.state_names
    read = states[:, [names.index(one) for one in case.channels]]
    kept = times >= case.settling
    return times[kept] - case.settling, read[kept] + noise * case.noise * rng.standard_normal(
        read[kept].shape
    )


def recording(case: Case, t: Floats, readings: Floats, **other: object) -> ss.Recording:
    """The run as the package takes it."""
    columns = {"t": t, **dict(zip(case.channels, readings.T, strict=True))}
    return ss.load_recording(columns, case.model.rig, **case.speeds, **other)  # type: ignore[arg-type]
