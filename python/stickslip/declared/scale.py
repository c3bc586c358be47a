"""The units a person reads a model's numbers in: those its readings are recorded in, SI, or none at all."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeVar, get_args

from stickslip.declared.dimensions import FORCE
from stickslip.declared.formula.dimension import dimensions, to_si
from stickslip.declared.quantity import sized, with_unit
from stickslip.declared.rig import AnyRig, DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.si import si_of
from stickslip.declared.units import Channel, default_speed_unit, factor, in_si, is_angle
from stickslip.errors import InputError, number

T = TypeVar("T")
Quantity = Literal["t", "x1", "x2", "y1", "y2", "belt", "force"]


@dataclass(frozen=True)
class Scale:
    """A number in `unit` is the model's number times `size`; the unit of a nondimensional number is "1"."""

    size: float = 1.0
    unit: str = "1"

    def of(self, value: float, digits: int = 5) -> str:
        """Write the model's number in the unit."""
        return f"{value * self.size:.{digits}g}" + ("" if self.unit == "1" else f" {self.unit}")

    def head(self, name: str) -> str:
        """Return a column's head: the name and the unit, as in "x1 [mm]"."""
        return name if self.unit == "1" else f"{name} [{self.unit}]"


def scales(rig: AnyRig, channels: Mapping[str, Channel] | None = None) -> dict[Quantity, Scale]:
    """Return how each quantity of a rig is read.

    Parameters
    ----------
    rig
        One with scales, or a rig of another kind with channels in units, is read in units; another in bare numbers.
    channels
        Units of the readings, each its own, "1" too; velocities follow from them. SI where there are none.
    """
    force = si_of(FORCE, rig, channels)
    if force is None:
        return {name: Scale() for name in get_args(Quantity)}
    usual = {"x1": "m", "y1": "m"} if isinstance(rig, Rig) else {"x1": "mm"}
    units = {"t": "s", "belt": default_speed_unit(rig), **usual}
    units |= {name: one.unit for name, one in (channels or {}).items()}
    out: dict[Quantity, Scale] = {"t": Scale(1 / factor("t", units["t"], rig), units["t"])}
    places: tuple[tuple[Quantity, Quantity], ...] = (("x1", "x2"), ("y1", "y2"))
    for place, velocity in places:
        if place in units:
            out[place] = Scale(1 / factor(place, units[place], rig), units[place])
            per = "1" if units[place] == units["t"] == "1" else f"{units[place]}/{units['t']}"
            out[velocity] = Scale(out[place].size / out["t"].size, per)
    out["belt"] = Scale(1 / factor("belt", units["belt"], rig), units["belt"])
    out["force"] = Scale(force.size, force.unit)
    return out


def law_scale(name: str, rig: AnyRig, channels: Mapping[str, Channel] | None = None) -> Scale:
    """Return how a number of a friction law is read: in SI, or bare where the rig is."""
    known = si_of(name, rig, channels)
    return Scale() if known is None else Scale(known.size, known.unit)


def plainly(value: float, digits: int = 2) -> str:
    """Write a number to a few digits and without a power of ten: "170", never "1.7e+02"."""
    return f"{float(f'{value:.{digits}g}'):.15g}" if abs(value) >= 1 else f"{value:.{digits}g}"


def percent(share: float, digits: int = 2) -> str:
    """Write a share of 1 in per cent; below a hundredth of one, and above a thousand, that alone is said."""
    if 0 < abs(share) < 1e-4:
        return "less than 0.01 %"
    if share > 10:
        return "more than 1000 %"
    return f"{plainly(100 * share, digits)} %"


def to_digits(value: float, doubt: float | None) -> str:
    """Write a number to the first digit that is in doubt, or the second; to four digits where that is not known.

    Its own first two digits are always there: what is smaller than its doubt does not become 0.
    """
    if not doubt or not math.isfinite(doubt) or abs(value) < 1e-4:
        return f"{value:.4g}"
    own = 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{max(0, own, -math.floor(math.log10(doubt / 3)))}f}"


def read_quantity(text: str | float, quantity: Quantity, usual: Scale, rig: AnyRig, key: str) -> float:
    """Return the model's number for what a person wrote: "0.014", "14 mm/s", or "0.2 1" (the model's own).

    Parameters
    ----------
    text
        A number, in `usual` where it has no unit of its own.
    quantity
        What it measures.
    usual
        From `scales`.
    key
        Name said in the error.

    Raises
    ------
    InputError
        Not a finite number, or a unit that does not measure the quantity.
    """
    try:
        size, own = with_unit(str(text))
    except ValueError:
        example = {"t": "60 s", "x1": "1.5 mm", "y1": "1.5 mm"}.get(quantity, "12 mm/s")
        words = f"not a number with a unit; give one like 0.1 or '{example}'"
        raise InputError(words, key=key, value=text) from None
    number(key, size)
    try:
        return size * (_factor(quantity, own, rig) if own else 1 / usual.size)
    except InputError as error:
        raise InputError(error.what, key=key, value=text) from None


def written_speed(given: T, rig: AnyRig, key: str) -> T | float:
    """
    Return a speed in the model's numbers where it is written as one number ("12 mm/s"), of a driven slider the force of
    its drive; all else as it is.

    Text without a unit is the model's number, as it is of every parameter.

    Raises
    ------
    InputError
        The unit measures no speed of this rig, or no force, or the rig has no units.
    """
    if not isinstance(given, str):
        return given
    try:
        size, unit = with_unit(given)
    except ValueError:
        return given
    if not unit:
        return size
    if not unit[:1].isalpha():
        return given
    if not isinstance(rig, (GeneralRig, DrivenSlider)):
        return read_quantity(given, "belt", Scale(), rig, key)
    try:
        size, own = to_si(size, unit)
    except InputError as error:
        raise InputError(error.what, key=key, value=given) from None
    if isinstance(rig, DrivenSlider):
        if dimensions(own) != dimensions("N"):
            raise InputError("measures no force; give one like '4 N'", key=key, value=given)
        return size
    moved = rig.equations.drive_unit if key == "drive_speed" else rig.equations.belt_unit
    right = [dimensions(moved)] if moved != "1" else [dimensions("m/s"), dimensions("rad/s")]
    if dimensions(own) not in right:
        like = "30 rpm" if moved == "rad/s" else "12 mm/s"
        words = f"measures no speed of what moves in {moved}; give one like '{like}'"
        raise InputError(words, key=key, value=given)
    return size


def _factor(quantity: Quantity, unit: str, rig: AnyRig) -> float:
    """The model's number for 1 of `unit`."""
    if unit == "1":
        return 1.0
    if quantity == "y2" and is_angle(f"({unit}) * s"):
        return (
            factor("y1", "rad", rig)
            * in_si(unit, "rad/s", what="an angular velocity")
            / factor("t", "s", rig)
        )
    if quantity == "force":
        raise InputError("a force is not asked for", key="unit", value=unit)
    return factor("belt" if quantity in ("x2", "y2") else quantity, unit, rig)


def written_time(given: float | str, rig: AnyRig, key: str) -> float:
    """
    Return a time in the model's numbers where it is written as text ("60 s"); all else as it is.

    Raises
    ------
    InputError
        Not a number with a unit of time, or the rig has no units.
    """
    if not isinstance(given, str):
        return given
    return (
        sized(given, "s", key)
        if isinstance(rig, GeneralRig)
        else read_quantity(given, "t", Scale(), rig, key)
    )
