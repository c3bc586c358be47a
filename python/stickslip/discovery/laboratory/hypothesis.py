"""A hypothesis on a rig in a laboratory: its law and constants with what is known of them, and a set of effects."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.catalogue import KINDS
from stickslip.declared.effect import Effect, FormulaEffect, Tabulated, called, effect
from stickslip.declared.effect_kind import EffectKind, ParameterInfo
from stickslip.declared.model import Model
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.fit_state import Fit, Windowed
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.shared import Declared, SharedNumber

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
STRIDE_SHAPE, STRIDE_WAVE, STRIDE_PHASE = 0.3, 0.02, 0.6
STRIDE_SIZE = 0.5  # of a size's own start
LEAST = 1e-4  # of what is 1 in (2.1): a size that is next to nothing


@dataclass(frozen=True)
class Term:
    """
    An effect with its numbers, and its phase in each run if it has one.

    Parameters
    ----------
    effect, phases : the effect, or a curve; a phase a run
    of : its facts, where it is none of the catalogue
    """

    effect: Effect | FormulaEffect | Tabulated
    phases: tuple[float, ...] = ()
    of: EffectKind | None = None

    @property
    def kind(self) -> EffectKind:
        """Its facts."""
        if self.of is not None:
            return self.of
        assert isinstance(self.effect, Effect)
        return self.effect.kind

    @property
    def name(self) -> str:
        """What its numbers are called by: its name, and its place where it has one."""
        return self.effect.label if isinstance(self.effect, Effect) else self.effect.name

    @property
    def where(self) -> str:
        """The place, in the words of a report."""
        return place_of(self.kind)


def term(kind: EffectKind, numbers: Mapping[str, float], phases: tuple[float, ...] = ()) -> Term:
    """Return an effect of a kind with its numbers."""
    if isinstance(kind, RivalKind):
        return Term(kind.made(numbers), phases, kind)
    return Term(replace(effect(kind.name, **numbers), where=kind.where, by=kind.by), phases, kind)


def label(kind: EffectKind) -> str:
    """Return what the numbers of an effect are called by."""
    return kind.name if isinstance(kind, RivalKind) else called(kind.name, kind.where, kind.by)


def place_of(kind: EffectKind) -> str:
    """Return where an effect acts, in the words of a report."""
    if isinstance(kind, RivalKind) or kind.name not in KINDS:
        return kind.where
    reads = KINDS[kind.name].where.endswith(" channel") and not kind.where.endswith(" channel")
    return f"{kind.where} channel" if reads else kind.where


@dataclass(frozen=True)
class Bench(ABC):
    """
    What stays the same over all hypotheses of a case, and what a search asks of its rig.

    Parameters
    ----------
    model : the declared model, without effects
    data : the runs
    stretches : their windows
    declared : how well the rig's numbers and the gains are known; what is exact is not among them
    policy : what steers
    """

    model: Model
    data: Sequence[Any]
    stretches: Sequence[Any]
    declared: Declared
    policy: Policy

    @property
    @abstractmethod
    def one_way(self) -> bool:
        """Whether every run slips one way, so that a constant force is a change of friction."""

    @abstractmethod
    def windows(self, terms: Sequence[Term] = ()) -> Windowed:
        """Return the windows of a hypothesis."""

    @abstractmethod
    def kinds(self) -> Sequence[EffectKind]:
        """Return the effects that windows of this rig can tell, each at its place and in the rig's numbers."""

    def timed(self, fit: Fit) -> Self:  # noqa: ARG002  # windows without hidden times stay as they are
        """Return the same with times that no reading shows as a fit has them."""
        return self

    def less(self, out: Mask) -> Self:
        """
        Return the same without some windows; all stay where these are none, or so many that they are no exception.

        Parameters
        ----------
        out : (w,) which of them
        """
        if not out.any() or out.mean() > self.policy.lost_windows:
            return self
        return replace(self, stretches=[s for s, gone in zip(self.stretches, out, strict=True) if not gone])

    def has_room(self, kind: EffectKind, terms: Sequence[Term]) -> bool:  # noqa: ARG002  # of every rig but general ones
        """Whether an effect can be simulated at its place beside others."""
        return True

    def wobbles(self, kind: EffectKind) -> bool:
        """Whether an effect is a wave of what wobbles by itself in every window: the belt."""
        return kind.wave is not None and kind.where == "belt"

    @abstractmethod
    def wobble(self, scatter: Any) -> float:
        """Return the relative standard deviation of a belt's slow waves that is no finding."""

    @abstractmethod
    def scattered(self, fit: Fit, one: Term) -> float:
        """Return the amplitude that a wave may have where scatter alone acts."""

    @abstractmethod
    def place(self, kind: EffectKind, run: int, start: int, stop: int) -> float:
        """Return the middle of a window: a time, or along the belt a way."""

    @abstractmethod
    def length(self, kind: EffectKind, run: int, start: int, stop: int) -> float:
        """Return how long a window is: a time, or along the belt a way."""

    @abstractmethod
    def size_of(self, kind: EffectKind) -> float:
        """Return the size of what an effect reads, for numbers that are shares of it."""

    @abstractmethod
    def drawn(
        self, fit: Fit, like: Sequence[Floats], rng: np.random.Generator, *, belt: NDArray[np.bool_]
    ) -> Floats:
        """
        Return random effects of all windows as scatter alone makes them, (w, effects, draws).

        Parameters
        ----------
        fit : whose scatter it is
        like : (draws,) correlation from one event to the next, of kinetic friction and of static limits
        rng : of the draws
        belt : (w,) windows whose belt is drawn, too
        """

    @abstractmethod
    def curves(self, fit: Fit, terms: Sequence[Term] = (), workers: Workers = ALONE) -> Sequence[ScoredCurve]:
        """Return every curve beside a hypothesis of these terms, best first; the workers score them."""


def of_term(one: Term, policy: Policy) -> list[SharedNumber]:
    """Return the numbers of an effect: sizes flat, what must be positive by its logarithm, phases by run."""
    out = []
    for info in one.kind.parameters:
        name, value = f"{one.name}.{info.name}", one.effect.parameters[info.name]
        if info.optional and value == 0:
            continue
        if info.per_run:
            out += [
                SharedNumber(name, phase, phase, math.inf, run=r, stride=STRIDE_PHASE)
                for r, phase in enumerate(one.phases)
            ]
        elif info.sought is None or info.spread is not None:
            curve = isinstance(one.effect, Tabulated)
            stride = math.inf if curve else max(STRIDE_SIZE * abs(value), LEAST * info.unit)
            out.append(
                SharedNumber(
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
            wave, sought, stride = one.kind.wave, info.sought, STRIDE_SHAPE
            if wave and info.name == wave.parameter:  # beyond what is scored it is a trend, or noise
                sought, stride = often(one.kind, policy), STRIDE_WAVE
            low, high = (math.log(x) for x in sought)
            at = min(max(math.log(max(value, 1e-12 * info.unit)), low), high)
            middle, width = 0.5 * (low + high), 0.5 * (high - low)
            out.append(SharedNumber(name, at, middle, width, True, low=low, high=high, stride=stride))
    return out


def often(kind: EffectKind, policy: Policy) -> tuple[float, float]:
    """Return between what bounds the frequency or the wavelength of a periodic effect is sought."""
    assert kind.wave is not None
    low, high = policy.wavelengths if kind.wave.along_belt else policy.frequencies
    unit = kind.parameter(kind.wave.parameter).unit
    return low * unit, high * unit


def sizes_of(kind: EffectKind) -> tuple[ParameterInfo, ...]:
    """Return the numbers that an effect is nothing without."""
    return tuple(i for i in kind.parameters if i.spread is not None)


def terms_at(terms: Sequence[Term], windows: Windowed, at: np.ndarray) -> tuple[Term, ...]:
    """Return the terms with the numbers of a fit."""
    out = []
    for one in terms:
        found = windows.values(at, 0)
        numbers = {k: found[f"{one.name}.{k}"] for k in one.effect.parameters}
        phases = tuple(windows.values(at, r)[f"{one.name}.phi"] for r in range(len(one.phases)))
        out.append(replace(one, effect=one.effect.replace(**numbers), phases=phases))
    return tuple(out)
