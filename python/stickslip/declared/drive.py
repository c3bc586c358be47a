"""The force of a driven slider's drive over time: a number, a formula of t, or samples that hold until the next."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.arguments import vector
from stickslip.declared.formula.dimension import dimensions, said, to_si
from stickslip.declared.formula.tree import Number
from stickslip.declared.quantity import with_unit
from stickslip.declared.rig import AnyRig, DrivenSlider
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
    if isinstance(given, str):
        return _written(given)
    if isinstance(given, (tuple, list)) and len(given) == 2:
        return _held(*given)
    return Speed.of(given, KEY)


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


def _written(text: str) -> Speed:
    try:
        size, unit = with_unit(text)
    except ValueError:
        return Speed.of(text, KEY)
    if unit and not unit[:1].isalpha():
        return Speed.of(text, KEY)
    try:
        size, own = to_si(size, unit) if unit else (size, "N")
    except InputError as error:
        raise InputError(error.what, key=KEY, value=text) from None
    if dimensions(own) != dimensions("N"):
        raise InputError(f"is {said(dimensions(own))}; it must be a force, like '4 N'", key=KEY, value=text)
    return Speed.of(size, KEY)


def _held(times: Any, forces: Any) -> Speed:
    t, f = vector(f"{KEY} times", times, "times"), vector(KEY, forces, "forces")
    if len(t) != len(f) or not len(t):
        raise InputError(f"has {len(f)} forces at {len(t)} times; give one for each", key=KEY)
    if not (np.isfinite(t).all() and np.isfinite(f).all()):
        raise InputError("has samples that are not finite", key=KEY)
    falls = np.flatnonzero(np.diff(t) <= 0)
    if len(falls):
        i = int(falls[0]) + 1
        words = f"its times must increase; entry {i} is {t[i]:g} after {t[i - 1]:g}"
        raise InputError(words, key=KEY)
    new = np.concatenate([[True], f[1:] != f[:-1]])
    pieces = tuple(Number(float(one)) for one in f[new])
    return Speed(tuple(t[new].tolist()), pieces, f"{len(t)} samples, each held until the next")
