"""What a sweep observes: its results by name, and how the core's rows become them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.arguments import texts
from stickslip.errors import InputError, did_you_mean

Floats = NDArray[np.float64]
Arrays = dict[str, NDArray[np.generic]]
Unit = Literal["1", "state", "time", "energy"]

ROW: Mapping[str, int] = {name: i for i, name in enumerate(_core.SWEEP_ROW)}
FINAL, STICK, COUNTS, RANGE, DISSIPATED, POINTS = (1 << i for i in range(6))
NOT_COMPUTED = -1
REPEATS = 1e-6  # release points this near to each other, relative to the largest, are the same
STATUS_FLAGS = ("not_computed", *_core.Outcome.__members__)


@dataclass(frozen=True)
class Observable:
    """A result: its dimensions beside those of the grid, what the core must observe for it, and its meaning."""

    needs: int
    meaning: str
    unit: Unit = "1"
    dims: tuple[str, ...] = ()
    dtype: str = "float64"

    @property
    def fill(self) -> float | int:
        """What stands where a member was not computed or failed."""
        return np.nan if self.dtype == "float64" else NOT_COMPUTED


OBSERVABLES: Mapping[str, Observable] = {
    "final_state": Observable(FINAL, "state at t_end, or where the member stopped", "state", ("state",)),
    "stick_fraction": Observable(STICK, "share of the time from `after` on spent in stick"),
    "transitions": Observable(COUNTS, "changes of the contact mode; -1: none known", dtype="int32"),
    "releases": Observable(
        COUNTS, "stick to slip, and crossings of v_w = 0 that do not stick; -1: none known", dtype="int32"
    ),
    "slips": Observable(COUNTS, "stick to slip; -1: none known", dtype="int32"),
    "period": Observable(COUNTS, "mean time between releases; NaN with fewer than two", "time"),
    "period_spread": Observable(COUNTS, "standard deviation of the time between releases", "time"),
    "periodicity": Observable(
        COUNTS | POINTS,
        "least k such that release points repeat every k; 0: none; -1: none known",
        dtype="int32",
    ),
    "state_min": Observable(RANGE, "least value of each state", "state", ("state",)),
    "state_max": Observable(RANGE, "greatest value of each state", "state", ("state",)),
    "dissipated": Observable(
        DISSIPATED, "work of friction, integral of T v_w dt over all sliding contacts", "energy"
    ),
    "points": Observable(COUNTS | POINTS, "state at releases, the last first", "state", ("point", "state")),
    "point_time": Observable(COUNTS | POINTS, "times of these releases", "time", ("point",)),
    "status": Observable(0, "how the member ended", dtype="int8"),
}
DEFAULT = ("final_state", "stick_fraction", "transitions")
TAKEN = frozenset({*OBSERVABLES, "state", "point"})


def chosen(observe: str | Iterable[str]) -> tuple[str, ...]:
    """Return the variables asked for: each once, with `point_time` beside `points`, `status` last.

    Raises
    ------
    InputError
        One is unknown; the nearest known one is given.
    """
    names = texts("observe", observe, "names of results")
    for name in names:
        if name not in OBSERVABLES:
            raise InputError(f"unknown '{name}'; {did_you_mean(str(name), OBSERVABLES)}", key="observe")
    wanted = {*names, *(("point_time",) if "points" in names else ()), "status"}
    return tuple(name for name in OBSERVABLES if name in wanted)


def bits(names: Iterable[str]) -> int:
    """Return what the core must observe."""
    needed = 0
    for name in names:
        needed |= OBSERVABLES[name].needs
    return needed


def from_rows(
    names: Iterable[str], rows: Floats, points: Floats, *, states: tuple[str, ...], span: float
) -> Arrays:
    """Turn the core's rows (n, ...) and points (n, points, 5) into arrays by name, members along the first axis.

    `span` is the time from `after` to `t_end`. A member that failed keeps its status and where it stopped alone.
    """
    failed = rows[:, ROW["outcome"]] != 0
    out: Arrays = {}
    for name in names:
        values = _variable(name, rows, points, states, span)
        if name not in ("status", "final_state"):
            values[failed] = OBSERVABLES[name].fill
        out[name] = values.astype(OBSERVABLES[name].dtype)
    return out


def _variable(name: str, rows: Floats, points: Floats, states: tuple[str, ...], span: float) -> Floats:
    d = len(states)
    match name:
        case "final_state":
            return rows[:, :d].copy()
        case "stick_fraction":
            return rows[:, ROW["stick_time"]] / span
        case "period" | "period_spread":
            return _period(rows)[name == "period_spread"]
        case "periodicity":
            return periodicity(points[:, :, 1 : 1 + d])
        case "state_min" | "state_max":
            first = ROW[f"x1_{name.removeprefix('state_')}"]
            values = rows[:, first : first + d].copy()
            values[~np.isfinite(values)] = np.nan
            return values
        case "points":
            return points[:, :, 1 : 1 + d].copy()
        case "point_time":
            return points[:, :, 0].copy()
        case "status":
            return rows[:, ROW["outcome"]].copy()
    return rows[:, ROW[name]].copy()  # transitions, releases, slips, dissipated


def _period(rows: Floats) -> tuple[Floats, Floats]:
    """Mean and standard deviation of the intervals between releases."""
    intervals = rows[:, ROW["releases"]] - 1
    enough = intervals >= 1
    n = np.where(enough, intervals, 1.0)
    mean = (rows[:, ROW["last_release"]] - rows[:, ROW["first_release"]]) / n
    spread = np.sqrt(np.maximum(rows[:, ROW["interval_squares"]] / n - mean**2, 0.0))
    return np.where(enough, mean, np.nan), np.where(enough, spread, np.nan)


def periodicity(points: Floats) -> Floats:
    """Least lag k at which the release points (n, points, d) of each member repeat; 0 where none does.

    A lag counts if it was seen at least twice over: k is at most half the points there are. Compared is each state
    to 1e-6 of the largest in the member's points.
    """
    there = np.isfinite(points[:, :, 0])
    count = there.sum(axis=1)
    scale = np.max(np.where(there[:, :, None], np.abs(points), 0.0), axis=(1, 2), initial=0.0)
    found = np.zeros(len(points))
    for lag in range(points.shape[1] // 2, 0, -1):
        both = there[:, lag:]  # points are filled from the first on
        gap = np.max(np.abs(points[:, lag:] - points[:, :-lag]), axis=2, initial=0.0)
        same = np.all(~both | (gap <= REPEATS * scale[:, None]), axis=1)
        found[same & (count >= 2 * lag)] = lag
    return found
