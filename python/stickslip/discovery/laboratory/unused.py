"""What a search of windows does without, and what is a window for want of sticks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from stickslip.fitted.data import Data
from stickslip.likelihoods.block_windows import drowned
from stickslip.likelihoods.stretches import Stretch, stretches
from stickslip.measured.case import Case, Recording
from stickslip.measured.stick_speed import CLEAR, NEAR, why_idle, wrong_set_point

DROWNED = "left out: what passes for slips in it are peaks of noise"
SWINGS = "no stick is found in it: it is fitted from slip to slip, each from a start of its own"


def usable(recordings: Sequence[Recording], data: Sequence[Data]) -> tuple[list[Data], dict[str, str]]:
    """
    Return the runs that have windows, and why others have none, by name.

    A run is of use if its set-point may be right: sticks show it, and without any it must be nearer. What passes for
    slips may be peaks of noise.

    Parameters
    ----------
    recordings, data : the runs, in the same order
    """
    every = stretches(data)
    sticks = {one.run for one in every if one.stuck}
    swings = {one.run for one in every} - sticks
    why = {}
    for number, (recording, run) in enumerate(zip(recordings, data, strict=True)):
        if drowned(run):
            why[run.name] = DROWNED
        elif wrong := wrong_set_point(recording, clear=CLEAR if number in sticks else NEAR):
            why[run.name] = f"no slip is used: {wrong}"
        elif number not in sticks | swings:
            why[run.name] = f"no slip is used: {why_idle(recording, 0)}"
    return [run for run in data if run.name not in why], why


def with_windows(
    case: Case, used: Sequence[Data], every: Sequence[Stretch], why: Mapping[str, str]
) -> tuple[Case, tuple[str, ...]]:
    """
    Return the case without the train runs that have no windows, and in words what is fitted in another way, or not.

    Parameters
    ----------
    case : as declared
    used, every : its train runs that have windows, and these
    why : others have none, by name
    """
    kept = {run.name for run in used}
    gone = [run.name for run in case.train if run.name not in kept]
    sticks = {used[one.run].name for one in every if one.stuck}
    words = [f"{name}: {why[name]}" for name in gone]
    words += [f"{run.name}: {SWINGS}" for run in used if run.name not in sticks]
    return replace(case, runs=tuple(run for run in case.runs if run.name not in gone)), tuple(words)


def stood_out(every: Sequence[Stretch], fitted: Sequence[Stretch]) -> tuple[str, ...]:
    """Return in words how many windows were left out beside what was found; nothing where none was."""
    out = len(every) - len(fitted)
    why = "beside what was found their friction or their belt is like no other's, so that they began in no stick"
    return (f"{out} of {len(every)} windows are not fitted: {why}",) if out else ()
