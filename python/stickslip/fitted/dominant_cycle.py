"""The dominant stick-slip cycle of a displacement: which slips make it up, and which are too small to count.

Contacts creep and tremble before they let go, and a belt whose set-point is a little off makes noise look like slips.
Counted as cycles, such slips halve the period that the eye sees.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stickslip.measured.fit_window import Array
from stickslip.measured.sticks import Segment, Track, runs

SHARE = 0.3  # of the typical slip, below which one is left out


@dataclass(frozen=True)
class Cycles:
    """Cycle-by-cycle numbers of one side; arrays of one entry a cycle (may be empty)."""

    period: Array
    stick: Array
    amplitude: Array
    speed: Array


@dataclass(frozen=True)
class Dominant:
    """A track with its small slips counted as part of the sticks around them.

    Attributes
    ----------
    track : Track
        With the modes and segments of the slips that count; displacement and velocity are as they were.
    slips : int
        Slips there were, from a stick to a stick.
    left_out : int
        How many of them were small.
    """

    track: Track
    slips: int
    left_out: int


def dominant(track: Track, share: float = SHARE) -> Dominant:
    """Leave out the slips smaller than a share of the typical one.

    A slip that the record's end cuts off counts if what is seen of it is large enough.

    The size of a slip is the range of the displacement from release to capture, what the eye sees of it. The typical
    size is the median weighted by size: half of all slipping is done in slips at least as large, so that it does not
    depend on how many tiny ones there are.

    Parameters
    ----------
    track : Track
    share : float
        Of the typical size, below which a slip is left out.

    Returns
    -------
    Dominant
    """
    found = _slips(track)
    whole = [slip for slip in found if slip.stop < len(track.x)]
    if not whole:
        return Dominant(track, 0, 0)
    least = share * typical(np.array([track.size(slip) for slip in whole]))
    small = [slip for slip in found if track.size(slip) < least]
    mode = track.mode.copy()
    for slip in small:
        mode[slip.start : slip.stop] = 0
    left_out = sum(slip in small for slip in whole)
    return Dominant(replace(track, mode=mode, segments=runs(mode)), len(whole), left_out)


def typical(sizes: Array) -> float:
    """Return the median of sizes (n,), each weighted by itself."""
    ordered = np.sort(sizes)[::-1]
    done = np.cumsum(ordered)
    return float(ordered[np.searchsorted(done, 0.5 * done[-1])])


def cycles(track: Track) -> Cycles:
    """Period, stick time, slip amplitude and largest slip speed of every cycle from release to release."""
    period, stick, amplitude, speed = [], [], [], []
    for a, b in pairwise(_slips(track)):
        part = slice(a.start, b.start)
        period.append(track.t[part.stop] - track.t[part.start])
        stick.append(float(np.mean(track.mode[part] == 0)))
        amplitude.append(track.size(a))
        speed.append(float(np.max(np.abs(track.v[part] - track.belt_speed))))
    return Cycles(*(np.array(v, dtype=float) for v in (period, stick, amplitude, speed)))


def _slips(track: Track) -> list[Segment]:
    """The slips that begin after a stick; a stick ends each, but the record's end may cut the last off."""
    sticks = track.sticks
    ends = [*(b.start for b in sticks[1:]), len(track.x)]
    bounds = [(a.stop, end) for a, end in zip(sticks, ends, strict=False)]
    return [Segment(start, stop, int(track.mode[start])) for start, stop in bounds if start < stop]
