"""A hypothesis: a model's structure, which of its numbers are fitted, and how each is scaled and held."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model

Floats = NDArray[np.float64]
HELD = frozenset({"v_w_min", "v_w_max"})  # the fitted ranges are exact
SLIPPING = {  # numbers of slipping friction, and the static limits that they cannot pass
    "T_min_minus": "T_s_minus",
    "T_min_plus": "T_s_plus",
    "kinetic": "static",
    "kinetic_plus": "static_plus",
}
RIG = ("alpha1", "alpha2", "beta3", "eta1", "eta12")  # numbers of (2.1) that may be declared wrong
TURN = 1.5  # radians
MAX_LOG = 2.0  # a positive number of the law moves by at most e^2 from its declared start


@dataclass(frozen=True)
class Unknown:
    """One number to estimate.

    Attributes
    ----------
    name : as `Model.parameters` has it.
    start : starting value.
    log : fitted as its logarithm, so that it stays positive.
    centre, spread : of the weak Gaussian that holds what the readings do not (in the fitted coordinate).
    per_run : each run has its own.
    bounds : of the value.
    """

    name: str
    start: float
    log: bool
    centre: float
    spread: float
    per_run: bool = False
    bounds: tuple[float, float] = (-math.inf, math.inf)

    def coordinate(self, value: float) -> float:
        """The fitted coordinate of a value."""
        return math.log(value) if self.log else value

    def value(self, coordinate: float) -> float:
        """The value at a fitted coordinate."""
        return math.exp(min(max(coordinate, -30.0), 30.0)) if self.log else coordinate

    def slope(self, value: float) -> float:
        """d value / d coordinate."""
        return value if self.log else 1.0


@dataclass(frozen=True)
class Hypothesis:
    """What is fitted: the model (its numbers are the starts of those not listed) and the unknowns.

    `phases` gives starting values by run for unknowns that each run has for itself.
    """

    model: Model
    unknowns: tuple[Unknown, ...]
    phases: Mapping[str, tuple[float, ...]]

    @property
    def shared(self) -> tuple[Unknown, ...]:
        """Unknowns common to all runs."""
        return tuple(u for u in self.unknowns if not u.per_run)

    @property
    def own(self) -> tuple[Unknown, ...]:
        """Unknowns that each run has for itself."""
        return tuple(u for u in self.unknowns if u.per_run)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects."""
        return tuple(one.name for one in self.model.effects)

    def start(self, runs: int) -> Floats:
        """Starting vector: shared coordinates, then each run's own."""
        shared = [u.coordinate(u.start) for u in self.shared]
        own = [
            u.coordinate(self.phases.get(u.name, (u.start,) * runs)[r]) for r in range(runs) for u in self.own
        ]
        return np.array(shared + own)

    def prior(self, runs: int) -> tuple[Floats, Floats]:
        """Centre and precision of the weak prior, in the vector's order."""
        every = [*self.shared, *(u for _ in range(runs) for u in self.own)]
        return np.array([u.centre for u in every]), np.array([1.0 / u.spread**2 for u in every])

    def limits(self, runs: int) -> tuple[Floats, Floats]:
        """Bounds of the vector's entries."""
        every = [*self.shared, *(u for _ in range(runs) for u in self.own)]
        low = [u.coordinate(u.bounds[0]) if u.bounds[0] > -math.inf else -math.inf for u in every]
        high = [u.coordinate(u.bounds[1]) if u.bounds[1] < math.inf else math.inf for u in every]
        return np.array(low), np.array(high)

    def turns(self, runs: int) -> Floats:
        """The most that an angle may turn in one step, in the vector's order; infinite for the others."""
        every = [*self.shared, *(u for _ in range(runs) for u in self.own)]
        return np.array([TURN if u.per_run else math.inf for u in every])

    def columns(self, run: int) -> NDArray[np.int64]:
        """Entries of the vector that bear on a run: the shared ones, then its own."""
        k, m = len(self.shared), len(self.own)
        return np.array([*range(k), *range(k + run * m, k + (run + 1) * m)], dtype=np.int64)

    def values(self, vector: Floats, run: int) -> dict[str, float]:
        """Parameter values of a run."""
        order = (*self.shared, *self.own)
        picked = vector[self.columns(run)]
        return {u.name: u.value(float(c)) for u, c in zip(order, picked, strict=True)}

    def at(self, vector: Floats, runs: int) -> Hypothesis:
        """The same hypothesis with the vector as its start and the shared values in its model."""
        values = self.values(vector, 0)
        moved = tuple(replace(u, start=values[u.name]) if not u.per_run else u for u in self.unknowns)
        phases = {u.name: tuple(self.values(vector, r)[u.name] for r in range(runs)) for u in self.own}
        known = self.model.parameters  # curves on readings are not the model's
        numbers = {u.name: values[u.name] for u in self.unknowns if u.name in known}
        for low, limit in SLIPPING.items():  # a law that does not fall has its floor at its static limit
            if low in numbers:
                numbers[low] = min(numbers[low], numbers.get(limit, numbers.get("static", numbers[low])))
        return replace(
            self, model=self.model.replace(numbers), unknowns=moved, phases={**self.phases, **phases}
        )


def of_law(name: str) -> bool:
    """Is this a number of the friction law, rather than of an effect or of the rig?"""
    return "." not in name and name not in RIG


def law_unknowns(model: Model, declared: Model) -> tuple[Unknown, ...]:
    """The friction law's numbers, all positive, held loosely about the declared ones where no reading bears on them."""
    names = [n for n in model.parameters if hasattr(model.friction, n) and n not in HELD]
    out = []
    for name in names:
        value = declared.parameters[name]
        log = value > 0
        centre, spread = (math.log(value), 0.7) if log else (value, 1.0)
        bounds = (value * math.exp(-MAX_LOG), value * math.exp(MAX_LOG)) if log else (value, math.inf)
        start = min(max(model.parameters[name], bounds[0]), bounds[1])
        out.append(Unknown(name, start, log, centre, spread, bounds=bounds))
    return tuple(out)


def without(unknowns: Sequence[Unknown], names: Sequence[str]) -> tuple[Unknown, ...]:
    """The unknowns less those of the given effects."""
    return tuple(u for u in unknowns if u.name.partition(".")[0] not in names or "." not in u.name)
