"""The bench of a rig of bodies or matrices: what the search asks of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.catalogue import KINDS
from stickslip.declared.effect import FormulaEffect
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.model import Model
from stickslip.declared.rigs.general import ContactRow, GeneralRig
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.curve_kinds import curve_kinds
from stickslip.discovery.general_rig.kinds import Sizes, has_room, placed_kinds, rival_at, slip
from stickslip.discovery.laboratory.gate import chain
from stickslip.discovery.laboratory.hypothesis import Bench, Term, of_term
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.workers import ALONE, Workers
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods import bodies_bench
from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.contact_scatter import ContactScatter
from stickslip.likelihoods.fit_state import Fit, misfits
from stickslip.likelihoods.memory import KINETIC, memory, slowness
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.measured.recording import Recording

Floats = NDArray[np.float64]
BACK = 0.1  # share of the fastest slip up to which a motion the other way is noise


@dataclass(frozen=True)
class GeneralBench(Bench):
    """
    See `Bench`.

    Parameters
    ----------
    candidates : effects of the user's own, as declared
    """

    candidates: tuple[FormulaEffect, ...] = ()

    @property
    def _plain(self) -> bodies_bench.BodiesBench:
        return bodies_bench.BodiesBench(self.model, self.data, self.stretches, self.declared, self.policy)

    @property
    def contacts(self) -> tuple[ContactRow, ...]:
        """The rig's contacts."""
        assert isinstance(self.model.rig, GeneralRig)
        return self.model.rig.equations.contacts

    @cached_property
    def one_way(self) -> bool:
        """See `Bench.one_way`; of a contact whose motion is not read, what is known of its body."""
        for one in self.contacts:
            v = np.concatenate([slip(run, one) for run in self.data])
            fast = np.quantile(v, [0.002, 0.998])
            if min(-fast[0], fast[1]) > BACK * max(-fast[0], fast[1]):
                return False
        return True

    def windows(self, terms: Sequence[Term] = ()) -> BodiesWindows:
        """See `Bench.windows`."""
        effects = tuple(one.effect for one in terms)
        model = Model(self.model.rig, friction=self.model.friction, effects=effects)
        return self._plain.windows(model, [n for one in terms for n in of_term(one, self.policy)])

    def kinds(self) -> Sequence[EffectKind]:
        """See `Bench.kinds`."""
        return self._kinds

    @cached_property
    def _kinds(self) -> Sequence[EffectKind]:
        assert isinstance(self.model.rig, GeneralRig)
        own = [rival_at(one, self.model.rig) for one in self.candidates]
        names = placed_kinds(self.model, self.data, one_way=self.one_way)
        return [*names, *curve_kinds(self.model, self.data), *own]

    def has_room(self, kind: EffectKind, terms: Sequence[Term]) -> bool:
        """See `Bench.has_room`."""
        return has_room(self.model, kind, [one.effect for one in terms])

    def wobble(self, scatter: ContactScatter) -> float:
        """See `Bench.wobble`; of a belt whose speed is no number, so that windows have none of their own, the usual."""
        known = dict(zip(scatter.names, scatter.sizes, strict=True))
        return min(known.get("belt", self.policy.belt_sd), self.policy.wobble)

    def scattered(self, fit: Fit, one: Term) -> float:
        """
        See `Bench.scattered`.

        Of n events that scatter, a wave of any one frequency has sqrt(2/n) of their standard deviation, a slow one more
        where events remember; of a belt's wobble it may have all.
        """
        kind = one.kind
        assert kind.wave is not None
        if KINDS[kind.name].where == "belt":
            return self.policy.wobble
        friction = [size for name, size in self._sizes(fit) if name.endswith(".kinetic")]
        often = 0.0 if kind.wave.along_belt else one.effect.parameters[kind.wave.parameter]
        events = max(len(self.stretches) / len(self.data), 1.0)
        found, _ = memory(fit, KINETIC)
        slow = max(slowness(found, often * self.cycle), 1.0)
        usual = max(friction, default=0.0) * math.sqrt(2.0 / events * slow)
        unit = 1.0 if KINDS[kind.name].where == "contact" else Sizes(self.model, self.data).friction()
        return max(usual * unit, 1e-300)

    @staticmethod
    def _sizes(fit: Fit) -> list[tuple[str, float]]:
        return list(zip(fit.population.names, fit.population.sizes, strict=True))

    @cached_property
    def cycle(self) -> float:
        """Time from one window to the next, as usual."""
        return float(
            np.median([self.data[s.run].t[s.stop - 1] - self.data[s.run].t[s.start] for s in self.stretches])
        )

    def place(self, kind: EffectKind, run: int, start: int, stop: int) -> float:
        """See `Bench.place`."""
        assert kind.wave is not None
        if not kind.wave.along_belt:
            return float(self.data[run].t[start:stop].mean())
        return float(self._travel(kind, run)[start:stop].mean())

    def length(self, kind: EffectKind, run: int, start: int, stop: int) -> float:
        """See `Bench.length`."""
        assert kind.wave is not None
        if not kind.wave.along_belt:
            return float(self.data[run].t[stop - 1] - self.data[run].t[start])
        return float(np.ptp(self._travel(kind, run)[start:stop]))

    def _travel(self, kind: EffectKind, run: int) -> Floats:
        """How far along what it rubs on a contact is, (n,)."""
        key = kind.where, run
        if key not in self._travels:
            one = next(c for c in self.contacts if c.name == kind.where)
            data: BodiesData = self.data[run]
            come = np.zeros(len(data.t))
            if one.against == "belt":
                come = data.belt.way(data.t)
            self._travels[key] = come - data.q @ one.direction
        return self._travels[key]

    @cached_property
    def _travels(self) -> dict[tuple[str, int], Floats]:
        return {}

    def size_of(self, kind: EffectKind) -> float:
        """See `Bench.size_of`: how far the link, or the coordinate, moves."""
        sizes = Sizes(self.model, self.data)
        links = [one.name for one in sizes.own.links]
        if kind.where in links:
            return sizes.deflection(links.index(kind.where))
        i = sizes.own.names.index(kind.where)
        return max(float(np.quantile(np.abs(run.q[:, i]), 0.995)) for run in self.data)

    def drawn(
        self, fit: Fit, like: Sequence[Floats], rng: np.random.Generator, *, belt: NDArray[np.bool_]
    ) -> Floats:
        """See `Bench.drawn`."""
        draws, names = self.policy.draws, fit.population.names
        out = np.zeros((len(self.stretches), fit.windows.effects, draws))
        for members in fit.windows.by_run:
            for k, own in enumerate(fit.population.of):
                name, size = names[own], fit.population.sizes[own]
                if name == "belt":
                    wandering = members[belt[members]]
                    out[wandering, k] = size * rng.standard_normal((len(wandering), draws))
                    continue
                found = like[1] if name.endswith(".static") else like[0]
                out[members, k] = size * chain(len(members), found, rng)
        return out

    def curves(
        self,
        fit: Fit,  # noqa: ARG002  # none as yet
        terms: Sequence[Term] = (),  # noqa: ARG002
        workers: Workers = ALONE,  # noqa: ARG002
    ) -> Sequence[ScoredCurve]:
        """See `Bench.curves`."""
        return ()


def of_single_events(bench: GeneralBench, fit: Fit) -> GeneralBench:
    """
    Return the bench less windows in which more happens than one event: they leave far more than the others do.

    A stick too short to be seen in the readings parts two slips, each with friction of its own, that a window takes for
    one. Where such windows are many they are not the exception, and all stay.

    Parameters
    ----------
    bench, fit : the windows, and the declared model fitted to them
    """
    chi = misfits(fit) / (fit.windows.sizes * fit.windows.channels)
    return bench.less(chi > bench.policy.noise_left * np.median(chi))


def bench_of(
    model: Model,
    runs: Sequence[Recording],
    known: Uncertainty,
    policy: Policy = POLICY,
    candidates: tuple[FormulaEffect, ...] = (),
) -> GeneralBench:
    """
    Return runs cut into windows.

    Parameters
    ----------
    model, runs, known, policy, candidates : as the bench has them

    Raises
    ------
    InputError
        A run is too short, or none can be cut into windows.
    """
    plain = bodies_bench.bench_of(model, runs, known, policy)
    return GeneralBench(plain.model, plain.data, plain.stretches, plain.declared, policy, candidates)
