"""Units of what was recorded: from a column's unit to the model's numbers and back."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip.declared.formula.dimension import NAMES, dimensions, registry
from stickslip.declared.quantity import with_unit
from stickslip.declared.rig import AnyRig, BlockOnBelt, Rig, Scales
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError, number
from stickslip.objects import Displayed, as_call

# what each channel measures, in SI; a spring force is read as the deflection x1 it stands for
DIMENSIONS: dict[str, tuple[str, str]] = {
    "t": ("s", "a time"),
    "x1": ("m", "a displacement"),
    "y1": ("m", "a displacement (or an angle, deg or rad)"),
    "belt": ("m/s", "a velocity"),
    "spring_force": ("N", "a force"),
    "drive": ("N", "a force"),
}
OF_GRAVITY = {"g": 9.80665, "mg": 9.80665e-3}  # as the sheets of accelerometers say it


@dataclass(frozen=True)
class Channel(Displayed):
    """How a quantity was recorded: reading = scale * column + offset, in `unit`.

    `offset`, `offset_uncertainty` and `reads` are of rigs of bodies or matrices.

    Parameters
    ----------
    column
        Name of the column, or of the variable of a .mat file.
    unit
        A unit pint knows ("s", "mm", "m/s", "deg", ...) or "1" for the model's own. Of an acceleration "g" is that of
        gravity, 9.80665 m/s^2.
    scale
        What a column's number is multiplied by to be in `unit`.
    offset
        What is added to it then, in `unit`.
    offset_uncertainty
        Standard uncertainty of the offset, in `unit`; 0: it is exact.
    reads
        What it reads, where that is not its own name: `{"second": Channel("c2", "mm", reads="block")}`.

    Raises
    ------
    InputError
        The scale is zero, the uncertainty negative, or a number not finite.

    Examples
    --------
    >>> import stickslip as ss
    >>> force = ss.Channel("F", "N", scale=0.301)  # the column F holds 0.301 N for 1
    >>> force.unit
    'N'
    """

    __repr__ = as_call

    column: str
    unit: str = "1"
    scale: float = 1.0
    offset: float = 0.0
    offset_uncertainty: float = 0.0
    reads: str = ""

    def __post_init__(self) -> None:
        for name in ("offset", "offset_uncertainty"):
            object.__setattr__(self, name, number(name, getattr(self, name)))
        if self.offset_uncertainty < 0:
            words = "must not be negative; it is a standard deviation"
            raise InputError(words, key="offset_uncertainty", value=self.offset_uncertainty)
        scale = number("scale", self.scale)
        if scale == 0:
            raise InputError("must not be zero, the column would be lost", key="scale", value=0.0)
        object.__setattr__(self, "scale", scale)

    @property
    def table(self) -> dict[str, object]:
        """The channel as a file has it, what only rigs of bodies or matrices have left out where it is not given."""
        given: dict[str, object] = {"column": self.column, "unit": self.unit, "scale": self.scale}
        more = {name: getattr(self, name) for name in ("offset", "offset_uncertainty", "reads")}
        return given | {name: one for name, one in more.items() if one}


def refuse_sensor(name: str, channel: Channel, rig: AnyRig) -> None:
    """Refuse what only a channel of a rig of bodies or matrices may have, of another rig.

    Raises
    ------
    InputError
        With the key.
    """
    for key in ("offset", "offset_uncertainty", "reads"):
        if getattr(channel, key) and not isinstance(rig, GeneralRig):
            words = "is for rigs of bodies or matrices; leave it out, and put an offset into the file"
            raise InputError(words, key=f"{name}.{key}", value=getattr(channel, key))


def in_si(unit: str, si: str, *, what: str) -> float:
    """Return the size of one `unit` in the SI unit `si`.

    Raises
    ------
    InputError
        pint does not know the unit, it measures something else, or it has an offset (degC).
    """
    import pint

    units = registry()
    try:
        parsed = units.Unit(unit)
    except Exception:  # pint raises of many kinds, those of Python's tokenizer too
        words = f"unknown unit; {what} needs one like '{si}' or '1'"
        raise InputError(words, key="unit", value=unit) from None
    try:
        return float(units.Quantity(1.0, parsed).to(si).magnitude)
    except pint.errors.PintError:
        words = f"measures {_dimension(parsed)}, but this is {what}; give a unit like '{si}'"
        raise InputError(words, key="unit", value=unit) from None


def is_unit(text: str) -> bool:
    """Say whether a text is a unit that pint knows."""
    try:
        registry().Unit(text)
    except Exception:  # pint raises of many kinds, those of Python's tokenizer too
        return False
    return True


def same_unit(one: str, other: str) -> bool:
    """Say whether two spellings are one unit: "sec" and "s", "Newton" and "N"."""
    if one == other or "1" in (one, other):
        return one == other
    units = registry()
    try:
        return abs(float(units.Quantity(1.0, one).to(other).magnitude) - 1) < 1e-12
    except Exception:  # pint raises of many kinds: whatever it cannot turn is not the same
        return False


def same_dimension(one: str, other: str) -> bool:
    """Say whether two units measure the same kind of thing; "1" is of no kind."""
    if "1" in (one, other):
        return one == other
    try:
        return bool(registry().Unit(one).is_compatible_with(other))
    except Exception:  # pint raises of many kinds: what it does not know measures nothing
        return False


def _dimension(unit: object) -> str:
    dimension = str(getattr(unit, "dimensionality", "")).replace("[", "").replace("]", "")
    return "a pure number" if dimension == "dimensionless" else dimension


def factor(channel: str, unit: str, rig: AnyRig) -> float:
    """Return what a reading in `unit` is multiplied by to be the model's number.

    Parameters
    ----------
    channel
        "t", "x1", "y1", "belt", "spring_force" or "drive"; of a rig of bodies or matrices what is read, one of
        `channel_units`.
    unit
        Unit of the reading; "1" is nondimensional and gives 1 (for a spring force: 1/stiffness). A drive in volts
        or amperes gives 1 too: its channel's `scale` is the gain in N per unit.
    rig
        A `Rig` with scales takes any unit, one without takes "1" alone. A `BlockOnBelt` or
        `DrivenSlider` in SI is the model of readings in units, a nondimensional one of readings in "1"; its
        numbers are used as they are.

    Raises
    ------
    InputError
        Unknown unit, a unit of something else, or a unit where the rig has no scales.
    """
    if isinstance(rig, GeneralRig):
        return _of_coordinate(channel, unit, rig)
    si, what = DIMENSIONS[channel]
    if channel == "spring_force":
        stiffness = rig.stiffness if isinstance(rig, BlockOnBelt) else 1.0
        return (1.0 if unit == "1" else in_si(unit, si, what=what)) / stiffness
    if unit == "1":
        return 1.0
    if channel == "y1" and is_angle(unit):
        if not isinstance(rig, Rig):
            kind = "block on a belt" if isinstance(rig, BlockOnBelt) else "driven slider"
            raise InputError(f"a {kind} has no angle body", key="unit", value=unit)
        scales = _scales(rig, unit)
        return in_si(unit, "rad", what="an angle") * scales.r / scales.length
    if channel == "drive" and is_electric(unit):
        return 1.0
    size = in_si(unit, si, what=what)
    if not isinstance(rig, Rig):
        return size
    scales = _scales(rig, unit)
    return size / {"t": scales.time, "belt": scales.velocity}.get(channel, scales.length)


def _of_coordinate(channel: str, unit: str, rig: GeneralRig) -> float:
    """What a reading of a rig of bodies or matrices is multiplied by; its numbers are in SI."""
    si = rig.channel_units[channel]
    if unit == "1":
        return 1.0
    if si == "1":
        raise InputError("this coordinate has no unit; give '1'", key="unit", value=unit)
    if si == "m/s^2" and unit in OF_GRAVITY:  # pint's g is a gram
        return OF_GRAVITY[unit]
    return in_si(unit, si, what="a position" if si == "m" else NAMES[si])


def is_angle(unit: str) -> bool:
    """Say whether `unit` measures an angle."""
    return is_unit(unit) and dimensions(unit) == dimensions("rad")


def is_electric(unit: str) -> bool:
    """Say whether `unit` measures a voltage or a current, as a drive's command may be recorded."""
    import pint

    try:
        parsed = registry().Unit(unit)
    except (pint.errors.PintError, ValueError, AssertionError, TypeError):
        return False
    return any(parsed.is_compatible_with(one) for one in ("V", "A"))


def _scales(rig: Rig, unit: str) -> Scales:
    if rig.scales is None:
        words = "the rig is nondimensional: give unit '1', or declare it in SI (m, J, r, k1, ..., length)"
        raise InputError(words, key="unit", value=unit)
    return rig.scales


def speed(given: float | str, unit: str, rig: AnyRig) -> float:
    """Return a belt set-point as the model's number.

    Parameters
    ----------
    given
        A number in `unit`, or text with a unit of its own ("1100 um/s").
    unit
        Unit of the belt channel; where none is recorded, `default_speed_unit`.
    rig
        As for `factor`.

    Raises
    ------
    InputError
        Not a finite number, or a unit that is not one of velocity.
    """
    if not isinstance(given, str):
        return number("belt_speed", given) * factor("belt", unit, rig)
    try:
        size, own = with_unit(given)
    except ValueError:
        words = "not a number with a unit; give one like 0.1 or '12 mm/s'"
        raise InputError(words, key="belt_speed", value=given) from None
    try:
        return number("belt_speed", size) * factor("belt", own or unit, rig)
    except InputError as error:
        raise InputError(error.what, key="belt_speed", value=given) from None


def default_speed_unit(rig: AnyRig) -> str:
    """Return the unit of a set-point without a belt channel: m/s for an SI rig, nondimensional otherwise."""
    if isinstance(rig, GeneralRig):
        return rig.equations.belt_unit
    return "m/s" if not isinstance(rig, Rig) or rig.scales is not None else "1"
