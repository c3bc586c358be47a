"""Units of the numbers of a rig of bodies or matrices, as far as its parts tell."""

from __future__ import annotations

from stickslip.declared.dimensions import DAMPING, INERTIA, LENGTH, MASS, STIFFNESS, turning
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.rigs.parts import Link

PER = {"mass": MASS.unit, "inertia": INERTIA.unit, "arm": LENGTH.unit}
OF_LINKS = {"stiffness": STIFFNESS.unit, "damping": DAMPING.unit, "rest": LENGTH.unit}


def number_unit(rig: GeneralRig, name: str) -> str:
    """The SI unit of a number of a rig of bodies; "" where it has none that is known, as of a law's number."""
    owner, _, key = name.rpartition(".")
    part = rig.parts.get(owner) if isinstance(rig, BodiesRig) else None
    if part is None or not isinstance(rig, BodiesRig):
        return ""
    if not isinstance(part, Link):
        return PER.get(key, "")
    if key not in OF_LINKS:
        return ""
    body = next((rig.body[end] for end in part.between if end in rig.body), None)
    turns = body is not None and body.rotation
    return turning(OF_LINKS[key]) if turns else OF_LINKS[key]
