"""The equations of a branch of limit cycles: of the state on the section, the period and the parameter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stickslip.errors import StickslipError
from stickslip.simulated.orbits.cycle import LimitCycle
from stickslip.simulated.orbits.flow import Arc, Contact, Floats, Flow, Signature, sticks_at
from stickslip.simulated.orbits.limit_cycle import cycle_of

CORRECTIONS = 10
CLOSED = 1e-9  # of the cycle's size


@dataclass(frozen=True)
class CyclePoint:
    """A cycle on the branch, or a trial on the way to one; `x` is in scaled units."""

    x: Floats
    residual: Floats
    jacobian: Floats
    arc: Arc
    flow: Flow
    value: float
    contact: Contact

    @cached_property
    def signature(self) -> Signature:
        """Contact modes before and after each transition, from whichever makes this least: a cycle has no first."""
        modes = self.arc.signature
        return min((modes[k:] + modes[:k] for k in range(len(modes))), default=())


@dataclass(frozen=True)
class Problem:
    """The equations of a branch.

    `scale` (d + 2,) is 1 of the state, the period and the parameter, `unit` (d,) of the residual.
    """

    flow: Flow
    parameter: str
    turns: int
    contact: Contact
    scale: Floats
    unit: Floats
    tol: float

    @cached_property
    def dimension(self) -> int:
        """Number of states."""
        return len(self.flow.states)

    def at(self, x: Floats) -> CyclePoint:
        """Equations and derivatives at X / scale."""
        d, full = self.dimension, x * self.scale
        z, span, value = full[:d], float(full[d]), float(full[d + 1])
        flow = self.flow.moved(self.parameter, value)
        if span <= 0:
            raise StickslipError("the period is no longer positive")
        arc = flow.arc(z, span, parameter=self.parameter, contact=self.contact)
        residual, jacobian = np.empty(d + 1), np.zeros((d + 1, d + 2))
        residual[:d] = arc.end - z
        jacobian[:d, :d] = arc.monodromy - np.eye(d)
        jacobian[:d, d], jacobian[:d, d + 1] = arc.rate, arc.by_parameter
        if sticks_at(self.contact):  # the start is set on the belt, whatever z says
            rows = flow.held(self.contact)
            onto = np.linalg.pinv(rows) @ rows
            residual[:d] += onto @ (arc.start - arc.end)
            jacobian[:d] -= onto @ jacobian[:d]
            jacobian[:d, :d] -= onto
            jacobian[:d, d + 1] += onto @ arc.start_by_parameter
        if flow.free.size:  # it closes wherever it is: there it has the translation of a start, 0
            along = np.eye(d) - flow.quotient
            residual[:d] = flow.quotient @ residual[:d] + along @ z
            jacobian[:d] = flow.quotient @ jacobian[:d]
            jacobian[:d, :d] += along
        fixed = flow.idle(arc.monodromy) & (arc.monodromy == np.eye(d)).all(axis=1)
        for j in np.flatnonzero(
            fixed
        ):  # it stays as it is and closes with any value: it has the one of a start, 0
            residual[j], jacobian[j] = z[j], 0.0
            jacobian[j, j] = 1.0
        self._last_row(flow, value, span, z, residual, jacobian)
        rows = np.append(self.unit, self._last_unit(flow))
        return CyclePoint(
            x, residual / rows, jacobian * self.scale / rows[:, None], arc, flow, value, self.contact
        )

    def _last_row(
        self, flow: Flow, value: float, span: float, z: Floats, residual: Floats, jacobian: Floats
    ) -> None:
        """On the section, or a whole number of periods of what moves the rig."""
        d, forcing = self.dimension, flow.forcing_period
        if forcing is None:
            row, level = flow.section
            residual[d], jacobian[d, :d] = row @ z - level, row
            jacobian[d, d + 1] = -self._level_moves(value)
            return
        h = self._beside(value)
        beside = [self.flow.moved(self.parameter, value + s * h).forcing_period or forcing for s in (1, -1)]
        residual[d], jacobian[d, d] = span - self.turns * forcing, 1.0
        jacobian[d, d + 1] = -self.turns * (beside[0] - beside[1]) / (2 * h)

    def _last_unit(self, flow: Flow) -> float:
        """Of the last row's residual: a speed on the section, or a time."""
        if flow.forcing_period is not None:
            return float(self.scale[self.dimension])
        return float(np.abs(flow.section[0]) @ self.unit)

    def _beside(self, value: float) -> float:
        """Step of the parameter in a central difference."""
        return 1e-6 * max(abs(value), 1e-3 * float(self.scale[-1]))

    def _level_moves(self, value: float) -> float:
        """How the section's level moves with the parameter: with the speed of the drive alone."""
        if self.flow.section[1] == 0:
            return 0.0
        h = self._beside(value)
        ends = [self.flow.moved(self.parameter, value + s * h).section[1] for s in (1, -1)]
        return (ends[0] - ends[1]) / (2 * h)

    def correct(self, x: Floats, across: Floats) -> tuple[CyclePoint, int] | None:
        """Newton's method in the plane through `x` normal to `across`; None if it does not converge."""
        try:
            point = self.at(x)
            for k in range(CORRECTIONS):
                system = np.vstack([point.jacobian, across])
                right = np.append(-point.residual, across @ (x - point.x))
                change = np.linalg.solve(system, right)
                if np.abs(change).max() > 0.5:
                    return None
                point = self.at(point.x + change)
                if np.abs(point.residual).max() <= self.tol and np.abs(change).max() <= 1e-7:
                    return (point, k + 1) if self._closes(point.arc) else None
        except (StickslipError, np.linalg.LinAlgError):
            return None
        return None

    def _closes(self, arc: Arc) -> bool:
        """Does it end where it began? The equations of a start in stick say nothing of the block's speed at the end."""
        each = (self.contact,) if isinstance(self.contact, str) else self.contact
        if any(one == "stick" and mode != 0 for one, mode in zip(each, arc.modes, strict=False)):
            return False
        rows = self.flow.held(self.contact)
        apart = np.abs(rows @ (arc.end - arc.start))
        return bool((apart <= CLOSED * np.abs(rows) @ self.scale[: self.dimension]).all())

    def tangent(self, point: CyclePoint, along: Floats) -> Floats:
        """Unit tangent of the branch, pointing to the side of `along`."""
        t = np.asarray(np.linalg.svd(point.jacobian)[2][-1])
        return t if t @ along >= 0 else -t

    def cycle(self, point: CyclePoint) -> LimitCycle:
        """Return the limit cycle at a corrected point."""
        return cycle_of(point.flow, point.arc, 0, self.turns, point.contact)
