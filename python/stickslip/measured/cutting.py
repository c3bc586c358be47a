"""The windows that fitting starts from: cut in the middle of sticks, the state at their start read from the samples.

A track errs by a few samples at each transition. In the middle of a stick nothing is in doubt; transition times are
left to the simulation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.measured.fit_window import Array, FitWindow
from stickslip.measured.sticks import Segment, Track


def local_state(t: Array, x: Array, at: int, width: int, past_only: bool = False) -> tuple[float, float]:
    """Value and slope at sample `at` by a quadratic through the readings around (or up to) it."""
    lo = max(0, at - width)
    hi = at + 1 if past_only and at - lo >= 5 else min(len(t), at + width + 1)
    part = slice(lo, max(hi, lo + 6))
    ok = np.isfinite(x[part])
    c = np.polynomial.polynomial.polyfit(t[part][ok] - t[at], x[part][ok], 2)
    return float(c[0]), float(c[1])


def stick_position(track_: Track, readings: Array, stick: Segment, at: int, past_only: bool = False) -> float:
    """Displacement at sample `at` of a stick, where it rises at exactly v_b."""
    lo, hi = stick.start, at + 1 if past_only else stick.stop
    trim = min(track_.width // 2, (hi - lo) // 4)
    part = slice(lo + trim, hi if past_only else hi - trim)
    return float(np.nanmean(readings[part] - track_.belt_speed * (track_.t[part] - track_.t[at])))


def cut(track_: Track, length: float) -> list[tuple[int, int]]:
    """Window bounds (start, stop), cut in the middle of sticks, each at least `length` long.

    Without sticks the cuts are where the block is fastest against the belt, far from any transition.
    """
    t = track_.t
    candidates = [s.middle for s in track_.clear_sticks]
    if not candidates:
        speed = np.abs(track_.v - track_.belt_speed)
        inner = (speed[1:-1] >= speed[:-2]) & (speed[1:-1] > speed[2:]) & (speed[1:-1] > np.median(speed))
        candidates = (np.flatnonzero(inner) + 1).tolist()
    starts = [0]
    for c in candidates:
        if t[c] - t[starts[-1]] >= length and t[-1] - t[c] >= 0.5 * length:
            starts.append(c)
    return list(zip(starts, [*starts[1:], len(t)], strict=True))


def window(
    track_: Track,
    readings: Array,
    bounds: tuple[int, int],
    *,
    run: int,
    columns: Sequence[int],
    past_only: bool = False,
) -> FitWindow:
    """A `FitWindow` on the samples `bounds` with the state estimated at its start.

    Parameters
    ----------
    track_ : Track
        Of the first channel, x1.
    readings : (n, c) array
        Channels x1 and, for the rig of (2.1), y1.
    bounds : (int, int)
    run : int
    columns : sequence of int
        State column of each channel: (0,) or (0, 2).
    past_only : bool
        Estimate the state from samples up to the start only, as a forecast must.
    """
    start, stop = bounds
    stick = next((s for s in track_.sticks if s.start <= start < s.stop), None)
    t, vb = track_.t, track_.belt_speed
    if stick is None:
        initial, free = list(local_state(t, readings[:, 0], start, track_.width, past_only)), ["x1", "x2"]
    else:
        initial, free = [stick_position(track_, readings[:, 0], stick, start, past_only), vb], ["x1"]
    if len(columns) > 1:
        initial += local_state(t, readings[:, 1], start, 2 * track_.width, past_only)
        free += ["y1", "y2"]
    part = slice(start, stop)
    return FitWindow(
        run=run,
        belt_speed=vb,
        t=t[part] - t[start],
        readings=readings[part],
        columns=tuple(columns),
        initial=np.array(initial),
        free=tuple(free),
    )
