"""A prescribed speed as a person writes it: a number, one with a unit, or a formula of t."""

from __future__ import annotations

from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import names
from stickslip.declared.quantity import quantity, sized
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError


def formula_of_time(text: str, key: str) -> Speed | None:
    """Return the speed that a formula of t tells of; None for what should be a number with a unit."""
    try:
        tree = parse(text)
    except InputError:
        if not {"(", "*"} & set(text):  # nobody's formula
            return None
        return Speed.of(text, key)  # says what is wrong with it
    if "t" in names(tree) or {"(", "*"} & set(text):
        return Speed.of(text, key)
    return None


def set_point(given: float | str | Speed, unit: str, per_unit: float, key: str) -> Speed:
    """Return a speed in SI.

    Parameters
    ----------
    given
        A number, in the unit of its channel, as text too; one with a unit of its own ("12 rpm"); a formula of t, in SI.
    unit
        SI unit of the speed.
    per_unit
        What 1 of the channel's unit is in it.
    key
        Name said in an error.

    Raises
    ------
    InputError
        None of these, or a unit of something else.
    """
    if isinstance(given, Speed):
        return given
    if not isinstance(given, str):
        return Speed.of(sized(given, unit, key) * per_unit, key)
    formula = formula_of_time(given, key)
    if formula is not None:
        return formula
    size = sized(given, unit, key)
    return Speed.of(size if quantity(key, given)[1] else size * per_unit, key)
