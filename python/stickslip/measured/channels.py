"""The channels of a recording: which a rig needs, what speaks against those declared, and the columns they are in."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

from stickslip.declared.rig import AnyRig, BlockOnBelt, DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.units import Channel, factor, is_electric, refuse_sensor, same_unit
from stickslip.errors import InputError, Place, did_you_mean, number
from stickslip.measured.readers.columns import Contents, Source
from stickslip.measured.readers.tables import column_names


def needed_channels(rig: AnyRig) -> tuple[str, ...]:
    """Return the channels a rig cannot do without; a spring force may stand for x1 of a block on a belt."""
    if isinstance(rig, DrivenSlider):
        return ("t", "x1", "drive")
    return ("t", "x1") if isinstance(rig, BlockOnBelt) else ("t", "x1", "y1")


def check_channels(channels: Mapping[str, Channel], rig: AnyRig) -> None:
    """Raise `InputError` if channels are unknown, missing, or contradict each other or the rig."""
    if isinstance(rig, GeneralRig):
        _check_coordinates(channels, rig)
        return
    for name, channel in channels.items():
        refuse_sensor(name, channel, rig)
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


def _check_coordinates(channels: Mapping[str, Channel], rig: GeneralRig) -> None:
    """The same for a rig of bodies or matrices: channels bear the names of what they read, or say it (`reads`)."""
    known, sensors = [*rig.channel_units], [*rig.state_names, *rig.equations.sensed]
    for name, channel in channels.items():
        if channel.reads:
            _check_second(name, channel, known, sensors)
        elif name not in known:
            raise InputError(f"unknown channel of this rig; {did_you_mean(name, known)}", key=name)
        elif name not in sensors and (channel.offset or channel.offset_uncertainty):
            raise InputError("time and prescribed speeds have no offset; correct the column", key=name)
    if "t" not in channels:
        raise InputError(f"no channel t; this rig needs t and one of {', '.join(rig.state_names)}")
    read = {channel.reads or name for name, channel in channels.items()}
    placing = [name for name in sensors if not name.startswith("a_") or name in rig.state_names]
    if not read & set(placing):
        words = (
            "accelerations alone do not say where the bodies are"
            if read & set(sensors)
            else "nothing is read"
        )
        raise InputError(f"{words}; record one of {', '.join(placing)}")
    _check_columns(channels)


def _check_second(name: str, channel: Channel, known: Sequence[str], sensors: Sequence[str]) -> None:
    """Refuse a second sensor of what is not there, and one that bears another sensor's name."""
    if channel.reads not in sensors:
        raise InputError(f"no such reading; {did_you_mean(channel.reads, sensors)}", key=f"{name}.reads")
    if name in known and name != channel.reads:
        raise InputError(f"'{name}' is a reading of its own; name this channel otherwise", key=name)
    if not name.isidentifier():
        raise InputError("is no name; letters, digits and _ make one", key=name)


def _check_columns(channels: Mapping[str, Channel]) -> None:
    """Refuse a column that is read as two quantities: a copied line of [channels], its column forgotten.

    One name for all channels may be that of a matrix: the file shows it (`by_place`).
    """
    if len(channels) > 1 and len({channel.column for channel in channels.values()}) == 1:
        return
    by_column: dict[str, str] = {}
    for name, channel in channels.items():
        if (first := by_column.setdefault(channel.column, name)) != name:
            words = f"reads column '{channel.column}', which channel '{first}' reads too; each has its own"
            raise InputError(words, key=name)


def channel_factor(name: str, channel: Channel, rig: AnyRig) -> float:
    """Return the model's number for 1 in a channel's column: unit and scale together."""
    return channel.scale * factor(channel.reads or name, channel.unit, rig)


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
        turned[key] = number(name, value, above=0, why=why) * abs(
            factor(channels[name].reads or name, channels[name].unit, rig)
        )
    return turned


def by_place(
    there: Contents, channels: Mapping[str, Channel], file: str
) -> tuple[dict[str, Channel], list[str]]:
    """Return the channels with columns that have no names, and what was guessed: they are taken in their order.

    All channels may name one matrix or cell; or the file holds one of them and nothing else. There must be a column
    for each channel.

    Raises
    ------
    InputError
        All channels name one column; or a matrix that has more columns than there are channels, or fewer.
    """
    asked = dict.fromkeys(channel.column for channel in channels.values())
    first = next(iter(asked))
    one_name = len(asked) == 1 < len(channels)
    of = first if one_name else next(iter(there.unnamed), "")
    parts = there.unnamed.get(of, ())
    if one_name and len(parts) != len(channels):
        what = (
            f"has {len(parts)} columns; {parts[0]} is one"
            if parts
            else "is one column, if it is there at all"
        )
        words = (
            f"{what}, and {len(channels)} channels ({', '.join(channels)}) name it; each has its own column"
        )
        raise InputError(words, place=Place(file, column=first))
    strangers = not any(head_of(column, there) for column in asked)
    if not one_name and not (strangers and parts == there.names and len(parts) == len(channels)):
        return dict(channels), []
    out = {name: replace(one, column=part) for (name, one), part in zip(channels.items(), parts, strict=True)}
    order = ", ".join(f"{part} is {name}" for name, part in zip(channels, parts, strict=True))
    return out, [f"{of}: its columns have no names, taken in the order of the channels: {order}"]


def by_heads(
    source: Source, channels: Mapping[str, Channel], file: str
) -> tuple[dict[str, Channel], list[str]]:
    """Return the channels with their columns as the file heads them, and what is doubtful about their units.

    "x1 [mm]" may stand for x1 in mm. A unit that the file gives a column, in its head or elsewhere, is the declared
    one, or of a voltage or a current: the output of an amplifier, of which only the declaration knows what it measures.

    Raises
    ------
    InputError
        The file has another unit than the channel is declared in, and no `scale` turns one into the other.
    """
    out, doubts, there = dict(channels), [], source.contents
    for name, one in channels.items():
        head = head_of(one.column, there)
        if head is None:
            continue
        parts = there.head(head)
        unit = there.units.get(head) or (parts[1] if parts else None)
        if unit is not None and one.scale == 1 and not same_unit(unit, one.unit):
            if not is_electric(unit) or parts is not None:
                shown = there.titles.get(head, head) if parts else f"{head} in {unit}"
                words = f"the file has '{shown}', but its channel is declared in '{one.unit}'"
                raise InputError(words, place=Place(file, column=one.column))
            doubts.append(f"{name}: the file says {unit}; 1 {unit} is taken for 1 {one.unit}, as declared")
        out[name] = replace(one, column=head)
    return out, doubts


def head_of(column: str, there: Contents) -> str | None:
    """The name that the file has for a declared column, if just one is like it."""
    if column in there.names:
        return column
    heads = [head for head in there.names if (parts := there.head(head)) and parts[0] == column]
    if not heads and column in there.also:
        return there.also[column]
    return heads[0] if len(heads) == 1 else None


def bare_channels(path: str | os.PathLike[str], rig: AnyRig) -> dict[str, Channel]:
    """Channels of a file whose columns bear the channels' names."""
    if isinstance(rig, GeneralRig):
        there = column_names(path, ("t",))
        return {name: Channel(name) for name in rig.channel_units if name in there}
    needed = needed_channels(rig)
    names = [*needed, *(["belt"] if "belt" in column_names(path, needed) else [])]
    return {name: Channel(name) for name in names}
