"""What a search in a laboratory says, in the words that every report has."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated
from stickslip.declared.model import Model
from stickslip.declared.uncertainty import GAINS as CHANNELS
from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.declared.uncertainty import numbers as every_number
from stickslip.discovery.laboratory.constants import Freed
from stickslip.discovery.laboratory.curve_words import guess
from stickslip.discovery.laboratory.hypothesis import Bench, Term
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.left import Left
from stickslip.discovery.laboratory.rival_kind import within
from stickslip.discovery.laboratory.search import Searched, SearchStep
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.laboratory.wrong_constant import NEAR, evidence_of, rivals_of
from stickslip.discovery.next_experiment import next_experiments
from stickslip.discovery.residual import describe
from stickslip.discovery.result import (
    TIED,
    Alternative,
    Curve,
    ErrorBlock,
    Evidence,
    Experiment,
    FoundEffect,
    Gate,
    Residual,
    Rival,
)
from stickslip.discovery.rig_numbers import PLACES
from stickslip.likelihoods.declared_numbers import fitted_model
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.held_out import held_out
from stickslip.likelihoods.interval import Interval
from stickslip.likelihoods.repeating import lost, repeats
from stickslip.likelihoods.scatter_size import scatter as scatter_size
from stickslip.likelihoods.scatter_size import shown
from stickslip.likelihoods.scatter_words import differing

Floats = NDArray[np.float64]
REPEATS = "every event of a run is like every other: friction does not scatter"
UNKNOWN = 0.3  # share of a prior's variance above which the readings say nothing of a number


def described(what: Left) -> Residual:
    """Return what a fit leaves against the noise."""
    return describe(what)


def intervals(fit: Fit) -> dict[str, Interval]:
    """Return every shared number with its 95 % interval; one that the prior alone holds has none."""
    assert fit.solution is not None
    _, precision = fit.windows.prior.at(fit.at)
    laws = fit.windows.model.friction.numbers
    out: dict[str, Interval] = {}
    for i, (n, x) in enumerate(zip(fit.windows.numbers, fit.at, strict=True)):
        if n.run is not None or n.name in out:
            continue
        variance, value = max(float(fit.solution.covariance[i, i]), 0.0), n.value(float(x))
        half = SIGMAS_95 * math.sqrt(variance)
        if n.name in laws and variance * precision[i, i] > UNKNOWN:
            out[n.name] = Interval(value, None, None)
            continue
        out[n.name] = Interval(value, n.value(float(x) - half), n.value(float(x) + half))
    return out


def law(fit: Fit) -> dict[str, Interval]:
    """Return the law's numbers with their intervals, computed beside everything else."""
    return {k: v for k, v in intervals(fit).items() if k in fit.windows.model.friction.numbers}


def model(bench: Bench, trial: Trial, declared: Model) -> Model:
    """Return the model of a hypothesis: law, constants and effects as fitted, channels and noise as declared."""
    values = trial.fit.values()
    effects = []
    for one in trial.terms:
        e = one.effect
        if one.phases:
            e = e.replace(phi=float(np.mod(one.phases[0], 2 * math.pi)))
        if one.kind.wave is not None and e.parameters["a"] < 0:
            e = e.replace(a=-e.parameters["a"], phi=float(np.mod(e.parameters["phi"] + math.pi, 2 * math.pi)))
        effects.append(e)
    made = fitted_model(bench.model, values)
    return Model(
        made.rig,
        friction=made.friction,
        effects=(*effects, *made.effects),
        channels=declared.channels,
        noise=declared.noise,
        scatter=None if lost(trial.fit) else trial.fit.population.declared(),
    )


def effects(bench: Bench, found: Searched) -> tuple[FoundEffect, ...]:
    """Return the effects of the verdict, in order of weight."""
    chosen, numbers = found.chosen, intervals(found.chosen.fit)
    out = []
    for one in chosen.terms:
        kind = one.kind
        own = {k: within(kind, k, v) for k, v in _own(numbers, one.name).items()}
        a = own.get("a") if kind.wave is not None else None
        turned = a is not None and a.value < 0
        if a is not None and turned:
            own["a"] = Interval(
                -a.value, None if a.high is None else -a.high, None if a.low is None else -a.low
            )
        phases = {
            run.name: float(np.mod(p + (math.pi if turned else 0.0), 2 * math.pi))
            for run, p in zip(bench.data, one.phases, strict=False)
        }
        proof = evidence(found, one.name)
        rivals = alternatives(found, one.name)
        out.append(
            FoundEffect(kind.name, one.where, kind.depends_on, own, proof, rivals, kind.formula, None, phases)
        )
    if chosen.freed is not None:
        out.append(_wrong_constant(bench, found, chosen.freed))
    return tuple(sorted(out, key=lambda one: -one.evidence.weight))


def _wrong_constant(bench: Bench, found: Searched, wrong: Freed) -> FoundEffect:
    """A declared constant that is off by more than three of its standard uncertainties."""
    where, on = PLACES[wrong.name]
    rig = every_number(bench.model.rig)
    gain = wrong.name in CHANNELS
    called, value = (f"the gain of {wrong.name}", 1.0) if gain else (wrong.name, rig[wrong.name])
    words = f"{called} is {value * (1 + wrong.off):.4g} rather than {value:.4g} ({100 * wrong.off:+.3g} %)"

    def named(one: Freed) -> tuple[str, Mapping[str, Interval]] | None:
        return None if one.name in CHANNELS else (f"rig_{one.name}", {one.name: one.interval(rig[one.name])})

    return FoundEffect(
        "sensor_gain" if gain else f"rig_{wrong.name}",
        where,
        on,
        {wrong.name: wrong.interval(value)},
        evidence_of(found, wrong),
        rivals_of(wrong, named),
        words,
        of_rig=True,
    )


def _step_of(found: Searched, name: str) -> SearchStep:
    """The step that an effect was taken in, or the first in which it was fitted."""
    for step in found.steps:
        if any(t.names[-1] == name for t in step.trials):
            return step
    return found.steps[-1]


def _without(found: Searched, name: str) -> Trial:
    """The chosen hypothesis without one of its effects."""
    if len(found.chosen.terms) == 1:  # what was left out beside others says nothing of it alone
        return found.null
    return found.without[name] if name in found.without else _step_of(found, name).base


def evidence(found: Searched, name: str, base: Trial | None = None, alike: Collection[str] = ()) -> Evidence:
    """
    Return what speaks for an effect.

    Parameters
    ----------
    found, name : the search's end, and which effect
    base : what stands without it, and without others that are told with it
    alike : hypotheses that say the same; none is a control
    """
    step, base = _step_of(found, name), base or _without(found, name)
    gain = base.deviance - found.chosen.deviance
    wrong = [t for t in step.trials if t.names[-1] not in {*found.chosen.names, *alike}]
    control = min(wrong, key=lambda t: t.deviance, default=None)
    fall = None if control is None else max(step.base.deviance - control.deviance, 0.0)
    label = "" if control is None else control.names[-1]
    asked = step.gate_of(next((t for t in step.trials if t.names[-1] == name), found.chosen))
    words = f"lowers -2 log marginal likelihood by {gain:.4g} (scatter alone: {asked.threshold:.3g})"
    if fall is not None:
        words += f"; the best wrong effect, {label}, by {fall:.4g}"
    best = found.chosen.fit
    unseen, without = (held_out(one, best.population, best.noise) for one in (best, base.fit))
    ratio = math.sqrt(unseen / without)
    words += f"; error on windows held out falls to {ratio:.3g} of what it was"
    return Evidence(gain, base.worth() - found.chosen.worth(), ratio, fall, label, asked.threshold, words)


def numbers_of(trial: Trial, term: Term) -> dict[str, Interval]:
    """Return the numbers of an effect of a hypothesis that all runs share, by their short names."""
    return _own(intervals(trial.fit), term.name)


def _own(numbers: Mapping[str, Interval], name: str) -> dict[str, Interval]:
    """Numbers of an effect that all runs share, by their short names."""
    every = {k.removeprefix(f"{name}."): v for k, v in numbers.items() if k.startswith(f"{name}.")}
    return {k: v for k, v in every.items() if k != "phi"}


def alternatives(found: Searched, name: str) -> tuple[Alternative, ...]:
    """Return the rivals that fit nearly as well."""
    step = _step_of(found, name)
    own = next((t for t in step.trials if t.names[-1] == name), None)
    if own is None:
        return ()
    out, least = [], _least(found, own)
    for rival in step.trials:
        label, delta = rival.names[-1], _least(found, rival) - least
        if label == name or delta > NEAR or label in found.chosen.names:
            continue
        tied = delta < TIED
        reason = "fits these runs as well as the winner"
        if not tied:
            reason = "fits almost as well; the odds are against it"
        elif delta < -TIED:
            reason = "fits these runs better than the winner, but as what scatters might"
        numbers = _own(intervals(rival.fit), label)
        odds = math.exp(-0.5 * max(min(delta, 700.0), -700.0))
        out.append(Alternative(label, odds, delta, tied, False, reason, numbers))
    return tuple(sorted(out, key=lambda one: one.delta))


def _least(found: Searched, trial: Trial) -> float:
    """The least -2 log evidence of all that was fitted with the same effects: a step's own may have gone astray."""
    every = [*found.trials, *found.without.values(), found.chosen]
    alike = [t.whole() for t in every if t.freed is trial.freed and sorted(t.names) == sorted(trial.names)]
    return min(alike, default=trial.whole())


def unlisted(found: Searched, curve: ScoredCurve, told: Trial) -> FoundEffect:
    """Return what no name explains: a place, a variable and a curve; beside names in the model `told` that stand in."""
    terms = {
        "contact": "friction factor minus 1",
        "block": "force on the block",
        "angle_body": "force on the angle body",
        "belt": "relative change of the belt's speed",
        "x1 channel": "added to the x1 reading",
        "y1 channel": "added to the y1 reading",
    }
    term = terms[curve.where]
    words = f"a curve in {curve.variable} lowers -2 log marginal likelihood by {curve.gain:.4g}"
    words += f" (scatter alone, prices paid: {curve.threshold:.3g})"
    names = [one.name for one in told.terms if not isinstance(one.effect, Tabulated)]
    standing = f"; in the model {' and '.join(names)} stand in for the rest" if names else ""
    best = min((t for t in found.steps[0].trials), key=Trial.worth, default=None)
    fall = None if best is None else max(found.null.deviance - best.deviance, 0.0)
    label = "" if best is None else best.names[-1]
    if fall is not None:
        words += f"; the best name, {label}, by {fall:.4g}"
    proof = Evidence(
        curve.gain, curve.worth(len(found.null.fit.own)), None, fall, label, curve.threshold, words
    )
    x, value, std = curve.drawn()
    shape = Curve(
        curve.where,
        curve.variable,
        term,
        x,
        value,
        value - SIGMAS_95 * std,
        value + SIGMAS_95 * std,
        curve.x,
        None if curve.period else guess(curve.x, curve.value, SIGMAS_95 * curve.std, curve.variable),
        curve.period,
    )
    return FoundEffect(
        "unlisted",
        curve.where,
        (curve.variable,),
        {},
        proof,
        (),
        f"{term}: a curve in {curve.variable}{standing}",
        shape,
    )


def experiments(
    bench: Bench, found: Searched, effects: Sequence[FoundEffect], declared: Model
) -> tuple[Experiment, ...]:
    """Return runs that would tell tied rivals apart, friction's numbers free in each as they scatter."""
    fitted = {frozenset(t.names): model(bench, t, declared) for t in (*found.trials, found.chosen)}
    laws = found.chosen.fit.windows.model.friction.numbers
    free = [n.name for n in found.chosen.fit.windows.numbers if n.name in laws]
    return next_experiments(fitted, frozenset(found.chosen.names), bench.data, effects, free)


def ranking(found: Searched) -> tuple[Rival, ...]:
    """Return all that was fitted or scored, best first."""
    rows: dict[tuple[str, ...], Rival] = {}
    null, chosen = found.null, found.chosen
    for t in [*found.trials, *found.without.values(), chosen]:
        values = {
            k: v
            for k, v in t.fit.values().items()
            if k.rpartition(".")[0] in t.names and not k.endswith(".phi")
        }
        row = Rival(t.names, per_reading(t.fit), t.whole(), values, None, t.names == chosen.names)
        if t.names not in rows or row.bic < rows[t.names].bic:
            rows[t.names] = row
    count = len(null.fit.own)
    for one in found.steps[0].screen.ranked if found.steps else ():
        names = (one.term.name,)
        if names not in rows:
            rows[names] = Rival(
                names, per_reading(null.fit), null.whole() - one.worth(count), {}, max(one.gain, 0.0), False
            )
    least = min(row.bic for row in rows.values())
    moved = [Rival(r.names, r.chi2, r.bic - least, r.parameters, r.score, r.chosen) for r in rows.values()]
    return tuple(sorted(moved, key=lambda row: row.bic))


def per_reading(fit: Fit) -> float:
    """Return chi-squared per reading of windows as they are linearised."""
    assert fit.linear is not None
    return float(fit.linear.gram[:, :, -1, -1].sum() / max(fit.linear.count.sum(), 1.0))


def gate(found: Searched) -> Gate:
    """Return the gate of the best of the first step, and what it gains by it; endless if none is tried."""
    if not found.steps:
        return Gate(0.0, math.inf, 0.0, np.zeros(0))
    step = found.steps[0]
    best = max(step.trials, key=step.gained, default=None)
    if best is None:
        asked, gained = step.gate, 0.0
    else:
        asked = step.gate_of(best)
        gained = (
            asked.observed if best.comes_and_goes and math.isfinite(asked.observed) else step.gained(best)
        )
    over = asked.draws > asked.threshold
    return Gate(max(gained, 0.0), asked.threshold, float(np.mean(over)), asked.draws)


def scatter(fit: Fit) -> Mapping[str, Interval]:
    """
    Return the relative standard deviations of what differs from event to event, as `identify` has them.

    Of a fit that is lost they are those that the events show by themselves, where they do.
    """
    if repeats(fit):
        return {}
    sizes = shown(fit) if lost(fit) else {}
    if not sizes:
        found = scatter_size(fit, 1.0)
        sizes = {"static": found.static, "kinetic": found.kinetic, "belt": found.belt}
    return {k: Interval(one.value, one.low, one.high) for k, one in sizes.items()}


def remarks(trial: Trial, error: ErrorBlock) -> tuple[str, ...]:
    """Return what a person should read beside the verdict."""
    sizes = scatter(trial.fit)
    out = [differing({k: one.value for k, one in sizes.items()}) if sizes else REPEATS]
    if error.covered is not None:
        out.append(
            f"the 95 % band of forecasts of one cycle holds {100 * error.covered:.0f} % of the readings of runs "
            "never used"
        )
    if trial.terms and error.carries and error.rises:
        assert error.likelihood is not None
        out.append(
            f"the error of the mean forecast RISES from {error.before:.3g} to {error.after:.3g} on runs never used, of "
            f"which friction of events to come makes {error.floor:.3g}; their -2 log likelihood changes by "
            f"{-error.likelihood.gain:+.3g} with what was found (p = {error.likelihood.chance:.2g} that they speak "
            "against it)"
        )
    return tuple(out)
