"""The force of a driven slider's drive over time: a number, a formula of t, or samples that hold until the next."""

from __future__ import annotations

from numpy.typing import ArrayLike

from stickslip.declared.rig import AnyRig, DrivenSlider
from stickslip.declared.scale import written_speed
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError

Pull = float | str | Speed | None
Drive = float | str | Speed | tuple[ArrayLike, ArrayLike]
KEY = "drive"
LIKE = "'4 N', a formula of t ('20*sin(3*t)') or (times, forces)"


def drive_of(given: object, rig: AnyRig) -> Speed | None:
    """Return the force of the drive [N]; None of a rig that has none.

    Parameters
    ----------
    given
        A number, text with a unit or a formula of t, or a pair (times, forces) whose forces hold from each time to the
        next, the first before and the last after all.
    rig
        What it moves.

    Raises
    ------
    InputError
        Not one of these, missing for a driven slider, or given for another rig.
    """
    if not isinstance(rig, DrivenSlider):
        if given is not None:
            raise InputError("no force moves this rig; an effect by a formula adds one", key=KEY)
        return None
    if given is None:
        raise InputError(f"missing: the force on the slider; give {LIKE}", key=KEY)
    if isinstance(given, (tuple, list)) and len(given) == 2:
        times, forces = given
        return Speed.held(times, forces, KEY)
    return Speed.of(written_speed(given, rig, KEY), KEY)


def pull_or_force(rig: AnyRig, pull: Pull, drive: object) -> Pull:
    """Return the speed of a drive that pulls, or the force of a driven slider's in its place.

    Raises
    ------
    InputError
        As `drive_of`, or both are given.
    """
    force = drive_of(drive, rig)
    if force is not None and pull is not None:
        raise InputError("nothing is pulled in this rig; `drive` is the force on it", key="drive_speed")
    return pull if force is None else force
