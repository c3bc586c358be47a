"""Units of numbers at places of a rig of bodies or matrices: what slides is in N and m, what turns in N m and rad."""

from __future__ import annotations

from stickslip.declared.catalogue import KINDS
from stickslip.declared.dimensions import DAMPING, MASS, NUMBER, STIFFNESS, turning
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import GeneralRig

SLIDES = {"inertia": MASS.unit, "stiffness": STIFFNESS.unit, "damping": DAMPING.unit}
TURNS = {trait: turning(unit) for trait, unit in SLIDES.items()}


def unit_at(rig: GeneralRig, name: str, where: str, number: str) -> str | None:
    """Return the unit of a number of an effect at a place; None where it has none, or none that is known."""
    if name not in KINDS or "1" in rig.equations.units:
        return None
    known = KINDS[name].parameter(number).dimension
    if known == NUMBER:
        return None
    return turning(known.unit) if _turns(rig, where.removesuffix(" channel")) else known.unit


def unit_of(rig: GeneralRig, name: str) -> str:
    """Return the unit of a declared constant; "1" where coordinates of several kinds make it."""
    own = rig.equations
    if "1" in own.units or not isinstance(rig, BodiesRig):
        kinds = set(own.units)
        trait = rig.uncertain[name]
        return (
            {"m": SLIDES, "rad": TURNS}[kinds.pop()][trait] if len(kinds) == 1 and "1" not in kinds else "1"
        )
    return (TURNS if _turns(rig, name.rpartition(".")[0]) else SLIDES)[rig.uncertain[name]]


def _turns(rig: GeneralRig, where: str) -> bool:
    own = rig.equations
    states = dict(zip(rig.state_names, (*own.units, *own.units), strict=True))
    if where in states:
        return states[where] == "rad"
    for link in own.links:
        if link.name == where:
            return any(unit == "rad" for unit, share in zip(own.units, link.row, strict=True) if share)
    return any(one.rotation for one in own.contacts if one.name == where)
