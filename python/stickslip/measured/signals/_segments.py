"""Where a channel moves with the belt: first by a test on windows, then by the evidence for each instant."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.measured.intervals import intervals
from stickslip.measured.signals._input import Booleans, Floats
from stickslip.measured.signals._pieces import Integers, PieceLayout, SplineSystem
from stickslip.measured.signals._solve import SplineSolution, solve

_LEVEL = 4.0  # standard deviations a window may be off the belt and still count as stick
_SAMPLES_PER_KNOT = 2.5
_REPEATS = 3


@dataclass(frozen=True, eq=False)
class Record:
    """Samples in the belt's frame with their noise, and the window of the stick test."""

    t: Floats
    x: Floats
    sigma: float
    creep: float
    window: int

    @property
    def dt(self) -> float:
        return float(np.median(np.diff(self.t)))


def window_length(n: int, dt: float, sigma: float, speed: float) -> int:
    """Count the samples over which a slope of 2 % of `speed` stands out of the noise."""
    if speed <= 0.0:
        return max(6, n // 20)
    need = (np.sqrt(12.0) * sigma / (0.02 * speed * dt)) ** (2.0 / 3.0)
    return int(np.clip(np.ceil(need), 6, max(6, n // 8)))


def stick_windows(record: Record) -> Booleans:
    """Find the samples covered by a window that a constant, to within noise and creep, explains."""
    m, t, x = record.window, record.t, record.x
    if t.size < m:
        return np.zeros(t.size, dtype=np.bool_)
    middle = 0.5 * (t[m - 1 :] + t[: t.size - m + 1])

    def total(values: Floats) -> Floats:
        sums = np.concatenate([[0.0], np.cumsum(values)])
        return np.asarray(sums[m:] - sums[:-m])

    x = x - x.mean()
    st, sx = total(t), total(x)
    stt = total(t * t) - st * st / m
    slope = (total(t * x) - st * sx / m) / stt
    left = total(x * x) - sx * sx / m - slope * slope * stt
    steady = np.abs(slope) <= _LEVEL * record.sigma / np.sqrt(stt) + record.creep
    allowed = (m - 2) * 1.2 + _LEVEL * np.sqrt(2.0 * (m - 2))
    good = steady & (left <= record.sigma**2 * allowed) & np.isfinite(middle)
    edges = np.zeros(t.size + 1)
    np.add.at(edges, np.flatnonzero(good), 1.0)
    np.add.at(edges, np.flatnonzero(good) + m, -1.0)
    return np.asarray(np.cumsum(edges)[:-1] > 0.5)


def merge(record: Record, sticks: Integers) -> Integers:
    """Join neighbouring sticks whose levels are one within noise and creep."""
    kept: list[NDArray[np.intp]] = []
    m = record.window
    for stick in sticks:
        if kept:
            before, here = kept[-1], stick
            a = record.x[max(before[0], before[1] - m + 1) : before[1] + 1]
            b = record.x[here[0] : min(here[1], here[0] + m - 1) + 1]
            noise = record.sigma * np.sqrt(1.0 / a.size + 1.0 / b.size)
            gap = record.t[here[0]] - record.t[before[1]]
            wandered = record.creep * (gap + 0.5 * (a.size + b.size) * record.dt)
            if here[0] - before[1] <= m and abs(a.mean() - b.mean()) <= _LEVEL * noise + wandered:
                kept[-1] = np.array([before[0], here[1]])
                continue
        kept.append(stick)
    return np.array(kept, dtype=np.intp).reshape(-1, 2)


def knots(t: Floats, slips: Floats) -> Integers:
    """Knot intervals of each slip, by its number of samples."""
    inside = np.searchsorted(t, slips[:, 1], side="right") - np.searchsorted(t, slips[:, 0])
    return np.maximum(2, np.rint(inside / _SAMPLES_PER_KNOT)).astype(np.intp)


def make_layout(t: Floats, capture: Floats, onset: Floats) -> PieceLayout:
    """Layout with knots to suit the samples."""
    draft = PieceLayout(float(t[0]), float(t[-1]), capture, onset, np.zeros(0, dtype=np.intp))
    return replace(draft, intervals=knots(t, draft.slips))


def first_layout(record: Record) -> PieceLayout:
    """Layout from the stick test alone."""
    sticks = merge(record, intervals(stick_windows(record)))
    t = record.t
    last = t.size - 1
    capture = t[sticks[:, 0]]
    onset = t[sticks[:, 1]]
    short = np.flatnonzero(sticks[1:, 0] - sticks[:-1, 1] < 3)  # leave every slip room for three samples
    onset[short] -= 1.5 * record.dt
    capture[short + 1] += 1.5 * record.dt
    if sticks.size and sticks[0, 0] <= 2:
        capture[0] = t[0]
    if sticks.size and sticks[-1, 1] >= last - 2:
        onset[-1] = t[-1]
    return make_layout(t, capture, onset)


def fit(record: Record, layout: PieceLayout, jerk: float) -> SplineSolution:
    """Solve one layout."""
    return solve(SplineSystem(layout, record.creep), record.t, record.x, record.sigma, jerk)


def best_jerk(record: Record, layout: PieceLayout, start: float | None = None) -> float:
    """Density of the third derivative with the greatest evidence."""
    top = np.log(record.sigma**2 / record.dt**5)
    bounds = (top - 40.0, top + 5.0) if start is None else (np.log(start) - 3.0, np.log(start) + 3.0)
    found = scipy.optimize.minimize_scalar(
        lambda q: fit(record, layout, float(np.exp(q))).evidence,
        bounds=bounds,
        method="bounded",
        options={"xatol": 0.1},
    )
    return float(np.exp(found.x))


Move = Literal["onset", "capture", "both"]


def shifted(layout: PieceLayout, move: Move, by: Floats, room: float) -> PieceLayout:
    """Layout with instants moved, none past its neighbours; what the record cuts stays."""
    capture, onset = layout.capture.copy(), layout.onset.copy()
    if move in ("capture", "both"):
        free = capture > layout.first
        floor = np.concatenate([[layout.first], onset[:-1]]) + room
        capture[free] = np.maximum(capture + by, floor)[free]
    if move in ("onset", "both"):
        free = onset < layout.last
        roof = np.concatenate([layout.capture[1:], [layout.last]]) - room
        onset[free] = np.minimum(onset + by, roof)[free]
    if move == "onset":
        onset = np.maximum(onset, capture)
    elif move == "capture":
        capture = np.minimum(capture, onset)
    else:
        onset = np.maximum(onset, capture)
    return replace(layout, capture=capture, onset=onset)


def cost_of_moves(layout: PieceLayout, solution: SplineSolution, move: Move) -> Floats:
    """Part of the evidence that the instants of each stick bear on."""
    cost = np.concatenate([[0.0], solution.by_slip, [0.0]])
    after = np.arange(layout.capture.size) + layout.open_start + 1  # slip that begins at each onset
    if move == "onset":
        return np.asarray(cost[np.minimum(after, cost.size - 1)])
    if move == "capture":
        return np.asarray(cost[after - 1])
    return np.asarray(cost[after - 1] + cost[np.minimum(after, cost.size - 1)])


def refine(record: Record, layout: PieceLayout, jerk: float, *, coarse: float, fine: float) -> PieceLayout:
    """Move every instant by ever smaller steps to where the evidence is greatest."""
    if layout.capture.size == 0:
        return layout
    step = coarse * record.dt
    best = fit(record, layout, jerk)
    while step > fine * record.dt:
        for _ in range(_REPEATS):
            before = best.evidence
            for move in ("onset", "capture", "both"):
                for by in (-step, step):
                    layout, best = _try(record, layout, best, move, by, jerk)
            if best.evidence > before - 0.1:
                break
        step *= 0.5
    return layout


def _try(
    record: Record, layout: PieceLayout, best: SplineSolution, move: Move, by: float, jerk: float
) -> tuple[PieceLayout, SplineSolution]:
    """Move all instants of one kind at once and keep the moves that pay."""
    room = 1.5 * record.dt
    trial = shifted(layout, move, np.full(layout.capture.size, by), room)
    tried = fit(record, trial, jerk)
    better = cost_of_moves(trial, tried, move) < cost_of_moves(layout, best, move) - 0.01
    if not better.any():
        return layout, best
    if not better.all():
        trial = shifted(layout, move, np.where(better, by, 0.0), room)
        tried = fit(record, trial, jerk)
    return (trial, tried) if tried.evidence < best.evidence else (layout, best)


def prune(record: Record, layout: PieceLayout, jerk: float) -> PieceLayout:
    """Drop brief sticks and brief slips that the evidence does not call for."""
    best = fit(record, layout, jerk)
    brief = 2.0 * record.window * record.dt
    margin = 2.0 * np.log(record.t.size)  # what two instants more must earn
    j = 0
    while j < layout.capture.size:
        trials = []
        inside = layout.capture[j] > layout.first and layout.onset[j] < layout.last
        if inside and layout.onset[j] - layout.capture[j] < brief:
            trials.append((np.delete(layout.capture, j), np.delete(layout.onset, j)))
        if j + 1 < layout.capture.size and layout.capture[j + 1] - layout.onset[j] < brief:
            trials.append((np.delete(layout.capture, j + 1), np.delete(layout.onset, j)))
        for capture, onset in trials:
            trial = make_layout(record.t, capture, onset)
            tried = fit(record, trial, jerk)
            if tried.evidence < best.evidence + margin:
                layout, best = trial, tried
                break
        else:
            j += 1
    return layout


def instant_std(record: Record, layout: PieceLayout, jerk: float, move: Move) -> Floats:
    """Estimate the standard deviation of each capture or onset, from the curvature of the evidence."""
    if layout.capture.size == 0:
        return np.zeros(0)
    room = 0.1 * record.dt
    by = np.full(layout.capture.size, record.dt)
    here = cost_of_moves(layout, fit(record, layout, jerk), move)
    curvature = -2.0 * here
    for sign in (-1.0, 1.0):
        trial = shifted(layout, move, sign * by, room)
        curvature += cost_of_moves(trial, fit(record, trial, jerk), move)
    std = np.sqrt(2.0 / np.maximum(curvature, 1e-9)) * record.dt
    return np.asarray(np.minimum(std, record.window * record.dt))
