"""Rigs of other kinds that move in cycles, and the monodromy of a cycle by differences."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

import stickslip as ss

Floats = NDArray[np.float64]
LEINE = ss.HyperbolicFriction(scale=1, decay=3)


def lugre() -> tuple[ss.Model, Mapping[str, float]]:
    law = ss.LuGreFriction(sigma0=1e3, sigma1=30, sigma2=0.4, F_c=1, F_s=1.5, v_s=0.1)
    return ss.Model(ss.BlockOnBelt(mass=1, stiffness=2), friction=law), {"belt_speed": 0.1}


def two_blocks() -> tuple[ss.Model, Mapping[str, float]]:
    """One of them sticks where the cycle is cut."""
    rig = ss.BodiesRig(
        body={"a": ss.Body(mass=1), "b": ss.Body(mass=1.3)},
        link=[
            *(ss.Link(between=(one, "ground"), stiffness=1, damping=0.1) for one in "ab"),
            ss.Link(between=("a", "b"), stiffness=0.8, damping=0.05),
        ],
        contact=[ss.Contact(body=one, against="belt") for one in "ab"],
    )
    return ss.Model(rig, friction=LEINE), {"belt_speed": 0.2}


def three_blocks() -> tuple[ss.Model, Mapping[str, float]]:
    names = ("p", "q", "r")
    leaves = zip(names, (1.0, 1.2, 0.9), strict=True)
    links = [ss.Link(between=(one, "ground"), stiffness=k, damping=0.6) for one, k in leaves]
    rig = ss.BodiesRig(
        body={one: ss.Body(mass=1) for one in names},
        link=[
            *links,
            *(ss.Link(between=pair, stiffness=0.5, damping=0.4) for pair in (("p", "q"), ("q", "r"))),
        ],
        contact=[ss.Contact(body=one, against="belt") for one in names],
    )
    return ss.Model(rig, friction=LEINE), {"belt_speed": 0.1}


def drill() -> tuple[ss.Model, Mapping[str, float]]:
    rig = ss.BodiesRig(
        body={"table": ss.Body(inertia=0.35), "bit": ss.Body(inertia=0.04)},
        link=[
            ss.Link(between=("table", "bit"), stiffness=12, damping=0.01),
            ss.Link(between=("table", "drive"), stiffness=80, damping=0.5),
        ],
        contact=[ss.Contact(body="bit", against="ground", law="bit_law")],
    )
    return ss.Model(rig, friction={"bit_law": ss.StribeckFriction(F_c=1.2, F_s=2, v_s=1.0)}), {
        "drive_speed": 1.26
    }


def by_differences(cycle: ss.LimitCycle, speeds: Mapping[str, float], step: float) -> Floats:
    """The change of the state after a period, of runs from disturbed starts."""
    columns = []
    for k in range(len(cycle.state)):
        ends = []
        for by in (2, 1, -1, -2):
            z = cycle.state.copy()
            z[k] += by * step
            run = ss.simulate(
                cycle.model, initial=z, t_end=cycle.period, t_eval=[cycle.period], rtol=1e-13, atol=1e-15,
                contact=cycle.contact, **speeds,  # type: ignore[arg-type]
            )  # fmt: skip
            ends.append(np.concatenate([run.state[0], *([run.hidden[name][0]] for name in run.hidden_names)]))
        columns.append((8 * (ends[1] - ends[2]) - (ends[0] - ends[3])) / (12 * step))
    return np.array(columns).T
