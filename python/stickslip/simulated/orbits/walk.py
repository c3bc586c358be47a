"""The walk along a branch of limit cycles, by pseudo-arclength, and the bifurcations on the way.

A point X = (z, T, p) holds the state on the section, the period and the parameter. Equations are those of
`cycles`; their derivatives by z, T and p are exact. A step goes along the tangent and is corrected by Newton's
method at right angles to it (Keller 1977), in units of the cycle's size, its period and the span asked for.

Folds, flips and Neimark-Sacker points are zeros of smooth functions. Sliding bifurcations change the sequence of
contact modes: a stick phase shrinks to nothing, v_w = 0 is crossed where it was stuck to, or is touched in slip.
They are located where the sequence changes. There the branch may have a corner, and even turn round in it.

Steady sliding solves the equations of an autonomous cycle too, with any period, and is none. Where a branch of cycles
meets it, at a Hopf point, the cycle's size goes through 0. So no step takes more than half of that size away: one that
would either has the Hopf point within it, which ends the branch, or is too long.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy

from stickslip.errors import StickslipError
from stickslip.simulated.orbits.branch import (
    SAME_WAY,
    Kind,
    SpecialPoint,
    Trace,
    comes_round,
    flip_test,
    kind_of,
    neimark_sacker_test,
)
from stickslip.simulated.orbits.branch_equations import CyclePoint, Problem
from stickslip.simulated.orbits.flow import Floats
from stickslip.simulated.orbits.limit_cycle import swing
from stickslip.simulated.orbits.steady_sliding import SteadySliding, equilibrium

SMALLEST = 1e-9  # step at which a branch counts as ended or cornered
REACH = 2.5  # how many steps away the next point may lie
KEPT = 0.5  # of the cycle's size, by a step
SMOOTH: tuple[Kind, ...] = ("fold", "flip", "neimark_sacker")


@dataclass
class Walk:
    """Steps along the branch in one direction."""

    problem: Problem
    span: tuple[float, float]
    step: float
    most: int

    def go(self, start: CyclePoint, along: Floats) -> Trace:
        """Points and special points from `start` in the direction of `along`, to an end of the span."""
        self.problem = replace(self.problem, contact=start.contact)  # another walk may have changed it
        trace = Trace([start], [])
        points, special = trace.points, trace.special
        first = tangent = self.problem.tangent(start, along)
        step = self.step
        while len(points) < self.most:
            last = points[-1]
            ahead = self.problem.correct(last.x + step * tangent, tangent)
            if ahead is None or np.linalg.norm(ahead[0].x - last.x) > REACH * step:
                step *= 0.5
                if step > SMALLEST:
                    continue
                if other := self._strobed(last, tangent):
                    self.problem, point, step = *other, 0.05 * self.step
                    tangent = self.problem.tangent(point, point.x - last.x)
                    points.append(point)
                    continue
                turned = self._turn(last)
                if turned is None:
                    special += (last_one := self._end(last, tangent, len(points)))
                    trace.end = "special" if last_one else "no_convergence"
                    break
                point, tangent, step = turned[0], turned[1], 0.05 * self.step
                special.append(self._corner(last, point, len(points)))
                points.append(point)
                continue
            point, work = ahead
            if self._shrinks(last, point):
                born = self._birth(last, tangent, REACH * step, len(points))
                step *= 0.5
                if not born and step > SMALLEST:
                    continue
                special += born
                trace.end = "hopf" if born else "no_convergence"
                break
            if self._outside(point):
                points += self._at_the_end(last, point)
                trace.end = "span"
                break
            if round_again := comes_round(points, first, point):
                trace.end, met = round_again
                if trace.end == "closed":
                    special += self._between(
                        last, met, tangent, self.problem.tangent(met, point.x - last.x), len(points)
                    )
                    points.append(met)
                break
            following = self.problem.tangent(point, point.x - last.x)
            special += self._between(last, point, tangent, following, len(points))
            if (
                point.signature != last.signature
            ):  # over a corner in which the branch may turn round: away from it
                corner = special[-1].cycle
                at = np.concatenate([corner.state, [corner.period, special[-1].value]]) / self.problem.scale
                following = self.problem.tangent(point, point.x - at)
            if step > 1e-3 * self.step or len(points) < 2:
                points.append(point)
            else:  # closing in on a corner: one point is enough
                points[-1] = point
            tangent = following
            step = min(self.step, step * (1.4 if work <= 3 else 0.7 if work > 5 else 1.0))
        return trace

    def _strobed(self, last: CyclePoint, tangent: Floats) -> tuple[Problem, CyclePoint] | None:
        """Beyond where the instant at which a forced cycle is looked at leaves a stick, or comes into one."""
        for contact in self.problem.flow.strobed(last.contact):
            other = replace(self.problem, contact=contact)
            for step in (1e-6, 1e-5, 1e-4, 1e-3):
                ahead = other.correct(last.x + step * tangent, tangent)
                if ahead is None or not np.linalg.norm(ahead[0].x - last.x) < 3 * step:
                    continue
                if ahead[0].signature == last.signature and not self._outside(ahead[0]):
                    return other, ahead[0]
        return None

    def _outside(self, point: CyclePoint) -> bool:
        return not self.span[0] <= point.value <= self.span[1]

    def _at_the_end(self, last: CyclePoint, point: CyclePoint) -> list[CyclePoint]:
        """Return the point at the end of the span itself."""
        bound = self.span[0] if point.value < self.span[0] else self.span[1]
        e = np.zeros(len(point.x))
        e[-1] = 1.0
        share = (bound - last.value) / (point.value - last.value)
        found = self.problem.correct(last.x + share * (point.x - last.x), e)
        return [] if found is None or share < 1e-9 or self._shrinks(last, found[0]) else [found[0]]

    def _between(
        self, a: CyclePoint, b: CyclePoint, before: Floats, after: Floats, index: int
    ) -> list[SpecialPoint]:
        """Special points between two neighbours."""
        found = list[SpecialPoint]()
        if a.signature != b.signature:
            found.append(self._located(self._switch(a, b), a, b, index))
            return found
        values = {"fold": (before[-1], after[-1])}
        for kind, test in (("flip", flip_test), ("neimark_sacker", neimark_sacker_test)):
            values[kind] = (test(self.problem.cycle(a)), test(self.problem.cycle(b)))
        for kind in SMOOTH:
            if values[kind][0] * values[kind][1] < 0:
                at = self._smooth_zero(a, b, self._test(kind, b.x - a.x))
                if at is not None:
                    found.append(SpecialPoint(kind, at.value, self.problem.cycle(at), index))
        return found

    def _chord(self, a: CyclePoint, b: CyclePoint, share: float) -> CyclePoint | None:
        """Return the point of the branch over a share of the chord from a to b."""
        chord = b.x - a.x
        found = self.problem.correct(a.x + share * chord, chord / np.linalg.norm(chord))
        return None if found is None else found[0]

    def _shrinks(self, last: CyclePoint, point: CyclePoint) -> bool:
        """Does an autonomous cycle lose more than half of its size, or turn over, from one point to the other?"""
        if last.flow.forcing_period is not None:
            return False
        before, after = (-float(one.flow.section[0] @ one.arc.rate) for one in (last, point))
        if after >= KEPT * before:
            return False
        return after <= 0 or swing(point.flow, point.arc) < KEPT * swing(last.flow, last.arc)

    def _birth(self, last: CyclePoint, tangent: Floats, reach: float, index: int) -> list[SpecialPoint]:
        """Return where steady sliding changes stability, if the branch goes there and it is within reach.

        The branch is a parabola there: on the way to the vertex the parameter goes as the tangent says, and the chord
        is within 20 degrees of the tangent, however steep.
        """
        width = self.problem.scale[-1]
        end = float(np.clip(last.value + np.sign(tangent[-1]) * reach * width, *self.span))

        def sliding(value: float) -> SteadySliding:
            return equilibrium(self.problem.flow.moved(self.problem.parameter, value), last.arc.start)

        def leading(value: float) -> float:
            return float(sliding(value).eigenvalues.real.max())

        try:
            at = float(scipy.optimize.brentq(leading, last.value, end, xtol=1e-13 * width))
            here = sliding(at)
        except (StickslipError, ValueError):
            return []
        full = np.concatenate([last.flow.quotient @ here.state, [here.turning_time, at]])
        chord = full / self.problem.scale - last.x
        apart = float(np.linalg.norm(chord))
        if not (apart <= reach and chord @ tangent > SAME_WAY * apart):
            return []
        return [SpecialPoint("hopf", at, self.problem.cycle(last), index, sliding=here)]

    def _test(self, kind: Kind, along: Floats) -> Callable[[CyclePoint], float]:
        if kind == "fold":
            return lambda point: float(self.problem.tangent(point, along)[-1])
        test = flip_test if kind == "flip" else neimark_sacker_test
        return lambda point: test(self.problem.cycle(point))

    def _smooth_zero(
        self, a: CyclePoint, b: CyclePoint, test: Callable[[CyclePoint], float]
    ) -> CyclePoint | None:
        def value(share: float) -> float:
            point = a if share == 0 else b if share == 1 else self._chord(a, b, share)
            if point is None:
                raise StickslipError("no convergence")
            return test(point)

        try:
            share = float(scipy.optimize.brentq(value, 0.0, 1.0, xtol=self.problem.tol, rtol=1e-12))
        except (StickslipError, ValueError):
            return None
        return self._chord(a, b, share)

    def _switch(self, a: CyclePoint, b: CyclePoint) -> tuple[CyclePoint, CyclePoint]:
        """Neighbours as near as the tolerance between which the sequence of modes changes."""
        left, right, low, high = 0.0, 1.0, a, b
        while right - left > self.problem.tol:
            for share in (0.5, 0.37, 0.71):
                middle = left + share * (right - left)
                point = self._chord(a, b, middle)
                if point is not None:
                    break
            else:
                break
            if point.signature == a.signature:
                left, low = middle, point
            else:
                right, high = middle, point
        return low, high

    def _located(
        self, pair: tuple[CyclePoint, CyclePoint], a: CyclePoint, b: CyclePoint, index: int
    ) -> SpecialPoint:
        kind = kind_of(a.signature, b.signature)
        return SpecialPoint(kind, pair[0].value, self.problem.cycle(pair[0]), index)

    def _corner(self, last: CyclePoint, point: CyclePoint, index: int) -> SpecialPoint:
        kind = kind_of(last.signature, point.signature)
        return SpecialPoint(kind, last.value, self.problem.cycle(last), index, turns_round=True)

    def _end(self, last: CyclePoint, tangent: Floats, index: int) -> list[SpecialPoint]:
        """Say why the branch ends, by what the motion does just beyond."""
        for step in (1e-7, 1e-6, 1e-5):
            try:
                signature = self.problem.at(last.x + step * tangent).signature
            except StickslipError:
                continue
            if signature != last.signature:
                kind = kind_of(last.signature, signature)
                return [SpecialPoint(kind, last.value, self.problem.cycle(last), index, ends=True)]
        return []

    def _turn(self, last: CyclePoint) -> tuple[CyclePoint, Floats] | None:
        """Go on from a corner of the branch: tangents of the other side, from states moved a little over to it."""
        for size in (1e-5, 1e-4, 1e-3):
            for i in np.flatnonzero(self.problem.flow.section[0] == 0).tolist():
                for way in (-1.0, 1.0):
                    x = last.x.copy()
                    x[i] += way * size
                    found = self._over(last, x, 20 * size)
                    if found is not None:
                        return found
        return None

    def _over(self, last: CyclePoint, x: Floats, step: float) -> tuple[CyclePoint, Floats] | None:
        try:
            beside = self.problem.at(x)
        except StickslipError:
            return None
        if beside.signature == last.signature:
            return None
        for along in (1.0, -1.0):
            tangent = along * np.asarray(np.linalg.svd(beside.jacobian)[2][-1])
            ahead = self.problem.correct(last.x + step * tangent, tangent)
            if ahead is None or ahead[0].signature == last.signature:
                continue
            if np.linalg.norm(ahead[0].x - last.x) < 3 * step and not self._outside(ahead[0]):
                return ahead[0], self.problem.tangent(ahead[0], ahead[0].x - last.x)
        return None
