"""Which law goes with which contact of a rig of bodies or matrices, and what such a model may not have."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.effect import AnyEffect, Effect, FormulaEffect
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.law_dimensions import check_law
from stickslip.declared.laws import LAWS
from stickslip.declared.placed import placed
from stickslip.declared.places import Places
from stickslip.declared.rig import AnyRig, only_simulated
from stickslip.declared.rigs.general import ContactRow, Equations, GeneralRig
from stickslip.declared.rubbing import rubbing, with_contacts
from stickslip.declared.units import Channel
from stickslip.errors import InputError, did_you_mean


def named_laws(given: object) -> object:
    """Return laws given as a table by name as `ContactLaws`; anything else as it is."""
    if not isinstance(given, Mapping):
        return given
    for name, law in given.items():
        if not isinstance(law, FrictionLaw) or isinstance(law, ContactLaws):
            raise InputError(
                f"'{name}' must be a law, like CoulombFriction(static=1, kinetic=0.5)", key="friction"
            )
    return ContactLaws(tuple((str(name), law) for name, law in given.items()))


def law_of(friction: FrictionLaw, contact: ContactRow) -> FrictionLaw:
    """Return the law of a contact."""
    if not isinstance(friction, ContactLaws):
        return friction
    if not contact.law and len(friction.laws) == 1:
        return friction.laws[0][1]
    return friction[contact.law]


def check_general(
    rig: AnyRig, friction: FrictionLaw, effects: Sequence[AnyEffect], read: Mapping[str, object]
) -> None:
    """Refuse laws that no contact names, units that do not go with a contact, and effects, which act on named rigs.

    Raises
    ------
    InputError
        As said.
    """
    if not isinstance(rig, GeneralRig):
        _check_named(friction, effects)
        return
    others = {name for name, one in read.items() if isinstance(one, Channel) and one.reads}
    for channel in read:
        if channel not in rig.channel_units and channel not in others:
            hint = did_you_mean(channel, rig.channel_units)
            raise InputError(f"unknown channel of this rig; {hint}", key=f"channels.{channel}")
    contacts = rig.equations.contacts
    if not contacts:
        raise InputError("has no contact; declare one, like [[rig.contact]] with its body", key="rig")
    _check_named_laws(contacts, friction)
    for one in contacts:
        try:
            check_law(law_of(friction, one), one.rotation)
        except InputError as error:
            name = f"{one.law}.{error.key}" if isinstance(friction, ContactLaws) else error.key
            raise InputError(error.what, key=name, value=error.value) from None
    check_placed(rig, rig.equations, range(2 * len(rig.equations.names)), effects)


def check_placed(rig: AnyRig, own: Equations, order: Sequence[int], effects: Sequence[AnyEffect]) -> None:
    """Refuse an effect that acts on no such rig, or at no such place of it.

    Raises
    ------
    InputError
        As said, with the nearest name.
    """
    places = Places(rig, own, order)
    with_contacts(own, rubbing([placed(one, places) for one in effects]))


def _check_named(friction: FrictionLaw, effects: Sequence[AnyEffect]) -> None:
    if isinstance(friction, ContactLaws):
        raise InputError("a named rig has one contact, and one law", key="friction")
    for one in effects:
        if isinstance(one, Effect) and one.placed:
            words = f"effect '{one.name}' acts on the {one.kind.where} of a named rig; leave it out"
            raise InputError(words, key="where", value=one.where)
        if isinstance(one, Effect) and one.by:
            raise InputError(
                f"effect '{one.name}' couples the angle body of a named rig; leave it out",
                key="by",
                value=one.by,
            )
    if not isinstance(friction, LawByFormula):
        return
    others = [one for one in effects if not isinstance(one, FormulaEffect)]
    if others:
        words = (
            f"'{others[0].name}' does not act under the law '{friction.kind}' as yet; put it into a formula"
        )
        raise InputError(words, key="effects")
    check_law(friction, rotation=False)


def _check_named_laws(contacts: Sequence[ContactRow], friction: FrictionLaw) -> None:
    if isinstance(friction, ContactLaws):
        check_names_of_laws(contacts, [name for name, _ in friction.laws])
        return
    asked = sorted({one.law for one in contacts if one.law})
    if len(asked) > 1:
        words = f"the contacts name {len(asked)} laws ({', '.join(asked)}); give each as [law.<name>]"
        raise InputError(words, key="friction")


def check_names_of_laws(contacts: Sequence[ContactRow], known: Collection[str]) -> None:
    """Refuse a contact whose law is not there, and a law that no contact names.

    Raises
    ------
    InputError
        As said, with the nearest name.
    """
    alone = len(known) == 1
    for one in contacts:
        if not one.law and not alone:
            words = f"contact '{one.name}' names no law; give it one of {', '.join(known)}"
            raise InputError(words, key="law")
        if one.law and one.law not in known:
            hint = did_you_mean(one.law, known)
            raise InputError(f"no law '{one.law}' of contact '{one.name}'; {hint}", key="law")
    asked = {one.law for one in contacts}
    for name in known:
        if name not in asked and not (alone and asked == {""}):
            raise InputError("no contact names it; give it to one, or leave it out", key=f"law.{name}")


def check_closed_form(rig: AnyRig, friction: FrictionLaw, effects: Sequence[AnyEffect] = ()) -> None:
    """Refuse what can only be simulated and continued as yet: rigs of bodies or matrices, and formulas.

    Raises
    ------
    InputError
        As said.
    """
    if isinstance(rig, GeneralRig):
        raise only_simulated(rig)
    for one in effects:
        if isinstance(one, FormulaEffect):
            words = (
                f"the effect '{one.name}' is a formula: it can be simulated, but this works without it only"
            )
            raise InputError(words, key="effects")
    if type(friction) not in LAWS.values():
        kinds = ", ".join(LAWS)
        words = (
            f"the law '{friction.kind}' can be simulated on a named rig, but not fitted, compared or forecast; "
            f"declare one of {kinds}, or the rig by its bodies"
        )
        raise InputError(words, key="friction")
