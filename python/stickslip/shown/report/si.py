"""SI values of the model's numbers, for rigs declared in SI: what each parameter measures, and its unit."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.declared.rig import AnyRig, Rig, Scales
from stickslip.declared.scale import law_dimension

# exponents of (length, omega, k2): value in SI = value * length^a omega^b k2^c
Dimension = tuple[int, int, int]
NUMBER: Dimension = (0, 0, 0)
TIME, RATE = (0, -1, 0), (0, 1, 0)
LENGTH, SPEED = (1, 0, 0), (1, 1, 0)
FORCE, STIFFNESS, DAMPING = (1, 0, 1), (0, 0, 1), (0, -1, 1)

UNITS: Mapping[Dimension, str] = {
    NUMBER: "1",
    TIME: "s",
    RATE: "1/s",  # of a growth; angular frequencies are in rad/s
    LENGTH: "m",
    SPEED: "m/s",
    FORCE: "N",
    STIFFNESS: "N/m",
    DAMPING: "N s/m",
    (-1, -2, 1): "N s^2/m^2",
    (-2, 0, 1): "N/m^3",
    (0, 1, -1): "m/(N s)",
    (-1, 0, 0): "1/m",
    (-1, -1, 0): "s/m",
}
EFFECTS: Mapping[str, Dimension] = {
    "block_viscous_damping.c": DAMPING,
    "block_quadratic_damping.c": (-1, -2, 1),
    "spring_cubic_k1.k": (-2, 0, 1),
    "spring_cubic_k2.k": (-2, 0, 1),
    "spring_cubic_k3.k": (-2, 0, 1),
    "spring_gap_k3.k": STIFFNESS,
    "spring_gap_k3.d": LENGTH,
    "constant_load.f": FORCE,
    "harmonic_forcing.a": FORCE,
    "harmonic_forcing.w": RATE,
    "unlisted.w": RATE,  # of a learned curve that repeats
    "pivot_dry_friction.f": FORCE,
    "pivot_dry_friction.v_c": SPEED,
    "normal_force_feedback.beta2": STIFFNESS,
    "normal_force_feedback.eta2": DAMPING,
    "stribeck_peak.dT": FORCE,
    "stribeck_peak.v_s": SPEED,
    "static_aging.dT": FORCE,
    "static_aging.tau": TIME,
    "friction_memory.tau": TIME,
    "friction_drift.r": RATE,
    "belt_seam.a": NUMBER,
    "belt_seam.L": LENGTH,
    "contact_compliance.k": STIFFNESS,
    "contact_compliance.c": DAMPING,
    "belt_speed_ripple.a": NUMBER,
    "belt_speed_ripple.w": RATE,
    "belt_load_droop.k": (0, 1, -1),
    "belt_load_droop.tau": TIME,
    "sensor_lag.tau": TIME,
    "sensor_delay.delay": TIME,
    "sensor_crosstalk.c": NUMBER,
    "sensor_nonlinearity.q": (-1, 0, 0),
    "sensor_drift.r": SPEED,
    "rig_mass.e": NUMBER,
    "rig_stiffness.e": NUMBER,
    "sensor_gain.e": NUMBER,
}
VARIABLES: Mapping[str, Dimension] = {
    "x1": LENGTH,
    "y1": LENGTH,
    "x2": SPEED,
    "y2": SPEED,
    "v_w": SPEED,
    "t": TIME,
}


def scales_of(rig: AnyRig) -> Scales | None:
    """The scales of a rig declared in SI; None for a nondimensional one."""
    return rig.scales if isinstance(rig, Rig) else None


def factor(dimension: Dimension, scales: Scales) -> float:
    """SI value of 1 in the model's numbers."""
    a, b, c = dimension
    return float(scales.length**a * scales.omega**b * scales.k2**c)


def law(name: str) -> Dimension | None:
    """Return what a number of any friction law measures; None for a name that no law has."""
    exponents = law_dimension(name)
    if exponents is None:
        return None
    force, speed = exponents
    return (force + speed, speed, force)


def to_si(name: str, value: float, rig: AnyRig) -> tuple[float, str] | None:
    """Value and unit in SI of a parameter named as `Model.parameters` names it.

    Returns None for a nondimensional rig, a pure number, a phase, and a name that has no one dimension.
    """
    scales = scales_of(rig)
    dimension = EFFECTS.get(name, law(name))
    if scales is None or dimension is None or dimension == NUMBER:
        return None
    unit = "rad/s" if name.endswith(".w") else UNITS[dimension]
    return value * factor(dimension, scales), unit
