"""Effects that are told as a curve: what no name explains, and names that only together do what one curve does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import names as names_of
from stickslip.declared.formula.value import value as formula_value
from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.discovery.general_rig.curve_kinds import CurveKind
from stickslip.discovery.laboratory.hypothesis import Bench, Term
from stickslip.discovery.laboratory.outcome import evidence, numbers_of
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.result import Alternative, Curve, FoundEffect
from stickslip.likelihoods.fit_state import Fit

Floats = NDArray[np.float64]
NEARBY = 1e-4  # share of a number that it is moved by for a slope, and the least that it is taken to be
PARTS = "does a part of what acts there; which names make it up, the runs do not tell"


def told_as_curves(bench: Bench, found: Searched, named: Sequence[FoundEffect]) -> tuple[FoundEffect, ...]:
    """
    Return the effects of the verdict with what is told as a curve.

    Several names that are functions of one variable at one place add up to one function of it. Where a curve explains
    all of what they do but what names that stand in leave, the runs do not tell that they are what acts.
    """
    fit, terms = found.chosen.fit, found.chosen.terms
    out = list(named)
    for one in terms:
        if isinstance(one.kind, CurveKind):
            i = next(i for i, each in enumerate(out) if each.name == one.name)
            out[i] = _curve(out[i], one.kind, terms, fit)
    if (made_of := _made_of_names(bench, found)) is not None:
        kind, group, base = made_of
        own = [
            i
            for i, each in enumerate(out)
            if each.where == kind.where and each.name in {t.kind.name for t in group}
        ]
        proof = evidence(found, group[0].name, base, (kind.name,))
        made = replace(
            _curve(replace(out[own[0]], evidence=proof), kind, terms, fit), alternatives=_parts(group, found)
        )
        out = [made, *(each for i, each in enumerate(out) if i not in own)]
    return tuple(out)


def _made_of_names(bench: Bench, found: Searched) -> tuple[CurveKind, list[Term], Trial] | None:
    """A fitted curve that does what several names of the verdict do; they; what is without."""
    chosen = found.chosen
    if any(isinstance(one.kind, CurveKind) for one in chosen.terms):
        return None
    tried = [t for t in (*found.trials, *found.without.values()) if t.freed is chosen.freed]
    for trial in tried:
        kind = trial.terms[-1].kind if trial.terms else None
        if not isinstance(kind, CurveKind):
            continue
        group = [one for one in chosen.terms if _force(one, kind) is not None]
        rest = sorted({*chosen.names} - {one.name for one in group})
        base = min((t for t in tried if sorted(t.names) == rest), key=lambda t: t.deviance, default=None)
        if len(group) < 2 or sorted(trial.names) != sorted([*rest, kind.name]) or base is None:
            continue
        if base.whole() - trial.whole() >= (1 - bench.policy.stands_in) * (base.whole() - chosen.whole()):
            return kind, group, base
    return None


def _parts(group: Sequence[Term], found: Searched) -> tuple[Alternative, ...]:
    """The names that make up a curve, as they are in the model."""
    return tuple(
        Alternative(one.kind.name, 1.0, 0.0, True, False, PARTS, numbers_of(found.chosen, one))
        for one in group
    )


def standing(every: Sequence[FoundEffect]) -> tuple[FoundEffect, ...]:
    """Return the effects less names at the place of a curve: they do a part of what acts there, told with it."""
    out = []
    curved = {one.where for one in every if one.curve is not None}
    for one in every:
        if one.curve is None and one.where in curved:
            continue
        beside = [each.name for each in every if each.curve is None and each.where == one.where]
        if one.curve is not None and beside:
            verb = "does" if len(beside) == 1 else "do"
            words = f"{one.formula}; in the model {' and '.join(beside)} {verb} a part of it"
            one = replace(one, formula=words)
        out.append(one)
    return tuple(out)


def _curve(one: FoundEffect, kind: CurveKind, terms: Sequence[Term], fit: Fit) -> FoundEffect:
    """What no name explains: a place, a variable and a curve, with what names say there of the same variable."""
    assert fit.solution is not None
    alone = any(each.kind is kind for each in terms)
    beside = [(each.name, text) for each in terms if (text := _force(each, kind)) is not None]
    own = {kind.name, *(name for name, _ in beside)}
    at = [i for i, n in enumerate(fit.windows.numbers) if n.name.rpartition(".")[0] in own]
    x, shapes = kind.shapes()

    def whole(coordinates: Floats) -> Floats:
        sizes = {fit.windows.numbers[i].name: fit.windows.numbers[i].value(float(coordinates[i])) for i in at}
        made = np.zeros(len(x))
        if alone:
            made = shapes @ np.array([sizes[f"{kind.name}.{info.name}"] for info in kind.parameters])
        for name, text in beside:
            short = {k.rpartition(".")[2]: v for k, v in sizes.items() if k.rpartition(".")[0] == name}
            made = made + np.asarray(formula_value(parse(text), {kind.variable: x, **short}))
        return np.asarray(made)

    middle = whole(fit.at)
    steps = [NEARBY * max(abs(float(fit.at[i])), NEARBY) * np.eye(len(fit.at))[i] for i in at]
    slopes = np.array([(whole(fit.at + h) - whole(fit.at - h)) / (2 * h.sum()) for h in steps])
    error = SIGMAS_95 * np.sqrt(
        np.einsum("kn,kl,ln->n", slopes, fit.solution.covariance[np.ix_(at, at)], slopes)
    )
    curve = Curve(kind.where, kind.variable, kind.term, x, middle, middle - error, middle + error, x, None)
    words = f"{kind.term}: a curve in {kind.variable}"
    if not alone:
        words += f", in the model made of {' and '.join(name.partition('@')[0] for name, _ in beside)}"
    sentence = one.evidence.sentence.replace(kind.name, "the curve")
    proof = replace(one.evidence, sentence=sentence)
    return FoundEffect("unlisted", kind.where, (kind.variable,), {}, proof, (), words, curve)


def _force(one: Term, curve: CurveKind) -> str | None:
    """The formula of a force at a curve's place and of its variable alone; None for what is none."""
    text = one.kind.anywhere.force
    if one.kind is curve or text is None or one.kind.where != curve.where or isinstance(one.kind, RivalKind):
        return None
    return text if names_of(parse(text)) - {i.name for i in one.kind.parameters} == {curve.variable} else None
