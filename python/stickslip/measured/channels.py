"""The channels of a recording: which a rig needs, what speaks against those declared, and the columns they are in."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from stickslip.declared.rig import AnyRig, BlockOnBelt, DrivenSlider
from stickslip.declared.units import Channel, factor, is_electric, is_unit, same_unit
from stickslip.errors import InputError, Place, did_you_mean, number
from stickslip.measured.readers.tables import column_names

_HEAD = re.compile(r"(.*?\S)\s*(?:\[([^\]]*)\]|\(([^)]*)\)|/\s*(\S+))\s*$")


def needed_channels(rig: AnyRig) -> tuple[str, ...]:
    """Return the channels a rig cannot do without; a spring force may stand for x1 of a block on a belt."""
    if isinstance(rig, DrivenSlider):
        return ("t", "x1", "drive")
    return ("t", "x1") if isinstance(rig, BlockOnBelt) else ("t", "x1", "y1")


def check_channels(channels: Mapping[str, Channel], rig: AnyRig) -> None:
    """Raise `InputError` if channels are unknown, missing, or contradict each other or the rig."""
    one_degree = isinstance(rig, BlockOnBelt)
    driven = isinstance(rig, DrivenSlider)
    known = [*needed_channels(rig), *(["spring_force"] if one_degree else []), *([] if driven else ["belt"])]
    for name in channels:
        if name not in known:
            raise InputError(f"unknown channel of this rig; {did_you_mean(name, known)}", key=name)
    for name in needed_channels(rig):
        if name not in channels and not (name == "x1" and "spring_force" in channels and one_degree):
            either = "x1 or spring_force" if one_degree and name == "x1" else name
            raise InputError(f"no channel {either}; this rig needs {', '.join(needed_channels(rig))}")
    if "x1" in channels and "spring_force" in channels:
        raise InputError("x1 is recorded too; give one of them", key="spring_force")
    _check_columns(channels)
    if (one_degree or driven) and len({channel.unit == "1" for channel in channels.values()}) > 1:
        bare = next(name for name, channel in channels.items() if channel.unit == "1")
        kind = "block on a belt" if one_degree else "driven slider"
        raise InputError(f"unit '1' beside units; the numbers of a {kind} are all SI or all bare", key=bare)
    if driven and channels["drive"].scale == 1 and is_electric(channels["drive"].unit):
        words = "a command in volts or amperes needs `scale`, the drive's gain in N for 1 of its unit"
        raise InputError(words, key="drive")


def _check_columns(channels: Mapping[str, Channel]) -> None:
    """Refuse a column that is read as two quantities: a copied line of [channels], its column forgotten."""
    by_column: dict[str, str] = {}
    for name, channel in channels.items():
        if (first := by_column.setdefault(channel.column, name)) != name:
            words = f"reads column '{channel.column}', which channel '{first}' reads too; each has its own"
            raise InputError(words, key=name)


def channel_factor(name: str, channel: Channel, rig: AnyRig) -> float:
    """Return the model's number for 1 in a channel's column: unit and scale together."""
    return channel.scale * factor(name, channel.unit, rig)


def noise_in_model(
    noise: Mapping[str, float], channels: Mapping[str, Channel], rig: AnyRig
) -> dict[str, float]:
    """Turn standard deviations in the units of the channels into the model's numbers.

    Raises
    ------
    InputError
        Of a channel that is not recorded, or not positive.
    """
    turned = {}
    for name, value in noise.items():
        if name not in channels:
            raise InputError(f"no such channel; {did_you_mean(name, channels)}", key=name)
        why = "leave it out to have it estimated"
        key = "x1" if name == "spring_force" else name
        turned[key] = number(name, value, above=0, why=why) * abs(factor(name, channels[name].unit, rig))
    return turned


def by_heads(path: str | os.PathLike[str], channels: Mapping[str, Channel]) -> dict[str, Channel]:
    """Return the channels with their columns as the file heads them: "x1 [mm]" may stand for x1 in mm.

    Raises
    ------
    InputError
        The head has another unit than the channel is declared in, and no `scale` turns one into the other.
    """
    out, there = dict(channels), column_names(path)
    for name, one in channels.items():
        if one.column in there:
            headed = [one.column]
        else:
            headed = [head for head in there if (parts := head_parts(head)) and parts[0] == one.column]
        if len(headed) != 1:
            continue
        parts = head_parts(headed[0])
        if parts is not None and one.scale == 1 and not same_unit(parts[1], one.unit):
            words = f"the file has '{headed[0]}', but its channel is declared in '{one.unit}'"
            raise InputError(words, place=Place(str(Path(path)), column=one.column))
        out[name] = replace(one, column=headed[0])
    return out


def head_parts(head: str) -> tuple[str, str] | None:
    """Return the name and the unit of a column's head, as "x1 [mm]", "x1(mm)" or "x1 / mm"; None if it has no unit."""
    found = _HEAD.match(head)
    if found is None:
        return None
    unit = next(part for part in found.groups()[1:] if part is not None).strip()
    unit = "1" if unit in ("", "-") else unit
    return (found[1], unit) if unit == "1" or is_unit(unit) else None


def bare_channels(path: str | os.PathLike[str], rig: AnyRig) -> dict[str, Channel]:
    """Channels of a file whose columns bear the channels' names."""
    names = [*needed_channels(rig), *(["belt"] if "belt" in column_names(path) else [])]
    return {name: Channel(name) for name in names}
