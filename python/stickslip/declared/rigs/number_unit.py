"""Units of the numbers of a rig of bodies or matrices, as far as their names tell."""

from __future__ import annotations

from stickslip.declared.dimensions import INERTIA, LENGTH, MASS
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.rigs.parts import Link

PER = {"mass": MASS.unit, "inertia": INERTIA.unit, "arm": LENGTH.unit}  # of a part, in SI


def number_unit(rig: GeneralRig, name: str) -> str:
    """The SI unit of a number of a rig of bodies, as far as its name tells; "" where it does not."""
    owner, _, key = name.rpartition(".")
    if not isinstance(rig, BodiesRig) or key in PER:
        return PER.get(key, "")
    if key not in ("stiffness", "damping", "rest"):
        return ""
    link = rig.parts[owner]
    assert isinstance(link, Link)  # nothing else has any of these
    body = next((rig.body[end] for end in link.between if end in rig.body), None)
    turns = body is not None and body.rotation
    units = ("N m/rad", "N m s/rad", "rad") if turns else ("N/m", "N s/m", "m")
    return dict(zip(("stiffness", "damping", "rest"), units, strict=True))[key]
