"""A record cut into sticks and slips: splines that meet the belt at both ends.

In the belt's frame a stick is a constant (or, with creep, a straight line) and a slip a curve that
leaves one stick and reaches the next with their slopes. Each slip is a quintic B-spline on uniform knots;
two of its coefficients at either end are those of the sticks.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.measured.signals._input import Floats

Integers = NDArray[np.intp]

DEGREE = 5
TERMS = DEGREE + 1
_PENALISED = 3  # order of the derivative that is a white noise
_GAUSS, _GAUSS_WEIGHT = np.polynomial.legendre.leggauss(3)  # exact for the square of a quadratic
_LARGEST_EXACT = 40  # knot intervals up to which the prior's determinant is computed, not extrapolated


@lru_cache(maxsize=512)
def _polynomials(intervals: int) -> Floats:
    """Power coefficients of the B-splines on 0..intervals, shape (interval, spline, power)."""
    if intervals > 2 * DEGREE + 1:  # away from the ends all intervals are alike
        short = _polynomials(2 * DEGREE + 1)
        middle = np.repeat(short[DEGREE : DEGREE + 1], intervals - 2 * DEGREE, axis=0)
        return np.concatenate([short[:DEGREE], middle, short[-DEGREE:]])
    knots = np.concatenate([np.zeros(DEGREE), np.arange(intervals + 1.0), np.full(DEGREE, float(intervals))])
    out = np.empty((intervals, TERMS, TERMS))
    for b, unit in enumerate(np.eye(intervals + DEGREE)):
        powers = scipy.interpolate.PPoly.from_spline((knots, unit, DEGREE)).c[
            ::-1, DEGREE : DEGREE + intervals
        ]
        for i in range(max(0, b - DEGREE), min(intervals, b + 1)):
            out[i, b - i] = powers[:, i]
    return out


@lru_cache(maxsize=512)
def _penalty(intervals: int) -> Floats:
    """Integral of the squared third derivative over every unit interval, shape (interval, 6, 6)."""
    points = _powers(0.5 * (_GAUSS + 1.0), _PENALISED) * np.sqrt(0.5 * _GAUSS_WEIGHT)[:, None]
    third = np.einsum("ibd,gd->igb", _polynomials(intervals), points)
    return np.asarray(np.einsum("igb,igc->ibc", third, third))


@lru_cache(maxsize=512)
def _log_prior(intervals: int) -> float:
    """Log determinant of the penalty of one slip between two sticks, unit knots and density."""
    if intervals > _LARGEST_EXACT:
        last, before = _log_prior(_LARGEST_EXACT), _log_prior(_LARGEST_EXACT - 1)
        return last + (intervals - _LARGEST_EXACT) * (last - before)
    full = np.zeros((intervals + DEGREE, intervals + DEGREE))
    for i, block in enumerate(_penalty(intervals)):
        full[i : i + TERMS, i : i + TERMS] += block
    join = np.eye(intervals + DEGREE)[:, 2:-1]  # first stick's level fixed, last two coefficients equal
    join[-1, -1] = 1.0
    return float(np.linalg.slogdet(join.T @ full @ join)[1])


def _powers(s: Floats, derivative: int) -> Floats:
    """Give the derivatives of 1, s, ... s^5, shape (n, 6)."""
    out = np.zeros((s.size, TERMS))
    for d in range(derivative, TERMS):
        factor = float(np.prod(np.arange(d - derivative + 1, d + 1)))
        out[:, d] = factor * s ** (d - derivative)
    return out


@dataclass(frozen=True, eq=False)
class PieceLayout:
    """Where the record sticks and slips.

    Stick j lasts from ``capture[j]`` to ``onset[j]`` (both the same: the slip changes direction without
    sticking). Slips fill the rest; ``intervals`` has the number of knot intervals of each.
    """

    first: float
    last: float
    capture: Floats
    onset: Floats
    intervals: Integers

    @property
    def open_start(self) -> bool:
        return self.capture.size == 0 or bool(self.capture[0] > self.first)

    @property
    def open_end(self) -> bool:
        return self.onset.size == 0 or bool(self.onset[-1] < self.last)

    @property
    def slips(self) -> Floats:
        """Begin and end of every slip, shape (slips, 2)."""
        begin = np.concatenate([[self.first] if self.open_start else [], self.onset])
        end = np.concatenate([self.capture, [self.last] if self.open_end else []])
        begin, end = begin[: begin.size - (not self.open_end)], end[(not self.open_start) :]
        return np.column_stack([begin, end])

    @property
    def node_after(self) -> Integers:
        """Stick that ends each slip (= number of sticks for a slip the record's end cuts)."""
        return np.arange(len(self.intervals)) + (not self.open_start)


class SplineSystem:
    """Unknowns, rows and solution for one layout.

    Parameters
    ----------
    layout : Layout
    creep : float
        Standard deviation of the speed of a stick against the belt; 0: none, sticks are constants.
    """

    def __init__(self, layout: PieceLayout, creep: float) -> None:
        self.layout, self.creep = layout, creep
        self.slips = layout.slips
        self.spacing = (self.slips[:, 1] - self.slips[:, 0]) / layout.intervals
        self.base = np.concatenate([[0], np.cumsum(layout.intervals)]).astype(np.intp)
        tables = [_polynomials(int(m)) for m in layout.intervals]
        self.polynomials = np.concatenate(tables) if tables else np.zeros((0, TERMS, TERMS))
        self.middle = 0.5 * (layout.capture + layout.onset)
        self._number()
        self.slip = np.repeat(np.arange(len(layout.intervals)), layout.intervals)
        self.local = self.coefficient[self.slip] + np.arange(self.slip.size) - self.base[self.slip]

    def _number(self) -> None:
        """Give every coefficient of every slip its unknowns (level, slope) and their weights."""
        width = 2 if self.creep > 0.0 else 1
        nodes, slips = self.layout.capture.size, len(self.layout.intervals)
        self.level = np.zeros(nodes, dtype=np.intp)
        self.coefficient = np.concatenate([[0], np.cumsum(self.layout.intervals + DEGREE)]).astype(np.intp)
        self.unknown = np.zeros((int(self.coefficient[-1]), width), dtype=np.intp)
        self.weight = np.zeros(self.unknown.shape)
        self.weight[:, 0] = 1.0
        owner: list[Integers] = []
        count = 0
        if nodes and not self.layout.open_start:
            self.level[0], count = 0, width
            owner.append(np.zeros(width, dtype=np.intp))
        for k in range(slips):
            right = int(self.layout.node_after[k])
            at = slice(int(self.coefficient[k]), int(self.coefficient[k + 1]))
            free = np.arange(at.start + 2 * (right > 0), at.stop - 2 * (right < nodes))
            self.unknown[free] = (count + np.arange(free.size))[:, None]
            count += free.size
            if right < nodes:
                self.level[right] = count
                count += width
            owner.append(np.full(count - sum(o.size for o in owner), k, dtype=np.intp))
            if right > 0:
                self._join(k, right - 1, at.start, +1)
            if right < nodes:
                self._join(k, right, at.stop - 1, -1)
        self.size = count
        self.owner = np.concatenate([np.zeros(0, dtype=np.intp), *owner])  # slip of each unknown

    def _join(self, slip: int, node: int, end: int, side: int) -> None:
        """Let the last two coefficients of a slip be those of the stick it meets."""
        both = [end, end + side]
        self.unknown[both, 0] = self.level[node]
        if self.creep > 0.0:
            edge = self.slips[slip, 0 if side > 0 else 1] - self.middle[node]
            self.unknown[both, 1] = self.level[node] + 1
            self.weight[both, 1] = edge, edge + side * self.spacing[slip] / DEGREE

    def place(self, t: Floats) -> Integers:
        """Slip each time is in, or -1 - stick."""
        slip = np.searchsorted(self.slips[:, 0], t, side="right") - 1
        inside = (slip >= 0) & (t <= np.append(self.slips[:, 1], -np.inf)[slip])
        stick = np.clip(np.searchsorted(self.layout.capture, t, side="right") - 1, 0, None)
        return np.where(inside, slip, -1 - stick).astype(np.intp)

    def basis(self, t: Floats, slip: Integers, derivative: int = 0) -> tuple[Integers, Floats]:
        """Find the knot interval of times inside `slip` and the six values there: shapes (m,), (m, 6)."""
        u = (t - self.slips[slip, 0]) / self.spacing[slip]
        i = np.clip(u.astype(np.intp), 0, self.layout.intervals[slip] - 1)
        interval = self.base[slip] + i
        value = (self.polynomials[interval] @ _powers(u - i, derivative)[:, :, None])[:, :, 0]
        return interval, value / self.spacing[slip, None] ** derivative

    def rows(self, t: Floats, derivative: int = 0) -> tuple[Integers, Floats]:
        """Rows that give the belt-frame displacement or a derivative at times `t`: indices and weights."""
        width = self.unknown.shape[1]
        index = np.zeros((t.size, TERMS * width), dtype=np.intp)
        weight = np.zeros(index.shape)
        place = self.place(t)
        slip, stick = np.flatnonzero(place >= 0), np.flatnonzero(place < 0)
        interval, value = self.basis(t[slip], place[slip], derivative)
        index[slip], weight[slip] = self.through(self.local[interval], value)
        j = -1 - place[stick]
        if stick.size:
            index[stick] = self.level[j, None]
        weight[stick, 0] = 1.0 if derivative == 0 else 0.0
        if width == 2:
            index[stick, 1] += 1
            slope = t[stick] - self.middle[j] if derivative == 0 else np.full(stick.size, derivative == 1)
            weight[stick, 1] = slope
        return index, weight

    def through(self, first: Integers, value: Floats) -> tuple[Integers, Floats]:
        """From coefficients ``first, first+1, ...`` of the splines to the unknowns behind them."""
        coefficient = first[:, None] + np.arange(TERMS)
        index = self.unknown[coefficient].reshape(first.size, TERMS * self.unknown.shape[1])
        weight = (value[:, :, None] * self.weight[coefficient]).reshape(index.shape)
        return index, weight

    def prior(self) -> Floats:
        """Penalty for unit density on the six coefficients of every interval, shape (intervals, 6, 6)."""
        tables = [_penalty(int(m)) for m in self.layout.intervals]
        blocks = np.concatenate(tables) if tables else np.zeros((0, TERMS, TERMS))
        return np.asarray(blocks * (self.spacing[self.slip] ** (1 - 2 * _PENALISED))[:, None, None])

    def log_prior(self, jerk: float) -> Floats:
        """-log determinant of each slip's penalty."""
        rank = self.layout.intervals + DEGREE - _PENALISED
        constant = np.array([_log_prior(int(m)) for m in self.layout.intervals])
        return np.asarray(rank * np.log(jerk) + (2 * _PENALISED - 1) * rank * np.log(self.spacing) - constant)
