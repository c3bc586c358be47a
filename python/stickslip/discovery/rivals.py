"""The catalogue as rivals: which numbers each effect adds, how they are scaled, and the shapes to start from."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.effect import AnyEffect, Effect, effect
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.model import Model
from stickslip.fitted.data import Data
from stickslip.fitted.unknowns import Hypothesis, Unknown, law_unknowns

LOGARITHMIC = 1.5  # width on positive ones, in the logarithm
PERIODIC = tuple(  # those in time before those along the belt
    name
    for along_belt in (False, True)
    for name, kind in CATALOGUE.items()
    if kind.wave and kind.wave.along_belt == along_belt
)


@dataclass(frozen=True)
class Start:
    """An effect with starting values, and starting phases by run."""

    term: Effect
    phases: tuple[float, ...] = ()


def sought(name: str) -> tuple[float, float]:
    """Return the bounds between which a positive number, named as effect.parameter, is sought."""
    owner, _, key = name.partition(".")
    bounds = CATALOGUE[owner].parameter(key).sought
    assert bounds is not None, name  # every positive number of the catalogue has some
    return bounds


def unknowns_of(term: Effect) -> tuple[Unknown, ...]:
    """The numbers that an effect adds."""
    out = []
    for info in term.kind.parameters:
        name, value = f"{term.name}.{info.name}", term.parameters[info.name]
        if info.optional and value == 0:
            continue
        if info.per_run:
            out.append(Unknown(name, value, False, value, 30.0, per_run=True))
        elif info.spread is not None:
            out.append(Unknown(name, value, False, 0.0, info.spread, bounds=info.bounds))
        else:
            low, high = sought(name)
            positive = min(max(value, low), high)
            out.append(Unknown(name, positive, True, math.log(positive), LOGARITHMIC, bounds=(low, high)))
    return tuple(out)


def hypothesis(model: Model, starts: Sequence[Start], declared: Model | None = None) -> Hypothesis:
    """Law and effects together; the model's own effects are replaced.

    The law starts at the model's numbers and is held about those of `declared`, so that no wrong rival carries it off.
    """
    terms: list[AnyEffect] = [one.term for one in starts]
    unknowns = list(law_unknowns(model, declared or model))
    phases = {}
    for one in starts:
        unknowns += unknowns_of(one.term)
        if one.phases:
            phases[f"{one.term.name}.phi"] = one.phases
    return Hypothesis(model.with_effects(terms), tuple(unknowns), phases)


def shapes(name: str, data: Sequence[Data]) -> list[Start]:
    """Starts of an effect that is not periodic: a grid over the parameters that no linear score reaches."""
    kind = CATALOGUE[name]
    if kind.starts:
        return [Start(effect(name, **_sized(kind, one, data))) for one in kind.starts]
    zero = {info.name: 0.0 for info in kind.parameters}
    return [Start(effect(name, **zero))]


def _sized(kind: EffectKind, start: Mapping[str, float], data: Sequence[Data]) -> dict[str, float]:
    """Return numbers to start from, shares of the size of y1 multiplied by it."""
    if not any(info.of_size for info in kind.parameters):
        return dict(start)
    size = float(np.quantile(np.abs(np.concatenate([run.readings[:, 1] for run in data])), 0.99))
    return {key: value * size if kind.parameter(key).of_size else value for key, value in start.items()}
