"""In which units a sweep's numbers and results are: SI where the model is declared in it, else none are known."""

from __future__ import annotations

from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.rigs.number_unit import number_unit
from stickslip.declared.si import OF_VARIABLES, dimension_in, scales_of

SPEED = "m/s"


def in_si(model: Model) -> bool:
    """Are the model's own numbers in SI? Of a block on a belt by its readings, or by numbers given with a unit."""
    rig = model.rig
    if isinstance(rig, Rig):
        return False
    if isinstance(rig, GeneralRig):
        return "1" not in rig.equations.units
    if model.channels:
        return scales_of(rig, model.channels) is not None
    return bool(rig.declared_units or model.friction.declared_units)


def unit_of(model: Model, name: str) -> str:
    """Unit of a number that a sweep varies, or of a state as "initial.x1"; "1" where it has none, or none is known."""
    if not in_si(model):
        return "1"
    rig = model.rig
    key = name.removeprefix("initial.")
    if isinstance(rig, GeneralRig):
        speeds = {"belt_speed": rig.equations.belt_unit, "drive_speed": rig.equations.drive_unit}
        known = {**speeds, **{f"initial.{one}": unit for one, unit in rig.channel_units.items()}}
        if name in rig.numbers:
            return number_unit(rig, name) or "1"
        return known.get(name) or _of_law(model, name)
    if name != key:
        return OF_VARIABLES[key].unit if key in OF_VARIABLES else "1"
    if name == "belt_speed":
        return SPEED
    known_as = dimension_in(model.friction, model.full_name(name))
    return model.friction.declared_units.get(name) or ("1" if known_as is None else known_as.unit)


def _of_law(model: Model, name: str) -> str:
    """Of a number of the law or of an effect on a rig of bodies; of what turns, only what was given with one."""
    given = model.friction.declared_units
    assert isinstance(model.rig, GeneralRig)
    turns = any(one != "m" for one in model.rig.equations.units)
    known_as = None if turns else dimension_in(model.friction, model.full_name(name))
    return given.get(name) or ("1" if known_as is None else known_as.unit)
