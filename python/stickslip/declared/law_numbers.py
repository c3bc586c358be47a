"""A law's numbers as they are given: bare, or as text with a unit of what they measure at a contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

from stickslip.declared.dimensions import Dimension
from stickslip.declared.formula.dimension import Dimensions, dimensions, said
from stickslip.declared.quantity import quantity
from stickslip.errors import InputError

Size = float | str  # bare, or with a unit


class Sized(float):
    """A number in SI that was given with a unit, which stays with it: a law made of another's numbers has it too."""

    unit: str | None

    def __new__(cls, size: float, unit: str | None = None) -> Self:
        """Make it; copies and pickles bring the unit afterwards."""
        made = super().__new__(cls, size)
        made.unit = unit
        return made


def of_contact(what: Dimension, rotation: bool) -> Dimensions:
    """Return what a number of this dimension measures at a contact that slides, or turns."""
    length, stiffness = ("rad", "N m/rad") if rotation else ("m", "N/m")
    time = dimensions("1/s") ** what.b * dimensions("rad" if what.unit.startswith("rad") else "")
    return dimensions(length) ** what.a * time * dimensions(stiffness) ** what.c


def check_size(name: str, unit: str | None, what: Dimension, rotation: bool) -> None:
    """Refuse a number given in a unit of something else than it measures at a contact that slides, or turns."""
    needed = of_contact(what, rotation)
    if unit is not None and dimensions(unit) != needed:
        where = "a contact that turns" if rotation else "a contact that slides"
        raise InputError(f"is {said(dimensions(unit))}; at {where} it must be {said(needed)}", key=name)


def law_number(name: str, given: object, what: Dimension) -> tuple[float, str | None]:
    """Return a number in SI and its SI unit, None where it is given bare.

    A law alone does not know whether its contact slides or turns: a unit of either is taken.

    Raises
    ------
    InputError
        Not a finite number, or a unit of something else.
    """
    size, unit = (float(given), given.unit) if isinstance(given, Sized) else quantity(name, given)
    if unit is None:
        return size, None
    sliding, turning = of_contact(what, False), of_contact(what, True)
    if dimensions(unit) not in (sliding, turning):
        words = f"is {said(dimensions(unit))}; it must be {said(sliding)}"
        if turning != sliding:
            words += f", or {said(turning)} at a contact that turns"
        raise InputError(words, key=name, value=given)
    return size, unit


def measure_of(dimensions_by_name: Mapping[str, Dimension], name: str) -> Dimension:
    """Return what a number of a law measures, its twin for v_w > 0 the same, and one of a list as the list."""
    name = name.partition("[")[0]
    return dimensions_by_name[name if name in dimensions_by_name else name.removesuffix("_plus")]
