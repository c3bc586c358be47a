"""What a choice says: verdict, models, effects with their evidence, and the ranking."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stickslip.declared.effect import CATALOGUE
from stickslip.declared.model import Model
from stickslip.discovery import drifting, lagging, rig_numbers, unlisted
from stickslip.discovery import evidence as ev
from stickslip.discovery.choice import Choice
from stickslip.discovery.intervals import intervals, of_effect, phases
from stickslip.discovery.result import Evidence, FoundEffect, Interval, Rival, Verdict
from stickslip.discovery.search import Search, Trial
from stickslip.fitted.unknowns import of_law
from stickslip.measured.case import Case


def verdict(choice: Choice, found: Sequence[FoundEffect]) -> Verdict:
    """Return the word of the report."""
    if choice.term is not None or choice.place is not None:
        return Verdict.unlisted_effect
    return Verdict.effect_found if found else Verdict.no_effect


def model(case: Case, trial: Trial) -> Model:
    """Return the model of a trial, a wave's amplitude positive, with the case's channels and noise."""
    own, found = case.model(), trial.model
    terms = []
    for one in found.effects:
        if "phi" in one.parameters and "a" in one.parameters:
            a, phi = one.parameters["a"], one.parameters["phi"]
            turned = phi + (np.pi if a < 0 else 0.0)
            one = one.replace(a=abs(a), phi=float(np.mod(turned, 2 * np.pi)))
        terms.append(one)
    return replace(found, effects=tuple(terms), channels=own.channels, noise=own.noise)


def law(trial: Trial) -> dict[str, Interval]:
    """Return the law's numbers with their intervals."""
    return {k: v for k, v in intervals(trial.fit).items() if of_law(k)}


def effects(search: Search, choice: Choice, after: Trial, threshold: float) -> tuple[FoundEffect, ...]:
    """Return what was found, in order of weight."""
    if choice.place is not None:
        formula = "not described"
        words = (
            "no listed effect and no learned curve explains the residual; the place is the likeliest by score"
        )
        if choice.trial.names:
            names = " + ".join(choice.trial.names)
            words = (
                f"no listed effect explains the residual: {names} come nearest, and leave {after.chi2:.3g}"
            )
            formula = f"not described; in the model {names} stand in for it"
        if choice.drift is not None:
            words, formula = drifting.told(choice.drift, after)
        elif choice.lag is not None:
            words, formula = lagging.told(choice.lag, after)
        proof = Evidence(None, None, None, None, "", threshold, words)
        where, variables = choice.place
        own: Mapping[str, Interval] = {} if choice.lag is None else {"tau": choice.lag}
        return (FoundEffect("unlisted", where, variables, own, proof, (), formula, choice.drift),)
    if not choice.trial.names:
        return ()
    tried = list(search.tried.values())
    if choice.trial.names in rig_numbers.KINDS:
        return (_wrong_number(search, choice, after, threshold),)
    out = []
    for name in choice.trial.names:
        proof = ev.evidence(search, choice.null, choice.trial, name, tried, threshold, choice.held)
        others = ev.alternatives(choice.trial, [*tried, *choice.trials], name)
        if unlisted.is_tabulated(name):
            assert choice.term is not None
            where, variable = choice.term.where, choice.term.variable
            learned = unlisted.curve(choice.term, after)
            again = f" that repeats every {learned.period:.4g}" if learned.period else ""
            formula = f"{learned.term}: a curve in {variable}{again}" + (
                f", {learned.guess}" if learned.guess else ""
            )
            own = {key: one for key, one in of_effect(after.fit, name).items() if key == "w"}
            out.append(
                FoundEffect(
                    "unlisted", where, (variable,), own, proof, others, formula, learned,
                    phases(after.fit, name),
                )
            )  # fmt: skip
            continue
        kind = CATALOGUE[name]
        numbers = of_effect(after.fit, name)
        out.append(
            FoundEffect(
                name, kind.where, kind.depends_on, numbers, proof, others, kind.formula, None,
                phases(after.fit, name),
            )
        )  # fmt: skip
    return tuple(sorted(out, key=lambda one: (one.name != "unlisted", -one.evidence.weight)))


def _wrong_number(search: Search, choice: Choice, after: Trial, threshold: float) -> FoundEffect:
    kind, found = rig_numbers.KINDS[choice.trial.names], rig_numbers.numbers(after)
    name = "rig_" + rig_numbers.wrong(search.model.rig, found)[0]
    rivals = [  # each under one name
        replace(t, names=(rig_numbers.called(t.names),))
        for t in (*search.freed, *search.tried.values())
        if t.names in rig_numbers.KINDS or len(t.names) == 1
    ]
    called = rig_numbers.called(choice.trial.names)
    chosen = replace(choice.trial, names=(called,))
    proof = ev.evidence(search, choice.null, chosen, called, rivals, threshold, choice.held)
    others = ev.alternatives(chosen, rivals, called)
    words = rig_numbers.formula(search.model.rig, found)
    return FoundEffect(name, kind.where, kind.depends_on, found, proof, others, words, of_rig=True)


def as_declared(case: Case, found: FoundEffect) -> str | None:
    """What is said of a number that is off by no more than its uncertainty allows: it is no finding."""
    if not found.of_rig or rig_numbers.beyond(case.uncertainty, found.parameters):
        return None
    return (
        f"{found.formula}: within three of its standard uncertainties, and so no finding; the model after has "
        "what was found"
    )


def ranking(search: Search, choice: Choice) -> tuple[Rival, ...]:
    """All that was fitted, best first.

    What was given up above what its effects leave when one or all of them are nothing leaves that: it is no worse.
    """
    readings, chosen = choice.null.fit.readings, frozenset(choice.trial.names)
    fitted = sorted([*choice.trials, *search.tried.values(), *search.freed], key=lambda one: one.bic)
    crude = sorted(search.screened, key=lambda one: one.bic_of(readings))
    best: dict[frozenset[str], Trial] = {}
    for t in (*fitted, *crude):
        best.setdefault(frozenset(t.names), t)
    rows = []
    for names, t in best.items():
        within = min(
            (u for less, u in best.items() if less < names), key=lambda u: u.cost_of(readings), default=t
        )
        idle = within.cost_of(readings) < t.cost_of(readings)
        chi2, cost = (within.chi2, within.cost_of(readings)) if idle else (t.chi2, t.cost_of(readings))
        bic = t.bic_of(readings) - t.cost_of(readings) + cost
        values = {} if idle else t.fit.engine.hypothesis.values(t.fit.vector, 0)
        numbers = {k: v for k, v in values.items() if not of_law(k) and not unlisted.is_tabulated(k)}
        rows.append(Rival(t.names, chi2, bic, numbers, None, names == chosen))
    least = min(one.bic for one in rows)
    return tuple(sorted((replace(one, bic=one.bic - least) for one in rows), key=lambda one: one.bic))
