"""Windows of a rig of several contacts: from mid-stick to mid-stick, else of a natural period.

Where a measured belt jumps between two samples a window begins too: how far the belt went meanwhile is not known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.measured.intervals import intervals
from stickslip.measured.sticks import BROKEN

Mask = NDArray[np.bool_]
STATE = 2  # of a contact at the start of a window: as the state there says
CLEAR = 2  # samples on both sides of a window's start in which a contact that sticks there sticks too
COVERED = (
    0.6  # share of a run's time that windows from stick to stick must hold; else the run is cut by the clock
)
LONGEST = 6.0  # windows by the clock's lengths that one from stick to stick may last; beyond, it is cut by the clock
BRIEF = 2  # samples of a stick that parts two events
APART = 0.5  # natural periods between such a stick and another
PERIODS = 1.2  # natural periods that a window by the clock lasts
SEARCHED = 0.25  # of such a window, to both sides of its end, where a quiet place for the cut is sought


@dataclass(frozen=True)
class Cut:
    """
    Samples start <= i < stop of a run.

    Parameters
    ----------
    run, start, stop : where it is
    modes : of the contacts at the start: 0 in stick, STATE: as the state says
    dwell : how long each contact has stuck there
    """

    run: int
    start: int
    stop: int
    modes: tuple[int, ...]
    dwell: tuple[float, ...]


def cuts(data: Sequence[BodiesData], policy: Policy = POLICY) -> list[Cut]:
    """Return the windows of all runs."""
    return [one for number, run in enumerate(data) for one in _of_run(number, run, policy)]


def tail(run: BodiesData, last: Cut, policy: Policy = POLICY) -> Cut:
    """Return what follows a run's last window, to the end of the run; where that is next to nothing, both."""
    sticks = _all_sticks(run, policy)
    start = last.stop if len(run.t) - last.stop > policy.fewest_stuck else last.start
    return _cut(last.run, run, sticks, start, len(run.t))


def starts_of_slips(
    run: BodiesData, contact: int, part: slice, policy: Policy = POLICY
) -> NDArray[np.float64]:
    """Return the times at which a contact lets go, (k,)."""
    sticks = _sticks(run.stuck[part, contact], policy.fewest_stuck)
    return run.t[part][[b for _, b in sticks if b < len(run.t[part]) - 1]]


def _all_sticks(run: BodiesData, policy: Policy) -> list[list[tuple[int, int]]]:
    """Sticks of every contact."""
    return [_sticks(run.stuck[:, j], policy.fewest_stuck) for j in range(run.stuck.shape[1])]


def _of_run(number: int, run: BodiesData, policy: Policy) -> list[Cut]:
    sticks = _all_sticks(run, policy)
    length, end = PERIODS * run.periods[0], len(run.t) - 1
    places = _stabbed([_inner(*one) for own in sticks for one in own])
    places = sorted([*places, *_brief(run, places)])
    if len(places) < 2 or run.t[places[-1]] - run.t[places[0]] < COVERED * run.t[-1]:
        places = [0, *places, end]
    places = sorted({*places, *(one for one in run.leaps if places[0] < one < places[-1])})
    out = [places[0]]
    for a, b in zip(places[:-1], places[1:], strict=True):
        if run.t[b] - run.t[a] > LONGEST * length:
            out += _by_clock(run, sticks, length, a, b)[1:-1]
        if run.t[b] > run.t[a]:
            out.append(b)
    return [
        _cut(number, run, sticks, a, b)
        for a, b in zip(out[:-1], out[1:], strict=True)
        if b - a >= policy.fewest_stuck
    ]


def _brief(run: BodiesData, places: Sequence[int]) -> list[int]:
    """
    Places in sticks too short for a window to begin in stick, as far from all others as a slip lasts.

    What lets go after one has friction of its own; the window begins as the state there says.
    """
    every = [_sticks(run.stuck[:, j], BRIEF) for j in range(run.stuck.shape[1])]
    out, known = list[int](), list(places)
    for place in _stabbed(sorted(one for own in every for one in own)):
        if all(abs(run.t[place] - run.t[other]) > APART * run.periods[0] for other in known):
            out.append(place)
            known.append(place)
    return out


def _inner(a: int, b: int) -> tuple[int, int]:
    """The middle half of a stick: smoothing blurs its ends."""
    return a + (b - a) // 4, b - (b - a) // 4


def _stabbed(sticks: Sequence[tuple[int, int]]) -> list[int]:
    """Fewest places of which every stick holds one, each in the middle of what its sticks have in common.

    So no contact lets go twice within a window, and its friction there is one.
    """
    out, common = list[int](), (0, -1)
    for a, b in sorted(sticks, key=lambda one: one[1]):
        if a > common[1]:  # apart from all that the last place is for
            if common[1] >= 0:
                out.append(sum(common) // 2)
            common = (a, b)
        else:
            common = (max(a, common[0]), common[1])
    return [*out, sum(common) // 2] if common[1] >= 0 else out


def _sticks(stuck: Mask, fewest: int) -> list[tuple[int, int]]:
    """First and last samples of a contact's sticks; noise may break one for a sample or two."""
    return [(a, b) for a, b in intervals(stuck, BROKEN).tolist() if b - a + 1 >= fewest]


def _by_clock(
    run: BodiesData, sticks: Sequence[list[tuple[int, int]]], length: float, first: int, last: int
) -> list[int]:
    """Places about a length apart, each as far from the ends of sticks as may be."""
    edges = np.array(sorted({0, len(run.t), *(edge for one in sticks for pair in one for edge in pair)}))
    count = max(1, round((run.t[last] - run.t[first]) / length))
    out = [first]
    for k in range(1, count):
        aim = run.t[first] + k * (run.t[last] - run.t[first]) / count
        low, high = np.searchsorted(run.t, [aim - SEARCHED * length, aim + SEARCHED * length])
        near = np.arange(max(low, out[-1] + 1), min(high, last))
        if len(near):
            gap = np.abs(near[:, None] - edges[None]).min(axis=1)
            out.append(int(near[np.argmax(gap)]))
    return [*out, last]


def _cut(number: int, run: BodiesData, sticks: Sequence[list[tuple[int, int]]], a: int, b: int) -> Cut:
    modes, dwell = [], []
    for own in sticks:
        here = next((one for one in own if one[0] + CLEAR <= a <= one[1] - CLEAR), None)
        modes.append(STATE if here is None else 0)
        dwell.append(0.0 if here is None else float(run.t[a] - run.t[here[0]]))
    return Cut(number, a, b, tuple(modes), tuple(dwell))
