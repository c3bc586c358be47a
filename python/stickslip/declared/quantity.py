"""A number as a person writes it: bare, or as text with a unit. Below everything that has numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping

from stickslip.declared.formula.dimension import dimensions, said, to_si
from stickslip.errors import InputError, number

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")

_PER = re.compile(r"1 ?/ ?\(?[^\W\d]")  # 1/s, and no half of anything


class InUnits:
    """What has numbers that may be given with units, and remembers which were."""

    @property
    def declared_units(self) -> Mapping[str, str]:
        """SI units of the numbers that were given with one."""
        units: Mapping[str, str] = self.__dict__.get("_units", {})
        return units


def with_unit(text: str) -> tuple[float, str]:
    """Return the number and the unit of "14 mm/s" or "14mm/s"; the unit is "" where there is none.

    Raises
    ------
    ValueError
        It does not begin with a number.
    """
    text = text.strip()
    found = _NUMBER.match(text)
    if found is None:
        return float(text), ""  # nan and inf are numbers too
    unit = text[found.end() :].strip()
    if unit != "1" and not _PER.match(unit) and (unit[:1] in {",", ".", "'"} or unit[:1].isdigit()):
        raise ValueError("a number goes on behind what looks like its end: a decimal comma?")
    return float(found[0]), unit


def quantity(key: str, given: object) -> tuple[float, str | None]:
    """Return a number in SI and its SI unit; the unit is None where it is given bare.

    Raises
    ------
    InputError
        Not a finite number, or a unit that is not known.
    """
    if not isinstance(given, str):
        return number(key, given), None  # type: ignore[arg-type]  # `number` looks
    try:
        size, unit = with_unit(given)
    except ValueError:
        raise InputError("not a number with a unit; give one like '4 N'", key=key, value=given) from None
    number(key, size)
    try:
        return to_si(size, unit) if unit else (size, None)
    except InputError as error:
        raise InputError(error.what, key=key, value=given) from None


def sized(text: float | str, unit: str, key: str) -> float:
    """Return a number in SI; one without a unit is in it already.

    Raises
    ------
    InputError
        Not a number with a unit, or the unit measures something else than `unit`.
    """
    size, own = quantity(key, text)
    if own is not None and unit != "1" and dimensions(own) != dimensions(unit):
        raise InputError(
            f"is {said(dimensions(own))}; it must be {said(dimensions(unit))}", key=key, value=text
        )
    return size
