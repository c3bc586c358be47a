"""The search: score everything, fit the best, refit the null from where they stand, go forward, then back."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.laboratory.constants import Freed, freed
from stickslip.discovery.laboratory.gate import Gate, gate
from stickslip.discovery.laboratory.hypothesis import Bench, Term, sizes_of, terms_at
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.discovery.laboratory.screen import Candidate, Screen, screened
from stickslip.likelihoods.event_windows import own_in
from stickslip.likelihoods.fit import begun, fitted, null
from stickslip.likelihoods.fit_state import Fit, unexplained
from stickslip.likelihoods.repeating import lost
from stickslip.likelihoods.single_windows import settled


@dataclass(frozen=True)
class Trial:
    """
    A hypothesis, fitted.

    Parameters
    ----------
    terms : its effects, as fitted
    fit : where it stands
    known : gain that it has from waves no larger than scatter and wobble have
    freed : a declared constant that is not as declared
    """

    terms: tuple[Term, ...]
    fit: Fit
    known: float = 0.0
    freed: Freed | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its effects."""
        return tuple(one.name for one in self.terms)

    @property
    def deviance(self) -> float:
        """-2 log marginal likelihood, and what of its gain is no finding."""
        return self.fit.deviance + self.known

    def numbers(self) -> int:
        """How many numbers its effects have, and its constants that are not as declared."""
        effects = sum(n.name.rpartition(".")[0] in self.names for n in self.fit.windows.numbers)
        return effects + (self.freed is not None)

    def whole(self) -> float:
        """Return -2 log evidence, the price of its numbers included: by it rivals are held against each other."""
        return self.fit.deviance + self.numbers() * math.log(len(self.fit.own))

    def worth(self) -> float:
        """Return the same less what of its gain is no finding: by it one passes the gate."""
        return self.whole() + self.known


@dataclass
class Step:
    """One step forward: the hypothesis before it, what was scored and fitted, and what scatter alone would gain."""

    base: Trial
    screen: Screen
    trials: list[Trial]
    gate: Gate


@dataclass
class Searched:
    """The search's end: what stands, the declared model alone, and all that was tried on the way."""

    null: Trial
    chosen: Trial
    steps: list[Step] = field(default_factory=list)
    without: dict[str, Trial] = field(default_factory=dict)

    @property
    def trials(self) -> list[Trial]:
        """Everything that was fitted."""
        return [self.null, *(t for step in self.steps for t in step.trials)]


def search(
    bench: Bench, known: Uncertainty, tell: Callable[[str], None], seed: int = 0, base: Trial | None = None
) -> Searched:
    """
    Return what the runs say of every effect, alone and beside others, and of the declared constants.

    Parameters
    ----------
    bench, known : the case, and how well its constants are known
    tell, seed : told what is being done; of the gate's draws
    base : the declared model as fitted; None: it is fitted first
    """
    if base is None:
        tell("fitting the declared law, its constants and its scatter")
        base = Trial((), null(bench.windows(), bench.policy))
    out = Searched(base, base)
    while len(base.terms) < bench.policy.most_effects:
        step, base = _forward(bench, base, tell, seed)
        if not base.terms:
            out.null = base
        out.steps.append(step)
        least = step.gate.threshold
        passing = [t for t in step.trials if min(base.worth() - t.worth(), _told(t)) > least]
        if not passing:
            break
        base = min(passing, key=Trial.whole)
    out.chosen = _of_constants(bench, known, out.null, _back(bench, base, out, tell))
    return out


def _told(trial: Trial) -> float:
    """
    Return what the sizes of its last effect are worth by their own standard errors, their price paid.

    A fall of the deviance that they do not tell is what the fit without the effect was short of. Of an effect without
    sizes, as a time constant alone, nothing is asked.
    """
    one, fit = trial.terms[-1], trial.fit
    names = {f"{one.name}.{i.name}" for i in sizes_of(one.kind)}
    places = [i for i, n in enumerate(fit.windows.numbers) if n.name in names and not n.logarithmic]
    if not places or fit.solution is None:
        return math.inf
    size, covariance = fit.at[places], fit.solution.covariance[np.ix_(places, places)]
    return float(size @ np.linalg.solve(covariance, size)) - len(places) * math.log(len(fit.own))


def _of_constants(bench: Bench, known: Uncertainty, null: Trial, chosen: Trial) -> Trial:
    """What was chosen, or a declared constant that is wrong in its place or beside it."""
    rivals = [chosen]
    for one in (null, chosen) if chosen.terms else (chosen,):
        every = freed(bench, one.fit, known)
        if every and every[0].beyond:
            first = replace(every[0], rivals=tuple(every[1:]))
            rivals.append(_with_freed(bench, known, one, first))
    return min(rivals, key=Trial.whole)


def _with_freed(bench: Bench, known: Uncertainty, trial: Trial, wrong: Freed) -> Trial:
    """A hypothesis fitted with one constant free; itself if that constant is as declared after all."""
    free = replace(bench, declared=wrong.declared)
    first = replace(trial.fit, windows=free.windows(trial.terms))
    fit = fitted(first, bench.policy, bench.policy.candidate_steps, held=2)
    # what the readings say of it where it is free
    again = next((one for one in freed(bench, fit, known) if one.name == wrong.name), wrong)
    terms = terms_at(trial.terms, fit.windows, fit.at)
    found = replace(again, gain=wrong.gain, rivals=wrong.rivals)
    return Trial(terms, fit, trial.known, found) if again.beyond else trial


def _forward(bench: Bench, base: Trial, tell: Callable[[str], None], seed: int) -> tuple[Step, Trial]:
    """Score and fit what could stand beside a hypothesis; the hypothesis, as it stands best, is the second."""
    trials: list[Trial] = []
    for turn in range(2):
        tell("scoring every effect" + (f" beside {' and '.join(base.names)}" if base.terms else ""))
        screen = screened(bench, base.fit, base.terms)
        before, trials = trials, list[Trial]()
        for one in (*screen.ranked[: bench.policy.fullest], *_of_another_kind(bench, base, screen)):
            if one.worth(len(bench.stretches)) <= 0 and trials:
                break
            tell(f"fitting {one.term.name}")
            reached = min((t.fit.deviance for t in trials), default=np.inf)
            with suppress(FloatingPointError):  # one that no window can be simulated with is no rival
                trials.append(full(bench, base, one, reached))
        trials = _every([*leader_anew(bench, base, trials), *before])
        again = _again(bench, base, min(trials, key=lambda one: one.deviance)) if trials else base
        fell, best = base.deviance - again.deviance, min((t.deviance for t in trials), default=np.inf)
        stuck = fell > bench.policy.noticed and fell > bench.policy.stuck * (base.deviance - best)
        base = again if fell > 0 else base
        if not stuck or turn:
            break
    tell("asking what scatter alone would gain")
    best_fit = min([base, *trials], key=Trial.whole).fit
    return Step(base, screen, trials, gate(bench, base.fit, screen, seed, best_fit)), base


def _of_another_kind(bench: Bench, base: Trial, screen: Screen) -> list[Candidate]:
    """Contacts that no score reaches: where a hypothesis is no model of the windows they are fitted all the same."""
    if not lost(base.fit) and unexplained(base.fit) < bench.policy.noise_left:
        return []
    rest = screen.ranked[bench.policy.fullest :]
    return [replace(one, gain=math.inf) for one in rest if one.term.kind.anywhere.bristle is not None]


def _every(trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials, of those with the same effects the best: what was fitted from another null stays a rival."""
    best: dict[tuple[str, ...], Trial] = {}
    for one in trials:
        if one.names not in best or one.deviance < best[one.names].deviance:
            best[one.names] = one
    return list(best.values())


def full(bench: Bench, base: Trial, candidate: Candidate, reached: float) -> Trial:
    """
    Return a candidate beside a hypothesis, fitted from the best of several starts.

    Parameters
    ----------
    bench, base, candidate : the hypothesis, and what is to stand beside it
    reached : deviance of the best rival so far
    """
    promised = base.fit.deviance - candidate.gain
    best: tuple[float, Fit] | None = None
    for scale, moved in ((1.0, False), (1.0, True), (0.4, False)):
        term = _scaled(candidate.term, scale)
        windows = bench.windows((*base.terms, term))
        p = len(base.fit.at)
        at = np.concatenate([base.fit.at, [n.start for n in windows.numbers[p:]]])
        if moved:
            stride = np.array([n.stride for n in windows.numbers[:p]])
            at[:p] += np.clip(candidate.step, -stride, stride)
        first = replace(base.fit, windows=windows, at=at, own=own_in(base.fit.own, base.fit.windows, windows))
        own, _, each = settled(first)
        cost = float(each.sum()) + windows.prior.penalty(at)
        if best is None or cost < best[0]:
            best = cost, replace(first, own=own)
    assert best is not None
    fit = fitted(best[1], bench.policy, bench.policy.candidate_steps, held=2)
    for start in _afresh(bench, base, candidate.term):
        if fit.deviance <= promised or reached <= promised:
            break
        # less than its score promised: the fit failed, as a null that is far off is no place to start from
        fit = min(fit, fitted(start, bench.policy), key=lambda one: one.deviance)
    return _trial(bench, base, fit, candidate.term)


def _trial(bench: Bench, base: Trial, fit: Fit, term: Term) -> Trial:
    """A hypothesis and one term more, as fitted."""
    found = terms_at((*base.terms, term), fit.windows, fit.at)
    return Trial(
        found, fit, base.known + _of_scatter(bench, fit, found[-1], base.fit.deviance - fit.deviance)
    )


def leader_anew(bench: Bench, base: Trial, trials: list[Trial]) -> list[Trial]:
    """
    Return the trials, the best of them fitted anew and with all its numbers.

    It begins from the readings too, as a null that is far off leads astray; and with the numbers that its effect may
    do without, as no score reaches them.
    """
    if not trials:
        return trials
    leader = min(trials, key=Trial.worth)
    term, rest = leader.terms[-1], [one for one in trials if one is not leader]
    for start in _afresh(bench, base, term):
        with suppress(FloatingPointError):
            anew = fitted(start, bench.policy)
            if anew.deviance < leader.fit.deviance:
                leader = _trial(bench, base, anew, term)
    rivals = [leader, *(_fuller(bench, base, leader, one) for one in _optional_starts(term))]
    return [min(rivals, key=Trial.worth), *rest]


def _optional_starts(term: Term) -> Iterator[dict[str, float]]:
    """Where the catalogue begins numbers that an effect may do without."""
    kind = term.kind
    if isinstance(kind, RivalKind):
        return
    optional = {i.name for i in kind.parameters if i.optional}
    for start in kind.starts:
        if more := {k: v for k, v in start.items() if k in optional and term.effect.parameters[k] == 0}:
            yield more


def _fuller(bench: Bench, base: Trial, leader: Trial, more: dict[str, float]) -> Trial:
    """The leader with numbers that its effect may do without; no score reaches them from 0."""
    term = replace(leader.terms[-1], effect=leader.terms[-1].effect.replace(**more))
    windows = bench.windows((*leader.terms[:-1], term))
    found = {(n.name, n.run): x for n, x in zip(leader.fit.windows.numbers, leader.fit.at, strict=True)}
    at = np.array([found.get((n.name, n.run), n.start) for n in windows.numbers])
    fit = fitted(
        replace(leader.fit, windows=windows, at=at), bench.policy, bench.policy.candidate_steps, held=2
    )
    return _trial(bench, base, fit, term)


def _afresh(bench: Bench, base: Trial, term: Term) -> Iterator[Fit]:
    """Starts from the readings alone, with a size that is known: at the declared law, then at the null's."""
    first = begun(bench.windows((*base.terms, term)))
    yield first
    yield replace(first, at=np.concatenate([base.fit.at, first.at[len(base.fit.at) :]]))


def _of_scatter(bench: Bench, fit: Fit, term: Term, gain: float) -> float:
    """
    What of a wave's gain is no finding: it may be one of the waves that scatter is made of.

    What tells a wave from those is its amplitude over theirs, squared, in each run.
    """
    if term.kind.wave is None:
        return 0.0
    told = len(bench.data) * (term.effect.parameters["a"] / bench.scattered(fit, term)) ** 2
    return max(gain - told, 0.0)


def _scaled(term: Term, scale: float) -> Term:
    """The term with its sizes scaled."""
    kind = term.kind
    sizes = {i.name for i in sizes_of(kind)} or {i.name for i in kind.parameters if not i.optional}
    numbers = {k: v * scale if k in sizes else v for k, v in term.effect.parameters.items()}
    if isinstance(kind, RivalKind):
        numbers |= {i.name: min(max(numbers[i.name], i.bounds[0]), i.bounds[1]) for i in kind.parameters}
    return replace(term, effect=term.effect.replace(**numbers))


def _again(bench: Bench, base: Trial, best: Trial) -> Trial:
    """The hypothesis fitted anew from where its best rival stands, if that is better."""
    windows = base.fit.windows
    p = len(base.fit.at)
    low, high = (np.array([getattr(n, k) for n in windows.numbers]) for k in ("low", "high"))
    at = np.clip(best.fit.at[:p], low, high)
    first = replace(best.fit, windows=windows, at=at, own=own_in(best.fit.own, best.fit.windows, windows))
    fit = fitted(first, bench.policy, bench.policy.candidate_steps, held=2)
    if fit.deviance >= base.fit.deviance or lost(fit):
        return base
    return replace(base, fit=fit, terms=terms_at(base.terms, windows, fit.at))


def _back(bench: Bench, chosen: Trial, out: Searched, tell: Callable[[str], None]) -> Trial:
    """The hypothesis less what it does not need."""
    while len(chosen.terms) > 1:
        rivals = {}
        for i, one in enumerate(chosen.terms):
            tell(f"once more without {one.name}")
            rivals[one.name] = without(bench, chosen, i)
        out.without = rivals
        best = min(rivals.values(), key=Trial.worth)
        if best.worth() - chosen.worth() > out.steps[-1].gate.threshold:
            break
        chosen = _anew(bench, best)
    return chosen


def _anew(bench: Bench, trial: Trial) -> Trial:
    """What is left, or the same fitted from the readings: it was begun beside an effect that it does not need."""
    with suppress(FloatingPointError):
        fit = fitted(begun(trial.fit.windows), bench.policy)
        if fit.deviance < trial.fit.deviance:
            return replace(trial, fit=fit, terms=terms_at(trial.terms, fit.windows, fit.at))
    return trial


def without(bench: Bench, trial: Trial, index: int) -> Trial:
    """Return a hypothesis without one of its effects."""
    terms = tuple(one for i, one in enumerate(trial.terms) if i != index)
    windows = bench.windows(terms)
    gone = trial.terms[index].name + "."
    kept = [i for i, n in enumerate(trial.fit.windows.numbers) if not n.name.startswith(gone)]
    fit = fitted(
        replace(
            trial.fit,
            windows=windows,
            at=trial.fit.at[kept],
            own=own_in(trial.fit.own, trial.fit.windows, windows),
        ),
        bench.policy,
        bench.policy.candidate_steps,
        held=2,
    )
    return Trial(terms_at(terms, windows, fit.at), fit, trial.known)
