"""Heads of columns: the name and the unit that one carries, in any usual spelling."""

from __future__ import annotations

import re

from stickslip.declared.units import is_unit

_HEAD = re.compile(r"(.*?\S)\s*(?:\[([^\]]*)\]|\(([^)]*)\)|/\s*(\S+))\s*$")
_BRACKETS = {"(": ")", "[": "]", "{": "}"}
_UNIT = re.compile(r"[\w µμ°%²³·^/*.()⁻¹-]{1,25}$")
_TOWER = re.compile(
    r"\d{3}|(?:\*\*|\^).*(?:\*\*|\^).*(?:\*\*|\^)"
)  # powers of powers, which pint would work out
_SPELT = ("sec", "deg", "rad", "rpm")  # short words that capitals do not make another unit
_WORD = 3  # letters from which a capital is spelling and no prefix: "Volt" is V, "MN" is no mN


def head_parts(head: str) -> tuple[str, str] | None:
    """Return the name and the unit of a column's head, as "x1 [mm]", "x1(mm)" or "x1 / mm"; None if it has no unit."""
    found = _HEAD.match(head)
    if found is None:
        return None
    unit = unit_in(next(part for part in found.groups()[1:] if part is not None))
    return None if unit is None else (found[1], unit)


def unit_in(text: str) -> str | None:
    """Return the unit that a text is, "(ms)" and "Newtons" too, as pint spells it; "1" for "-"; None if it is none."""
    unit = text.strip()
    if len(unit) > 1 and _BRACKETS.get(unit[0]) == unit[-1]:
        unit = unit[1:-1].strip()
    if unit in ("", "-", "1"):
        return "1"
    if not (unit[0].isalpha() or unit[0] in "µμ°%1") or not _UNIT.match(unit) or _TOWER.search(unit):
        return None
    if is_unit(unit):
        return unit
    word = unit.lower()
    return word if (len(unit) > _WORD or word in _SPELT) and is_unit(word) else None
