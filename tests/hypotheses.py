"""Hypotheses of effects with where to start from, for the tests of the engine that fits a state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.effect import AnyEffect, Effect
from stickslip.declared.model import Model
from stickslip.fitted.unknowns import Hypothesis, Unknown, law_unknowns

LOGARITHMIC = 1.5  # width on positive ones, in the logarithm


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
