"""What effects by a formula make of a reading, with derivatives, for the rigs on a belt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import FormulaEffect
from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.tree import Tree, names
from stickslip.declared.formula.value import value
from stickslip.declared.model import Model
from stickslip.simulated.states import AT, RATE

Floats = NDArray[np.float64]
READING = "reading"
TURNS, LEAST = 20, 0.1  # of Newton's method; slope of a reading that is divided by


@dataclass(frozen=True)
class FormulaReading:
    """A formula of the reading of x1 or y1.

    Attributes
    ----------
    effect
        Whose reading it is.
    channel
        "x1" or "y1".
    """

    effect: FormulaEffect
    channel: str

    @cached_property
    def tree(self) -> Tree:
        """The formula."""
        return self.effect.trees()[READING]

    @cached_property
    def slopes(self) -> dict[str, Tree]:
        """Its derivatives by all that it reads."""
        return {name: derivative(self.tree, name) for name in sorted(names(self.tree))}

    @property
    def states(self) -> tuple[int, ...]:
        """The states that it reads beside the reading."""
        return tuple(AT[name] for name in self.slopes if name in AT)

    def at(
        self, reading: Floats, t: Floats, state: Floats, p: Mapping[str, float]
    ) -> dict[str, Floats | float]:
        """Return what the formula reads, at times and states (n, 9); numbers by their full names in `p`."""
        own: dict[str, Floats | float] = {
            name: p.get(f"{self.effect.label}.{name}", size) for name, size in self.effect.parameters.items()
        }
        seen = {name: state[:, AT[name]] for name in self.slopes if name in AT}
        return {**own, **seen, "t": t, READING: reading}

    def read(self, of: Mapping[str, Floats | float], shape: tuple[int, ...]) -> Floats:
        """Return the reading (n,)."""
        return np.array(np.broadcast_to(value(self.tree, of), shape), dtype=np.float64)

    def slope(self, name: str, of: Mapping[str, Floats | float], shape: tuple[int, ...]) -> Floats:
        """Return its derivative by something that it reads, (n,)."""
        if name not in self.slopes:
            return np.zeros(shape)
        return np.array(np.broadcast_to(value(self.slopes[name], of), shape), dtype=np.float64)

    def rate(self, rate: Floats, of: Mapping[str, Floats | float], state: Floats) -> Floats:
        """Return the rate of the reading from that of what it reads, where no state's rate is an acceleration."""
        shape = rate.shape
        out = self.slope(READING, of, shape) * rate + self.slope("t", of, shape)
        for name in self.slopes:
            if name in AT and AT[name] in RATE:
                out = out + self.slope(name, of, shape) * state[:, RATE[AT[name]]]
        return out

    def behind(self, reading: float, t: float, state: Floats) -> float:
        """Return what is read as `reading` at one time, in a state (9,), by Newton's method from the reading itself."""
        rows, at, x = state[None].copy(), np.array([t]), reading
        own = AT[self.channel]
        for _ in range(TURNS):
            rows[0, own] = x
            of = self.at(np.array([x]), at, rows, {})
            slope = float(self.slope(READING, of, (1,))[0] + self.slope(self.channel, of, (1,))[0])
            step = (reading - float(self.read(of, (1,))[0])) / (slope if abs(slope) > LEAST else 1.0)
            x += step
            if abs(step) <= 1e-12 * abs(x):
                break
        return x if np.isfinite(x) else reading


def formulas_of(model: Model) -> tuple[FormulaReading, ...]:
    """Return the formulas of a model's readings, in their order."""
    return tuple(
        FormulaReading(one, one.where.removesuffix(" channel") or "x1")
        for one in model.effects
        if isinstance(one, FormulaEffect) and one.acts == READING
    )
