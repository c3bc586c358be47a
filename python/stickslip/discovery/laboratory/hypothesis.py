"""A hypothesis on a rig in a laboratory: its law and constants with what is known of them, and a set of effects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.declared.effect import Effect
from stickslip.declared.model import Model
from stickslip.fitted.data import Data
from stickslip.fitted.unknowns import HELD
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import Population
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.shared import Declared, Number
from stickslip.likelihoods.stretches import Stretch
from stickslip.measured.case import Case

STRIDE_LAW, STRIDE_CONSTANT, STRIDE_SHAPE, STRIDE_WAVE, STRIDE_PHASE = 0.5, 0.3, 0.3, 0.02, 0.6
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
        numbers = [*self.of_law(), *self.of_rig(), *(n for one in terms for n in of_term(one, self.policy))]
        return BeltWindows(
            model, self.data, self.stretches, numbers, self.declared, self.sensors, self.policy
        )

    def of_law(self) -> list[Number]:
        """Return the numbers of the law, held loosely about what is declared."""
        out = []
        law = self.model.friction
        for name in self.model.parameters:
            if not hasattr(law, name) or name in HELD:
                continue
            value = self.model.parameters[name]
            if value > 0:
                at = math.log(value)
                out.append(Number(name, at, at, self.policy.law_spread, True, stride=STRIDE_LAW))
            else:
                out.append(Number(name, value, value, self.policy.law_spread, low=0.0))
        return out

    def of_rig(self) -> list[Number]:
        """Return the constants and gains that are not exact."""
        out = []
        for name in self.declared.names:
            if name in self.sensors.gains:
                out.append(Number(name, 0.0, 0.0, math.inf))
            else:
                at = math.log(self.model.parameters[name])
                out.append(Number(name, at, at, math.inf, True, stride=STRIDE_CONSTANT))
        return out


def wobble(bench: Bench, scatter: Population) -> float:
    """
    Return the relative standard deviation of a belt's slow waves.

    A window's own speed shows their mean over it; what their mean keeps follows from how long windows last.
    """
    slow = np.linspace(*bench.policy.slow, 40)
    length = np.array(
        [bench.data[s.run].t[s.stop - 1] - bench.data[s.run].t[s.start] for s in bench.stretches]
    )
    kept = float(np.sqrt(np.mean(np.sinc(slow[:, None] * length / (2 * np.pi)) ** 2)))
    return min(scatter.belt / kept, bench.policy.wobble)


def known(case: Case) -> Declared:
    """Return what a case says of its constants and gains, less what is exact."""
    gains = {f"gain.{channel}": channel for channel in case.uncertainty.gains}
    names = [n for n in case.model().parameters if n in case.uncertainty.names and n not in gains.values()]
    every = {**{n: n for n in names}, **gains}
    covariance = case.uncertainty.on_time(list(every.values()))
    kept = [
        i
        for i, n in enumerate(every)
        if covariance[i, i] > 0 and (n in gains or case.model().parameters[n] > 0)
    ]
    return Declared(tuple(n for i, n in enumerate(every) if i in kept), covariance[np.ix_(kept, kept)])


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


def terms_at(terms: Sequence[Term], windows: BeltWindows, at: np.ndarray) -> tuple[Term, ...]:
    """Return the terms with the numbers of a fit."""
    out = []
    for one in terms:
        found = windows.values(at, 0)
        numbers = {k: found[f"{one.effect.name}.{k}"] for k in one.effect.parameters}
        phases = tuple(windows.values(at, r)[f"{one.effect.name}.phi"] for r in range(len(one.phases)))
        out.append(Term(one.effect.replace(**numbers), phases))
    return tuple(out)
