"""Numbers of effects that were given with a unit, in the numbers of the model that the effect is part of."""

from __future__ import annotations

from collections.abc import Iterable

from stickslip.declared.effect import AnyEffect, Effect
from stickslip.declared.law_numbers import Sized, check_size
from stickslip.declared.rig import AnyRig, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError


def effects_in_model(effects: Iterable[AnyEffect], rig: AnyRig) -> tuple[AnyEffect, ...]:
    """Return effects in the numbers of a rig's model: those given with a unit are turned where the model has scales.

    Raises
    ------
    InputError
        A number has a unit, but the rig of (2.1) has no scales, or the effect is at a place of a rig of bodies or
        matrices; or the unit is one of a contact that turns.
    """
    return tuple(_in_model(one, rig) if isinstance(one, Effect) else one for one in effects)


def _in_model(one: Effect, rig: AnyRig) -> Effect:
    given = {name: size for name, size in one.parameters.items() if isinstance(size, Sized) and size.unit}
    if not given:
        return one
    name = f"{one.name}.{next(iter(given))}"
    if isinstance(rig, GeneralRig):
        words = "has a unit; numbers of effects on a rig of bodies or matrices are in SI: give it bare"
        raise InputError(words, key=name)
    if isinstance(rig, Rig) and rig.scales is None:
        words = "has a unit, but the rig is nondimensional: give it bare, or declare the rig in SI"
        raise InputError(words, key=name)
    sizes = {}
    for key, size in given.items():
        what = one.kind.parameter(key).given_in
        check_size(f"{one.name}.{key}", size.unit, what, rotation=False)
        sizes[key] = float(size) / (what.size(rig.scales) if isinstance(rig, Rig) and rig.scales else 1.0)
    return one.replace(**sizes)
