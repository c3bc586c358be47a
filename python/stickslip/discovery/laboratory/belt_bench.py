"""The bench of rigs on a belt: the rig of (2.1), and a block on a belt in scaled numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.model import Model
from stickslip.discovery.laboratory.belt_curves import learned
from stickslip.discovery.laboratory.gate import chain
from stickslip.discovery.laboratory.hypothesis import Bench, Term, of_term
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.declared_numbers import of_law, of_rig
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.memory import KINETIC, memory, slowness
from stickslip.likelihoods.population import Population, factor
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.stretches import knots, timed
from stickslip.simulated.states import X1

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BeltBench(Bench):
    """
    See `Bench`.

    Parameters
    ----------
    sensors : what the rig records
    rivals : effects of the user's own
    """

    sensors: Sensors
    rivals: tuple[RivalKind, ...] = ()

    @property
    def one_way(self) -> bool:
        """See `Bench.one_way`."""
        return len({run.belt_speed > 0 for run in self.data}) == 1

    @property
    def two_degree(self) -> bool:
        """Whether it is the rig of (2.1)."""
        return "alpha1" in self.model.parameters

    def windows(self, terms: Sequence[Term] = ()) -> BeltWindows:
        """See `Bench.windows`."""
        model = Model(
            self.model.rig, friction=self.model.friction, effects=tuple(one.effect for one in terms)
        )
        numbers = [*of_law(self.model, self.policy), *of_rig(self.model, self.declared, self.sensors)]
        numbers += [n for one in terms for n in of_term(one, self.policy)]
        return BeltWindows(
            model, self.data, self.stretches, numbers, self.declared, self.sensors, self.policy
        )

    def timed(self, fit: Fit) -> Self:
        """See `Bench.timed`: how long sticks last."""
        return replace(self, stretches=timed(self.stretches, fit.windows.motions(fit.at, fit.own)))

    def kinds(self) -> list[EffectKind]:
        """See `Bench.kinds`."""
        return [
            kind
            for kind in CATALOGUE.values()
            if kind.on_belt is not None
            and kind.corrects is None
            and (self.two_degree or not kind.two_degree)
            and not (self.one_way and kind.both_ways)
            and not (kind.behaves.idle and kind.behaves.idle(self.model.friction, ()))
        ] + [*self.rivals]

    def wobble(self, scatter: Population) -> float:
        """See `Bench.wobble`."""
        return min(scatter.belt, self.policy.wobble)

    def scattered(self, fit: Fit, one: Term) -> float:
        """
        See `Bench.scattered`.

        Of n events that scatter, a wave of any one frequency has sqrt(2/n) of the part of their friction that goes with
        it in a slip, a slow one more where events remember; of a belt's wobble it may have all.
        """
        if one.kind.where == "belt":
            return self.policy.wobble
        events = max(len(self.stretches) / len(self.data), 1.0)
        # of waves that memory weakens none is held for weaker: few events tell it poorly
        slow = max(self._slowness(fit, one), 1.0)
        usual = math.sqrt(2.0 / events * slow * self._within(fit, one))
        unit = max(self.model.friction.static_limits) if one.kind.where == "block" else 1.0
        return max(usual * unit, 1e-300)

    def _within(self, fit: Fit, one: Term) -> float:
        """
        Variance of what of an event's relative friction goes with a wave during its slip.

        Of a slow wave that is the friction's mean over the slip; what changes faster is less of it.
        """
        wave, k = one.kind.wave, self.policy.knots
        assert wave is not None
        number = one.effect.parameters[wave.parameter]
        often = 2 * math.pi / number if wave.along_belt else number
        roots = factor(fit.population, fit.windows.places)[:, fit.windows.kinetic]
        powers = []
        for s, motion in zip(self.stretches, fit.windows.motions(fit.at, fit.own), strict=True):
            if motion is None or not (slips := motion.mode != 0).any():
                continue
            run, t, x = self.data[s.run], motion.t[slips], motion.state[slips, X1]
            turn = np.exp(1j * often * (run.belt_speed * t - x if wave.along_belt else t))
            at = np.interp(x, knots(run, self.policy), np.arange(k))
            shapes = np.maximum(1.0 - np.abs(at[:, None] - np.arange(k)), 0.0)
            powers.append(float((np.abs(turn @ shapes / len(t) @ roots[s.run]) ** 2).sum()))
        return float(np.mean(powers)) if powers else 0.0

    def _slowness(self, fit: Fit, one: Term) -> float:
        """
        Power that the memory of events gives to a wave, over that of events without.

        Along the belt all may be in few waves, of whatever length: as much as the slowest have.
        """
        wave = one.kind.wave
        assert wave is not None
        often = 0.0 if wave.along_belt else one.effect.parameters[wave.parameter]
        found, _ = memory(fit, KINETIC)
        return float(np.mean([slowness(found, often * run.cycle) for run in self.data]))

    def place(self, kind: EffectKind, run: int, start: int, stop: int) -> float:
        """See `Bench.place`."""
        assert kind.wave is not None
        data, part = self.data[run], slice(start, stop)
        if not kind.wave.along_belt:
            return float(data.t[part].mean())
        return float(np.mean(data.belt_speed * data.t[part] - data.readings[part, 0]))

    def length(self, kind: EffectKind, run: int, start: int, stop: int) -> float:
        """See `Bench.length`."""
        assert kind.wave is not None
        data = self.data[run]
        t = float(data.t[stop - 1] - data.t[start])
        return abs(data.belt_speed) * t if kind.wave.along_belt else t

    def size_of(self, kind: EffectKind) -> float:  # noqa: ARG002  # of y1, whatever the effect
        """See `Bench.size_of`."""
        y = np.concatenate([run.readings[run.weight[:, 1] > 0, 1] for run in self.data])
        return float(np.quantile(np.abs(y), 0.995))

    def drawn(
        self, fit: Fit, like: Sequence[Floats], rng: np.random.Generator, *, belt: NDArray[np.bool_]
    ) -> Floats:
        """See `Bench.drawn`; the belt's where it is not drawn as waves over the whole run."""
        p, draws = fit.population, self.policy.draws
        out = np.zeros((len(self.stretches), fit.windows.effects, draws))
        for run, members in enumerate(fit.windows.by_run):
            level, static = (chain(len(members), one, rng) for one in like)
            field = self._field(fit, run, members, rng)
            for j, i in enumerate(members):
                out[i, 0] = p.static * static[j]
                out[i, fit.windows.kinetic] = p.level * level[j] + p.curve * field[j]
                if belt[i]:
                    line = fit.windows.places[run][1:]
                    out[i, fit.windows.kinetic.stop :] = (
                        p.belt * line @ rng.standard_normal((line.shape[1], draws))
                    )
        return out

    def _field(self, fit: Fit, run: int, members: NDArray[np.int64], rng: np.random.Generator) -> Floats:
        """Friction along the belt at the places of each window's curve, of unit variance, (n, knots, draws)."""
        places = fit.windows.places[run][0]
        # one slip after the other: what is under the block when it sticks is there when it slips again
        along = np.array([j + places for j in range(len(members))])
        points = along.ravel()
        # the fit tells a length poorly; a field that changes slowly looks more like an effect
        length = max(fit.population.length, self.policy.curve_length)
        gap = math.sqrt(3.0) * np.abs(points[:, None] - points[None]) / length
        kernel = (1 + gap) * np.exp(-gap) + 1e-8 * np.eye(len(points))
        root = np.linalg.cholesky(kernel)
        made = root @ rng.standard_normal((len(points), self.policy.draws))
        return np.asarray(made.reshape(len(members), len(places), self.policy.draws))

    def curves(self, fit: Fit, terms: Sequence[Term] = (), workers: Workers = ALONE) -> list[ScoredCurve]:
        """See `Bench.curves`."""
        return learned(self, fit, terms, workers)
