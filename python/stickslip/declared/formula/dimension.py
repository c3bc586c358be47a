"""What a formula measures: units are carried through it, and what does not go together is named.

Here an angle is no pure number: radian is a dimension of its own, so that N m (a torque) is not N m/rad (a stiffness
of a rotation). An inertia may be written kg m^2, as everyone does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Self

from stickslip.declared.formula.tree import Apply, Name, Number, Tree, written
from stickslip.errors import InputError

if TYPE_CHECKING:
    from pint import UnitRegistry


@dataclass(frozen=True)
class Dimensions:
    """Exponents by "[length]" and so on, sorted, none of them 0."""

    exponents: tuple[tuple[str, float], ...] = ()

    @classmethod
    def of(cls, exponents: Mapping[str, float]) -> Self:
        """Make it of exponents in any order."""
        kept = ((name, round(float(one), 9)) for name, one in sorted(exponents.items()))
        return cls(tuple((name, one) for name, one in kept if one))

    def __mul__(self, other: Dimensions) -> Dimensions:
        names = dict(self.exponents).keys() | dict(other.exponents).keys()
        one, two = dict(self.exponents), dict(other.exponents)
        return Dimensions.of({name: one.get(name, 0.0) + two.get(name, 0.0) for name in names})

    def __pow__(self, power: float) -> Dimensions:
        return Dimensions.of({name: one * power for name, one in self.exponents})

    def __truediv__(self, other: Dimensions) -> Dimensions:
        return self * other**-1


NAMES = {
    "N": "a force", "N m": "a torque", "m": "a length", "rad": "an angle", "m/s": "a speed",
    "rad/s": "an angular speed", "kg": "a mass", "kg m^2": "an inertia", "s": "a time", "N/m": "a stiffness",
    "N s/m": "a damping", "N m/rad": "a stiffness of a rotation", "N m s/rad": "a damping of a rotation",
    "1/s": "a rate", "m/s^2": "an acceleration", "rad/s^2": "an angular acceleration", "m/rad": "a lever arm",
    "N/s": "a force by time", "s/m": "an inverse speed", "s/rad": "an inverse angular speed",
    "N s^2/m^2": "a quadratic damping", "N m s^2/rad^2": "a quadratic damping of a rotation", "": "a pure number",
}  # fmt: skip


@lru_cache(maxsize=1)
def registry() -> UnitRegistry[float]:
    """Return the registry in which an angle is a dimension; made at first use."""
    from pint import UnitRegistry

    return UnitRegistry(list(_definitions("default_en.txt")))


def _definitions(name: str) -> Iterator[str]:
    """Pint's own definitions, radian made a dimension; defining it anew would leave rpm and turn as they were."""
    folder = files("pint")
    for line in folder.joinpath(name).read_text(encoding="utf-8").splitlines():
        if line.startswith("@import"):
            yield from _definitions(line.split()[1])
        else:
            yield "radian = [angle] = rad" if line.startswith("radian =") else line


@lru_cache(maxsize=256)
def dimensions(unit: str) -> Dimensions:
    """Return what a unit measures.

    Raises
    ------
    InputError
        No such unit.
    """
    try:
        measured: Mapping[str, Any] = registry().Unit("" if unit == "1" else unit).dimensionality
        return Dimensions.of(measured)
    except Exception:  # pint raises of many kinds, those of Python's tokenizer too
        raise InputError(
            "unknown unit; give one like 'N', 'mm/s' or 'N m/rad'", key="unit", value=unit
        ) from None


def to_si(size: float, unit: str) -> tuple[float, str]:
    """Return a size in SI and the SI unit it is in: (2, "mm/s") -> (0.002, "m/s").

    Raises
    ------
    InputError
        pint does not know the unit, or it has an offset.
    """
    if unit in ("", "1"):
        return size, "1"
    try:
        found = _known(unit)
    except Exception:  # pint raises of many kinds, those of Python's tokenizer too
        raise InputError("unknown unit; give one like 'N', 'mm/s' or 'N m/rad'", value=unit) from None
    return size * found[0] if found[0] != 1 else size, found[1]


@lru_cache(maxsize=256)
def _known(unit: str) -> tuple[float, str]:
    units = registry()
    measured = units.Unit(unit).dimensionality
    one = units.Quantity(1.0, unit)
    for usual in NAMES:
        if usual and units.Unit(usual).dimensionality == measured:
            return float(one.to(usual).magnitude), usual
    base = one.to_base_units()  # m, kg, s, A, K, rad
    return float(base.magnitude), f"{base.units:~C}" or "1"


def said(measured: Dimensions) -> str:
    """Say what is measured: "a speed (m/s)"."""
    for usual, words in NAMES.items():
        if dimensions(usual) == measured:
            return f"{words} ({usual})" if usual else words
    return " ".join(f"{name.strip('[]')}^{power:g}" for name, power in measured.exponents)


def measures(tree: Tree, of: Mapping[str, Dimensions], numbers: Mapping[str, float]) -> Dimensions | None:
    """Return what a formula measures; None where it is 0, which goes with everything.

    Parameters
    ----------
    tree
        The formula.
    of
        What each name measures.
    numbers
        Values of parameters, for exponents.

    Raises
    ------
    InputError
        Different things are added or compared, or the argument of a function is not a pure number.
    """
    if isinstance(tree, Number):
        return None if tree.value == 0 else dimensions("")
    if isinstance(tree, Name):
        return of[tree.name]
    parts = [measures(one, of, numbers) for one in tree.operands]
    match tree.operation:
        case "add" | "subtract" | "min" | "max":
            return _same(tree, parts)
        case "multiply":
            return None if parts[0] is None or parts[1] is None else parts[0] * parts[1]
        case "divide":
            return None if parts[0] is None else parts[0] / (parts[1] or dimensions(""))
        case "power":
            return _power(tree, parts, numbers)
        case "sqrt":
            return None if parts[0] is None else parts[0] ** 0.5
        case "negate" | "abs":
            return parts[0]
        case "sign":
            return dimensions("")
    angle = tree.operation in ("sin", "cos", "tan") and parts[0] == dimensions("rad")
    if parts[0] is not None and parts[0] != dimensions("") and not angle:
        words = f"{tree.operation} of {said(parts[0])}, '{written(tree.operands[0])}'; its argument is a pure number"
        raise InputError(words)
    return dimensions("")


def _same(tree: Apply, parts: list[Dimensions | None]) -> Dimensions | None:
    one, other = parts
    if one is None or other is None:
        return other if one is None else one
    if one != other:
        first, second = (written(one) for one in tree.operands)
        how = {"add": "added to", "subtract": "subtracted from"}.get(tree.operation, "compared with")
        raise InputError(f"'{second}', {said(other)}, is {how} '{first}', {said(one)}")
    return one


def _power(tree: Apply, parts: list[Dimensions | None], numbers: Mapping[str, float]) -> Dimensions:
    from stickslip.declared.formula.value import value

    base, exponent = parts
    if exponent is not None and exponent != dimensions(""):
        raise InputError(
            f"the exponent '{written(tree.operands[1])}' is {said(exponent)}; it must be a pure number"
        )
    if base is None or base == dimensions(""):
        return dimensions("")
    try:
        size = float(value(tree.operands[1], numbers))
    except KeyError:
        words = f"'{written(tree.operands[0])}', {said(base)}, has an exponent that is not constant"
        raise InputError(words) from None
    return base**size
