"""Every effect that moves the rig, at sizes that a laboratory would meet, alone and some together."""

from __future__ import annotations

import stickslip as ss

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
