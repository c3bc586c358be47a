"""Every effect that moves the rig, at sizes that a laboratory would meet, alone and some together.

Tests that need other sizes have numbers of their own; an effect that they do not name takes those of here.
"""

from __future__ import annotations

from collections.abc import Mapping

import stickslip as ss
from stickslip.declared.catalogue import KINDS

SHAPE = ([-0.3, -0.1, 0, 0.1, 0.3], [0.1, -0.1, 0.15, 0, 0.1])


def one(kind: str, **numbers: float) -> list[ss.Effect]:
    return [ss.effect(kind, **numbers)]


EFFECTS: dict[str, list[ss.Effect | ss.Tabulated]] = {
    "block_viscous_damping": [*one("block_viscous_damping", c=0.3)],
    "block_quadratic_damping": [*one("block_quadratic_damping", c=0.5)],
    "spring_cubic_k1": [*one("spring_cubic_k1", k=3.0)],
    "spring_cubic_k2": [*one("spring_cubic_k2", k=3.0)],
    "spring_cubic_k3": [*one("spring_cubic_k3", k=3.0)],
    "spring_gap_k3": [*one("spring_gap_k3", k=10.0, d=0.05)],
    "constant_load": [*one("constant_load", f=0.3)],
    "harmonic_forcing": [*one("harmonic_forcing", a=0.3, w=1.7, phi=0.3)],
    "pivot_dry_friction": [*one("pivot_dry_friction", f=0.05)],
    "pivot that creeps": [*one("pivot_dry_friction", f=0.05, v_c=0.002)],
    "normal_force_feedback": [*one("normal_force_feedback", beta2=2.0, eta2=1.0)],
    "a normal force that lifts": [*one("normal_force_feedback", beta2=40.0, eta2=1.0)],
    "stribeck_peak": [*one("stribeck_peak", dT=0.8, v_s=0.02)],
    "static_aging": [*one("static_aging", dT=1.0, tau=2.0)],
    "friction_memory": [*one("friction_memory", tau=0.05)],
    "friction_drift": [*one("friction_drift", r=0.001)],
    "belt_seam": [*one("belt_seam", a=0.1, L=2.0, phi=0.1)],
    "contact_compliance": [*one("contact_compliance", k=400.0, c=0.5)],
    "belt_speed_ripple": [*one("belt_speed_ripple", a=0.1, w=4.0, phi=0.2)],
    "belt_load_droop": [*one("belt_load_droop", k=0.004, tau=1.0)],
    "sensor_lag": [*one("sensor_lag", tau=0.2)],
    "a slow lag": [*one("sensor_lag", tau=20.0), *one("sensor_crosstalk", c=0.1)],
    "a table on the block": [ss.tabulated("block", "x1", *SHAPE)],
    "a table on the angle body": [ss.tabulated("angle_body", "y2", *SHAPE)],
    "two tables": [
        ss.tabulated("contact", "v_w", *SHAPE),
        ss.tabulated("block", "x1", [-0.4, 0.1, 0.5], [0.1, -0.15, 0.2]),
    ],
    "a table on the contact": [ss.tabulated("contact", "y1", *SHAPE)],
    "a table in time that repeats": [ss.tabulated("block", "t", [0, 1, 2, 3], [0, 0.2, -0.1, 0], period=3)],
    "a table in time at its own phase": [
        ss.tabulated("contact", "t", [0, 1, 2, 3], [0, 0.2, -0.1, 0], period=3, phi=-2.5)
    ],
    "three at once": [
        *one("belt_speed_ripple", a=0.1, w=4.0, phi=0.2),
        *one("static_aging", dT=1.0, tau=2.0),
        *one("spring_gap_k3", k=10.0, d=0.05),
    ],
}

# numbers of a size that shows within twelve units of time; of a name that is not here, those that it is drawn with
SOON = {
    "c": 0.2, "k": 0.5, "d": 1e-3, "f": 0.1, "a": 0.1, "w": 1.3, "phi": 0.4, "beta2": 0.5, "eta2": 0.3,
    "dT": 0.3, "v_s": 0.1, "tau": 0.5, "r": 0.01, "L": 0.7, "delay": 0.1, "q": 0.1, "e": 0.1,
}  # fmt: skip


def made(name: str, **more: str) -> ss.Effect:
    """An effect at a size that shows soon."""
    kind = KINDS[name]
    own = {"contact_compliance": {"k": 200.0, "c": 1.0}}.get(name, {})
    given = {
        one.name: own.get(one.name, SOON.get(one.name, kind.drawn.get(one.name, 0.0)))
        for one in kind.parameters
        if not one.optional
    }
    return ss.effect(name, **given, **more)


def usual(name: str) -> Mapping[str, float]:
    """The numbers of an effect in EFFECTS; of one that moves no rig on a belt, those that it is drawn with."""
    for term in EFFECTS.get(name, []):
        if isinstance(term, ss.Effect):
            return term.parameters
    return KINDS[name].drawn
