"""Which column of a file is which channel: by its unit, by its name, or as it is given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stickslip.declared.units import DIMENSIONS, Channel, is_angle, is_electric, same_dimension
from stickslip.errors import InputError, Place, did_you_mean, number
from stickslip.measured.heads import unit_in
from stickslip.measured.inspection import Column, Inspection
from stickslip.measured.lacking import LackingError

WANTED = {  # in the order in which they choose; the last of a kind of rig may be absent
    "two_degree": ("t", "x1", "y1", "belt"),
    "block_on_belt": ("t", "spring_force", "x1", "belt"),
    "driven_slider": ("t", "drive", "x1"),
}
CALLED = {
    "x1": ("x1", "x", "block", "displacement", "position", "deflection", "weg"),
    "y1": ("y1", "y", "angle", "leg", "winkel"),
    "belt": ("belt", "belt speed", "v_b", "vb", "velocity"),
    "spring_force": ("spring_force", "force", "f", "friction force", "kraft", "load"),
    "drive": ("drive", "command", "force", "u", "f"),
}


@dataclass(frozen=True)
class Roles:
    """The channels of a file, and why one is doubtful."""

    channels: dict[str, Channel]
    doubts: dict[str, str]


def roles_of(found: Inspection, kind: str, given: Sequence[str], *, bare: bool) -> Roles:
    """Return which column is which channel.

    Parameters
    ----------
    found
        The file.
    kind
        The kind of rig.
    given
        What is known: "x1=block", "x1=block:mm", "x1=block:mm:0.5" (channel, column, unit, scale).
    bare
        Whether the rig is nondimensional: every unit is "1".
    """
    wanted = WANTED[kind]
    stated = dict(_stated(one, found, wanted) for one in given)
    channels: dict[str, Channel] = {}
    doubts: dict[str, str] = {}
    for name in wanted:
        if name == "x1" and "spring_force" in channels:
            continue
        if name in stated:
            column, unit, scale = stated[name]
        else:
            guess, doubt = _guessed(found, name, channels, stated, bare=bare)
            if guess is None:
                _must_not_lack(name, kind, found)
                continue
            column = guess
            doubts |= {name: doubt} if doubt else {}
            unit, scale = None, 1.0
        if unit is None:
            unit, doubt = _unit(name, column, bare=bare)
            doubts |= {name: doubt} if doubt else {}
        channels[name] = Channel(column.name, unit, scale)
    return Roles({name: channels[name] for name in ("t", *channels)}, doubts)


def _stated(
    text: str, found: Inspection, wanted: Sequence[str]
) -> tuple[str, tuple[Column, str | None, float]]:
    """A channel as an option gives it."""
    name, _, rest = text.partition("=")
    if name not in wanted:
        raise InputError(f"no channel of this rig; {did_you_mean(name, wanted)}", key="--channel", value=text)
    names = sorted(
        {one for column in found.columns for one in (column.name, column.head)}, key=len, reverse=True
    )
    of = next((one for one in names if rest == one or rest.startswith(f"{one}:")), None)
    if of is None or (column := found.column(of)) is None:
        words = f"no such column; {did_you_mean(rest.partition(':')[0], names)}"
        raise InputError(words, key="--channel", value=text)
    unit, _, scale = rest[len(of) + 1 :].partition(":")
    if unit and unit_in(unit) is None:
        raise InputError("unknown unit; write it as NAME=COLUMN:UNIT", key="--channel", value=text)
    try:
        size = float(scale) if scale else 1.0
    except ValueError:
        raise InputError("the scale is not a number", key="--channel", value=text) from None
    return name, (column, unit or None, number("scale", size))


def _guessed(
    found: Inspection,
    name: str,
    taken: dict[str, Channel],
    stated: dict[str, tuple[Column, str | None, float]],
    *,
    bare: bool,
) -> tuple[Column | None, str]:
    """The column of a channel, and what is doubtful about it."""
    if name == "t":
        return found.time, ""
    used = {one.column for one in taken.values()} | {column.name for column, _, _ in stated.values()}
    free = [one for one in found.columns if one.values is not None and one.name not in used]
    free = [
        one
        for one in free
        if one is not found.time and (bare or one.unit is None or _measures(name, one.unit))
    ]
    called = [one for one in free if one.head.rpartition("/")[2].lower() in CALLED[name]]
    called.sort(key=lambda one: CALLED[name].index(one.head.rpartition("/")[2].lower()))
    by_unit = [one for one in free if one.unit is not None and not bare]
    chosen = next(iter([*(one for one in called if one in by_unit), *called, *by_unit]), None)
    if chosen is None:
        return None, ""
    rivals = [one.head for one in (by_unit if chosen in by_unit else called) if one is not chosen]
    return chosen, f"or is it {' or '.join(rivals[:3])}?" if rivals and chosen not in called else ""


def _measures(name: str, unit: str) -> bool:
    if name == "y1" and is_angle(unit):
        return True
    return same_dimension(unit, DIMENSIONS[name][0]) or (name == "drive" and is_electric(unit))


def _must_not_lack(name: str, kind: str, found: Inspection) -> None:
    """Ask for a channel that the rig cannot do without, or say why its column cannot be read."""
    if name == "belt" or (name == "spring_force" and kind == "block_on_belt"):
        return
    for one in found.columns:
        if one.values is None and one.unit is not None and _measures(name, one.unit):
            raise InputError(
                one.doubt or "holds words, no numbers", place=Place(str(found.path), column=one.head)
            )
    either = "x1 or spring_force" if kind == "block_on_belt" and name == "x1" else name
    there = ", ".join(one.head for one in found.columns)
    raise LackingError(f"the column of {either}; there are {there}", option="--channel", begins=f"{name}=")


def _unit(name: str, column: Column, *, bare: bool) -> tuple[str, str]:
    """The unit of a column, and what is doubtful about it."""
    if bare:
        return "1", ""
    if column.unit is not None:
        return column.unit, ""
    if name == "t":
        return "s", "the file says no unit"
    words = f"the unit of column '{column.name}', taken for {name}"
    raise LackingError(words, option="--channel", begins=f"{name}={column.name}:")
