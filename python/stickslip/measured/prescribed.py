"""The prescribed speeds of a run: what it says of them, or what a channel of it reads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.prescribed import Given, set_point
from stickslip.declared.rig import AnyRig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.speeds import Speed
from stickslip.declared.units import Channel, default_speed_unit, factor, speed
from stickslip.errors import InputError
from stickslip.measured.straight_pieces import straight_pieces

Floats = NDArray[np.float64]
MEASURED = "measured"


def prescribed(
    rig: AnyRig,
    channels: Mapping[str, Channel],
    belt: Given | None,
    drive: Given | None,
    read: Mapping[str, Floats] | None = None,
    noise: Mapping[str, float] | None = None,
) -> dict[str, Speed]:
    """Return the prescribed speeds of a run of a rig of bodies or matrices; none of others.

    Parameters
    ----------
    rig, channels
        Numbers are in the unit of the speed's channel; in SI where it is not recorded.
    belt, drive
        What the run says of them; "measured": what the channel reads.
    read, noise
        Readings (n,) by channel, and the standard deviations that are known, in SI. None: nothing is read yet, and what
        is measured is left out.

    Raises
    ------
    InputError
        One is missing, given where nothing moves at it, no speed, or not recorded.
    """
    out = dict[str, Speed]()
    if not isinstance(rig, GeneralRig):
        return out
    own = rig.equations
    for channel, given, needed, unit in (
        ("belt", belt, own.on_belt, own.belt_unit),
        ("drive", drive, own.driven, own.drive_unit),
    ):
        key = f"{channel}_speed"
        if not needed:
            if given:
                what = "no contact rubs on a belt" if channel == "belt" else "nothing is pulled by a drive"
                raise InputError(f"{what} in this rig; leave it out", key=key)
            continue
        if given is None:
            what = "a contact rubs on the belt" if channel == "belt" else "a link is pulled by the drive"
            hint = f", or \"{MEASURED}\", as channel '{channel}' reads it" if channel in channels else ""
            raise InputError(f"missing: {what}; give its speed{hint}", key=key)
        if _is_measured(given):
            if channel not in channels:
                words = f"no channel '{channel}' is recorded; give a number, a formula of t or steps"
                raise InputError(words, key=key, value=given)
            if read is not None:
                out[key] = _measured(read, noise or {}, channel)
            continue
        per_unit = factor(channel, channels[channel].unit, rig) if channel in channels else 1.0
        out[key] = set_point(given, unit, per_unit, key)
    return out


def taken_from(rig: AnyRig, belt: object, drive: object) -> tuple[str, ...]:
    """Return the channels that prescribed speeds are taken from: they are no readings beside them."""
    if not isinstance(rig, GeneralRig):
        return ()
    of = (("belt", belt, rig.equations.on_belt), ("drive", drive, rig.equations.driven))
    return tuple(name for name, given, moves in of if moves and _is_measured(given))


def _is_measured(given: object) -> bool:
    return isinstance(given, str) and given.strip() == MEASURED


def _measured(read: Mapping[str, Floats], noise: Mapping[str, float], channel: str) -> Speed:
    """The speed that a channel reads, by the clock of the run's first sample."""
    t, key, place = read["t"] - read["t"][0], f"{channel}_speed", f"x_{channel}"
    found = straight_pieces(t, read[channel], noise.get(channel))
    if len(found.t) == 1:
        return Speed.of(float(found.values[0]), key)
    if place in read:
        found = found.by_way(t, read[place], noise.get(place))
    speed = Speed.measured(found.t, found.values, key)
    return replace(speed, text=f"measured, {len(t)} samples in {len(found.t) - 1} pieces")


def set_point_of(rig: AnyRig, channels: Mapping[str, Channel], given: object) -> float:
    """Return the belt's speed of a named rig, in the model's numbers.

    Raises
    ------
    InputError
        Not a number, or one with a unit of something else.
    """
    unit = channels["belt"].unit if "belt" in channels else default_speed_unit(rig)
    if isinstance(given, (Speed, list, tuple)) or _is_measured(given):
        words = (
            "must be one number on a named rig; declare it by bodies for steps, formulas and measured speeds"
        )
        raise InputError(words, key="belt_speed", value=given if isinstance(given, str) else None)
    return speed(given, unit, rig)  # type: ignore[arg-type]  # it looks


def constant(speeds: Mapping[str, Speed]) -> float:
    """Return the belt's speed of a general rig where it is a number; 0 where nothing rubs on a belt."""
    belt = speeds.get("belt_speed")
    if belt is None:
        return 0.0
    return math.nan if belt.constant is None else belt.constant
