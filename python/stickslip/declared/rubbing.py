"""Contacts that effects add to a rig: dry friction of a body or a link that rubs on nothing declared."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from stickslip.declared.placed import Placed
from stickslip.declared.rigs.general import ContactRow, Equations, check_contacts
from stickslip.errors import InputError


def rubbing(found: Iterable[Placed]) -> list[ContactRow]:
    """Return the contacts that effects at their places add, each called as its effect."""
    return [
        ContactRow(one.label, one.direction, "ground", "", one.rubs)
        for one in found
        if one.rubs is not None and one.direction is not None
    ]


def with_contacts(own: Equations, added: Iterable[ContactRow]) -> Equations:
    """
    Return equations with further contacts.

    Raises
    ------
    InputError
        One acts where a contact does, or there are so many that what each carries in stick is not known.
    """
    for one in added:
        own = replace(own, contacts=(*own.contacts, one))
        try:
            check_contacts(own)
        except InputError as error:
            raise InputError(error.what, key=one.name) from None
    return own
