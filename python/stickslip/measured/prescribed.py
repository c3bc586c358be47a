"""The prescribed speeds of a run of a rig of bodies or matrices."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.declared.prescribed import set_point
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.speeds import Speed
from stickslip.declared.units import Channel, factor
from stickslip.errors import InputError


def prescribed(
    rig: GeneralRig, channels: Mapping[str, Channel], belt: float | str | None, drive: float | str | None
) -> dict[str, Speed]:
    """Return the prescribed speeds of a run of a rig of bodies or matrices.

    Parameters
    ----------
    rig, channels
        Numbers are in the unit of the speed's channel; in SI where it is not recorded.
    belt, drive
        What the run says of them.

    Raises
    ------
    InputError
        One is missing, given where nothing moves at it, or no speed.
    """
    own = rig.equations
    out = {}
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
            raise InputError(f"missing: {what}; give its speed", key=key)
        per_unit = factor(channel, channels[channel].unit, rig) if channel in channels else 1.0
        out[key] = set_point(given, unit, per_unit, key)
    return out
