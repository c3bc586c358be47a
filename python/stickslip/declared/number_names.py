"""Names of a model's numbers, "<owner>.<number>": no two of its rig, laws and effects may be the same.

Sweeps, derivatives and reports call a number by its name alone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import fields

from stickslip.declared.catalogue import KINDS
from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.effect import AnyEffect, FormulaEffect, Tabulated
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.rig import AnyRig
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.rigs.parts import RESERVED_OWNERS
from stickslip.errors import InputError

SPEEDS = ("belt_speed", "drive_speed")  # called like numbers of a model, and given to `simulate`


def check_number_names(rig: AnyRig, friction: FrictionLaw, effects: Iterable[AnyEffect]) -> None:
    """Refuse names of laws and effects that make two numbers of a model one, or one look like something else.

    Raises
    ------
    InputError
        As said.
    """
    _check_law(rig, friction)
    laws = set(dict(friction.laws)) if isinstance(friction, ContactLaws) else set[str]()
    for one in effects:
        check_effect_name(one, rig, laws)


def check_effect_name(one: AnyEffect, rig: AnyRig, laws: Collection[str]) -> None:
    """Refuse an effect that is called like something else.

    Raises
    ------
    InputError
        As said.
    """
    label = one.name if isinstance(one, Tabulated) else one.label
    if isinstance(one, FormulaEffect) and label in KINDS:
        raise InputError(
            "is an effect of the catalogue; call the formula otherwise", key="effects", value=label
        )
    what = RESERVED_OWNERS.get(label)
    if what is None and isinstance(rig, BodiesRig) and label in rig.parts:
        what = "a part of the rig"
    if what is None and label in laws:
        what = "a law"
    if what is not None:
        raise InputError(f"is what {what} is called; call the effect otherwise", key="effects", value=label)


def _check_law(rig: AnyRig, friction: FrictionLaw) -> None:
    own = rig.numbers if isinstance(rig, GeneralRig) else [one.name for one in fields(rig)]
    if isinstance(friction, ContactLaws):
        for name, _ in friction.laws:
            if "." in name:
                raise InputError("a law's name has no dot; name it otherwise", key="law", value=name)
            if name in RESERVED_OWNERS:
                words = f"is what {RESERVED_OWNERS[name]} is called; name the law otherwise"
                raise InputError(words, key="law", value=name)
    for name in friction.numbers:
        if name in own or name in SPEEDS:
            what = "a number of the rig, too" if name in own else "a prescribed speed, too"
            raise InputError(f"names {what}; call the law's number otherwise", key=name)
