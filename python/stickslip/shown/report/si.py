"""SI values of the model's numbers, for rigs declared in SI: what each parameter measures, and its unit."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.declared.catalogue import KINDS
from stickslip.declared.dimensions import LENGTH, NUMBER, RATE, SPEED, TIME, UNITS, Dimension
from stickslip.declared.rig import AnyRig, Rig, Scales
from stickslip.declared.scale import law_dimension

EFFECTS: Mapping[str, Dimension] = {
    **{f"{kind.name}.{info.name}": info.dimension for kind in KINDS.values() for info in kind.parameters},
    "unlisted.w": RATE,  # of a learned curve that repeats
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
