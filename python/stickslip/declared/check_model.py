"""Which effects a rig and a law have a place for."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from stickslip.declared.catalogue import CATALOGUE, CONSTANTS, DRIVEN, KINDS
from stickslip.declared.effect import AnyEffect, Effect, FormulaEffect, Tabulated
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.errors import InputError, did_you_mean

MOST_CURVES = 2  # of a motion, that the core has tables for


def idle(law: FrictionLaw, effects: Collection[str]) -> str | None:
    """Say which of some named effects could not act under a law and beside the others; None if each can."""
    for name, kind in KINDS.items():
        why = kind.behaves.idle if name in effects else None
        if why and (words := why(law, effects)):
            return words
    return None


def check_driven(law: FrictionLaw, effects: Iterable[AnyEffect]) -> None:
    """Refuse a law and effects that a driven slider has no place for."""
    if not isinstance(law, CoulombFriction):
        raise InputError("the law of a driven slider is coulomb; declare kind = 'coulomb'", key="friction")
    for one in effects:
        if isinstance(one, Effect) and one.name not in DRIVEN:
            raise InputError(
                f"effect '{one.name}' is not one of a DrivenSlider; {did_you_mean(one.name, DRIVEN)}"
            )
        if isinstance(one, FormulaEffect):
            words = f"effect '{one.name}' is a formula, for rigs on a belt and rigs of bodies or matrices"
            raise InputError(words, key="effects")
        if isinstance(one, Effect):
            continue
        if needs_angle_body(one):
            raise InputError(f"effect '{one.name}' needs the angle body, which a DrivenSlider has not")
        if one.of_reading:
            words = f"effect '{one.name}': the position of a DrivenSlider is read as it is; "
            raise InputError(words + "a curve acts on its block or its contact")


def check_belt(effects: Iterable[AnyEffect]) -> None:
    """Refuse effects that only a driven slider has a place for."""
    for one in effects:
        if isinstance(one, Effect) and one.name not in CATALOGUE and one.name not in CONSTANTS:
            raise InputError(
                f"effect '{one.name}' is for a DrivenSlider; {did_you_mean(one.name, CATALOGUE)}"
            )
    curves = [one.name for one in effects if isinstance(one, Tabulated) and not one.of_reading]
    if len(curves) > MOST_CURVES:
        raise InputError(
            f"effects {', '.join(map(repr, curves))}: a motion can have two tabulated terms; name what another "
            "stands for, or put two into one curve",
            key="effects",
        )


def needs_angle_body(one: AnyEffect) -> bool:
    """Say whether an effect acts on the angle body, or reads it."""
    if isinstance(one, FormulaEffect):
        return False
    if isinstance(one, Effect):
        return one.kind.two_degree
    return one.where in ("angle_body", "y1 channel") or one.variable in ("y1", "y2")
