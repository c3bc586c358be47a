"""A hypothesis on a rig in a laboratory: its law and constants with what is known of them, and a set of effects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.declared.effect import Effect
from stickslip.declared.model import Model
from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.declared_numbers import of_law, of_rig
from stickslip.likelihoods.fit_state import Windowed
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import Population
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.shared import Declared, Number
from stickslip.likelihoods.stretches import Stretch

STRIDE_SHAPE, STRIDE_WAVE, STRIDE_PHASE = 0.3, 0.02, 0.6
STRIDE_SIZE = 0.5  # of a size's own start


@dataclass(frozen=True)
class Term:
    """An effect with its numbers, and its phase in each run if it has one."""

    effect: Effect
    phases: tuple[float, ...] = ()


@dataclass(frozen=True)
class Bench:
    """
    What stays the same over all hypotheses of a case.

    Parameters
    ----------
    model : the declared model, without effects
    data : the runs
    stretches : their windows
    declared : how well the rig's numbers and the gains are known; what is exact is not among them
    sensors : what the rig records
    policy : what steers
    """

    model: Model
    data: Sequence[Data]
    stretches: Sequence[Stretch]
    declared: Declared
    sensors: Sensors
    policy: Policy

    @property
    def one_way(self) -> bool:
        """Whether every run slips one way, so that a constant force is a change of friction."""
        return len({run.belt_speed > 0 for run in self.data}) == 1

    def windows(self, terms: Sequence[Term] = ()) -> BeltWindows:
        """Return the windows of a hypothesis."""
        model = Model(
            self.model.rig, friction=self.model.friction, effects=tuple(one.effect for one in terms)
        )
        numbers = [*of_law(self.model, self.policy), *of_rig(self.model, self.declared, self.sensors)]
        numbers += [n for one in terms for n in of_term(one, self.policy)]
        return BeltWindows(
            model, self.data, self.stretches, numbers, self.declared, self.sensors, self.policy
        )


def wobble(bench: Bench, scatter: Population) -> float:
    """Return the relative standard deviation of a belt's slow waves that is no finding."""
    return min(scatter.belt, bench.policy.wobble)


def of_term(term: Term, policy: Policy) -> list[Number]:
    """Return the numbers of an effect: sizes flat, what must be positive by its logarithm, phases by run."""
    out = []
    for info in term.effect.kind.parameters:
        name, value = f"{term.effect.name}.{info.name}", term.effect.parameters[info.name]
        if info.optional and value == 0:
            continue
        if info.per_run:
            out += [
                Number(name, phase, phase, math.inf, run=r, stride=STRIDE_PHASE)
                for r, phase in enumerate(term.phases)
            ]
        elif info.sought is None or info.spread is not None:
            stride = max(STRIDE_SIZE * abs(value), 1e-4)
            out.append(
                Number(
                    name,
                    value,
                    0.0,
                    info.spread or math.inf,
                    low=info.least_found,
                    high=info.bounds[1],
                    stride=stride,
                )
            )
        else:
            wave, sought, stride = term.effect.kind.wave, info.sought, STRIDE_SHAPE
            if wave and info.name == wave.parameter:  # beyond what is scored it is a trend, or noise
                sought, stride = (policy.wavelengths if wave.along_belt else policy.frequencies), STRIDE_WAVE
            low, high = (math.log(x) for x in sought)
            at = min(max(math.log(max(value, 1e-12)), low), high)
            middle, width = 0.5 * (low + high), 0.5 * (high - low)
            out.append(Number(name, at, middle, width, True, low=low, high=high, stride=stride))
    return out


def terms_at(terms: Sequence[Term], windows: Windowed, at: np.ndarray) -> tuple[Term, ...]:
    """Return the terms with the numbers of a fit."""
    out = []
    for one in terms:
        found = windows.values(at, 0)
        numbers = {k: found[f"{one.effect.name}.{k}"] for k in one.effect.parameters}
        phases = tuple(windows.values(at, r)[f"{one.effect.name}.phi"] for r in range(len(one.phases)))
        out.append(Term(one.effect.replace(**numbers), phases))
    return tuple(out)
