"""What stands beside a hypothesis: one effect more, fitted from the best of several starts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from stickslip.discovery.laboratory.constants import Freed
from stickslip.discovery.laboratory.hypothesis import Bench, Term, sizes_of, terms_at
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.discovery.laboratory.screen import Candidate
from stickslip.discovery.rig_numbers import BEYOND
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.event_windows import own_in
from stickslip.likelihoods.fit import begun, fitted
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.remembered import remembered
from stickslip.likelihoods.repeating import explained, lost
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
    def comes_and_goes(self) -> bool:
        """Whether its last effect is a wave."""
        return bool(self.terms) and self.terms[-1].kind.wave is not None

    @property
    def deviance(self) -> float:
        """-2 log marginal likelihood, and what of its gain is no finding."""
        return self.fit.deviance + self.known

    def numbers(self) -> int:
        """How many numbers its effects have, and its constants that are not as declared."""
        effects = sum(n.name.rpartition(".")[0] in self.names for n in self.fit.windows.numbers)
        return effects + (self.freed is not None)

    @cached_property
    def remembered(self) -> float:
        """What its deviance falls by where friction of neighbouring events is as alike as it shows them."""
        return remembered(self.fit)

    def independent(self) -> float:
        """Return -2 log evidence with every event by itself, as a score has it, the price of its numbers included."""
        return self.fit.deviance + self.numbers() * math.log(len(self.fit.own))

    def whole(self) -> float:
        """Return -2 log evidence with events that remember: by it rivals are held against each other."""
        return self.independent() - self.remembered

    def worth(self) -> float:
        """Return the same less what of its gain is no finding: by it one passes the gate."""
        return self.whole() + self.known

    def strict(self) -> float:
        """
        Return the same with every constant as well known as declared, however far off: no tails forgive it.

        With tails a hypothesis has all those in it where one or more constants are wrong; it does not stand against
        one of them.
        """
        return self.whole() + self.fit.windows.prior.forgiven(self.fit.at)

    def over(self, other: Trial) -> float:
        """
        Return what it is worth beyond another hypothesis, whether events remember or not.

        Fits take every event by itself. That events are alike beside an effect does not speak for it; that they are
        alike without it speaks against it.
        """
        return self.explains(other) - (self.known - other.known)

    def explains(self, other: Trial) -> float:
        """Return the same with what of its gain scatter may have made."""
        return min(other.whole() - self.whole(), other.independent() - self.independent())


def all_full(
    bench: Bench, base: Trial, every: Sequence[Candidate], workers: Workers, beyond: Sequence[Trial] = ()
) -> tuple[list[Trial], tuple[str, ...]]:
    """
    Candidates beside a hypothesis, each fitted from the best of several starts, and those fitted anew.

    What is worth less than its score promised is fitted anew where no other reaches that much; beside a null that is
    no model of the windows, so is what reaches furthest, before the others are held against it; but nothing is that
    falls short of what is there already. Nor is a curve that no one declared: its shapes reach what is near, and from
    afar it takes long; where it promised more than others reach it has its other starts. Where it leads, names whose
    steps ran out on the way are fitted anew: what each of them is, it can be.

    Parameters
    ----------
    bench, base, every, workers : the hypothesis, and what to fit beside it
    beyond : what was fitted beside it before
    """
    near = workers.map(partial(_near, bench, base), every)
    terms = {one.term.name: one.term for one in every}
    fits = {one.term.name: fit for one, fit in zip(every, near, strict=True) if fit is not None}
    done, there = list[str](), min((one.fit.deviance for one in beyond), default=np.inf)
    reached = min([there, *(fit.deviance for fit in fits.values())])
    curves = [
        one
        for one in every
        if one.term.kind.nameless and one.term.name in fits and _promised(bench, base, one) < reached
    ]
    more = workers.map(partial(_curve, bench, base), [(fits[one.term.name], one) for one in curves])
    fits |= {one.term.name: fit for one, fit in zip(curves, more, strict=True)}
    first = min(fits, key=lambda name: fits[name].deviance, default=None)
    if (
        first is not None
        and not terms[first].kind.nameless
        and fits[first].deviance < there
        and not explained(base.fit)
    ):
        # a null that is far off is no place to start from: what comes furthest from there may come further
        fits[first] = _sought(bench, base, (fits[first], terms[first]), workers)
        done.append(first)
    reached = min([there, *(fit.deviance for fit in fits.values())])
    curve_leads = first is not None and terms[first].kind.nameless and fits[first].deviance < there
    short = [
        one
        for one in every
        if one.term.name in fits.keys() - set(done)
        and not one.term.kind.nameless
        and (
            _promised(bench, base, one) < min(reached, fits[one.term.name].deviance - bench.policy.noticed)
            or (curve_leads and ran_out(fits[one.term.name], bench.policy))
        )
    ]
    again = workers.map(partial(_again, bench, base), [(fits[one.term.name], one) for one in short])
    fits |= {one.term.name: fit for one, fit in zip(short, again, strict=True)}
    done += [one.term.name for one in short]
    trials = [
        trial_beside(bench, base, fits[one.term.name], one.term) for one in every if one.term.name in fits
    ]
    return trials, tuple(done)


def _promised(bench: Bench, base: Trial, candidate: Candidate) -> float:
    """The deviance that a candidate's score promises, less what of it is no finding."""
    return base.fit.deviance - candidate.gain + of_scatter(bench, base.fit, candidate.term, candidate.gain)


def _near(bench: Bench, base: Trial, candidate: Candidate) -> Fit | None:
    """A candidate beside a hypothesis, fitted from where that stands; None where no window can be simulated with it."""
    return _from_starts(bench, _starts(bench, base, candidate), np.inf)


def _curve(bench: Bench, base: Trial, found: tuple[Fit, Candidate]) -> Fit:
    """A curve's fit, or a better one from its other starts while steps run out short of what its score promised."""
    fit, candidate = found
    enough = _promised(bench, base, candidate)
    if fit.deviance <= enough or not ran_out(fit, bench.policy):
        return fit
    return _better(fit, _from_starts(bench, _starts(bench, base, candidate)[1:], enough))


def _again(bench: Bench, base: Trial, found: tuple[Fit, Candidate]) -> Fit:
    """
    A name's fit, or a better one from elsewhere.

    With all its sizes 0 it is the hypothesis: a fit whose steps ran out above that failed, and is begun from its other
    starts, too.
    """
    fit, candidate = found
    if fit.deviance > base.fit.deviance and ran_out(fit, bench.policy):
        fit = _better(fit, _from_starts(bench, _starts(bench, base, candidate)[1:], base.fit.deviance))
    return _sought(bench, base, (fit, candidate.term))


def _better(fit: Fit, other: Fit | None) -> Fit:
    return fit if other is None or other.deviance >= fit.deviance else other


def _from_starts(bench: Bench, starts: Sequence[Fit], enough: float) -> Fit | None:
    """The best fit of a candidate from its starts, one after the other while steps run out above `enough`."""
    best: Fit | None = None
    for start in starts:
        fit = from_near(bench, start)
        if fit is not None and (best is None or fit.deviance < best.deviance):
            best = fit
        if best is not None and (best.deviance <= enough or not ran_out(best, bench.policy)):
            break
    return best


def ran_out(fit: Fit, policy: Policy) -> bool:
    """Whether the fit of a candidate took all the steps that it has, and may not be at its best."""
    return fit.steps >= policy.candidate_steps


def from_near(bench: Bench, start: Fit) -> Fit | None:
    """A start beside a hypothesis, fitted; None where it ends at numbers that no window can be simulated with."""
    with suppress(FloatingPointError, np.linalg.LinAlgError):
        return fitted(start, bench.policy, bench.policy.candidate_steps, held=2)
    return None


def _starts(bench: Bench, base: Trial, candidate: Candidate) -> list[Fit]:
    """Where a candidate may start, the best first."""
    out = list[tuple[float, Fit]]()
    for scale, moved in ((1.0, False), (1.0, True), (0.4, False)):
        term = _scaled(candidate.term, scale)
        windows = bench.windows((*base.terms, term))
        p = len(base.fit.at)
        at = np.concatenate([base.fit.at, [n.start for n in windows.numbers[p:]]])
        if moved:
            stride = np.array([n.stride for n in windows.numbers[:p]])
            at[:p] += np.clip(candidate.step, -stride, stride)
        at = windows.bounded(at)
        first = replace(base.fit, windows=windows, at=at, own=own_in(base.fit.own, base.fit.windows, windows))
        own, _, each = settled(first)
        out.append((float(each.sum()) + windows.prior.penalty(at), replace(first, own=own)))
    return [fit for _, fit in sorted(out, key=lambda one: one[0])]


def trial_beside(bench: Bench, base: Trial, fit: Fit, term: Term) -> Trial:
    """A hypothesis and one term more, as fitted."""
    found = terms_at((*base.terms, term), fit.windows, fit.at)
    known = of_scatter(bench, fit, found[-1], base.fit.deviance - fit.deviance)
    if known > 0:  # what events that remember make of waves is no finding, but is counted once
        known = max(known - max(base.remembered - remembered(fit), 0.0), 0.0)
    return Trial(found, fit, base.known + known)


def fitted_beside(bench: Bench, base: Trial, term: Term) -> Trial | None:
    """Return a hypothesis with a term that was fitted elsewhere, fitted; None where no window can be simulated."""
    windows = bench.windows((*base.terms, term))
    p = len(base.fit.at)
    at = windows.bounded(np.concatenate([base.fit.at, [n.start for n in windows.numbers[p:]]]))
    own = own_in(base.fit.own, base.fit.windows, windows)
    fit = from_near(bench, replace(base.fit, windows=windows, at=at, own=own))
    return None if fit is None else trial_beside(bench, base, fit, term)


def again_from(bench: Bench, base: Trial, best: Trial) -> Trial:
    """Return a hypothesis fitted anew from where its best rival stands, if that is better."""
    windows = base.fit.windows
    p = len(base.fit.at)
    at = windows.bounded(best.fit.at[:p])
    first = replace(best.fit, windows=windows, at=at, own=own_in(best.fit.own, best.fit.windows, windows))
    fit = from_near(bench, first)
    if fit is None or fit.deviance >= base.fit.deviance or lost(fit):
        return base
    return replace(base, fit=fit, terms=terms_at(base.terms, windows, fit.at))


def held_against(bench: Bench, base: Trial, trials: Sequence[Trial]) -> list[Trial]:
    """
    Return the same trials beside another fit of the hypothesis.

    What of a wave's gain is no finding is of what it gains over that one.
    """
    return [trial_beside(bench, base, one.fit, one.terms[-1]) for one in trials]


def leader_anew(
    bench: Bench, base: Trial, trials: list[Trial], workers: Workers = ALONE, done: Sequence[str] = ()
) -> list[Trial]:
    """
    Return the trials, the best of them fitted anew and with all its numbers.

    It begins from the readings too, as a null that is far off leads astray; and with the numbers that its effect may
    do without, as no score reaches them. One that is worth nothing beside a model of the windows is not looked at
    twice.

    Parameters
    ----------
    bench, base, trials, workers : the hypothesis, and what was fitted beside it
    done : effects that were fitted anew already
    """
    if not trials:
        return trials
    leader = min(trials, key=Trial.worth)
    term, rest = leader.terms[-1], [one for one in trials if one is not leader]
    idle = term.kind.nameless or (leader.worth() >= base.worth() and explained(base.fit))
    if not idle and term.name not in done:
        fit = _sought(bench, base, (leader.fit, term), workers)
        if fit.deviance < leader.fit.deviance:
            leader = trial_beside(bench, base, fit, term)
    fuller = workers.map(partial(_fuller, bench, base, leader), _optional_starts(term))
    return [min((leader, *(one for one in fuller if one is not None)), key=Trial.worth), *rest]


def anew(bench: Bench, start: Fit) -> Fit | None:
    """A start, fitted; None where no window can be simulated with it."""
    with suppress(FloatingPointError, np.linalg.LinAlgError):
        return fitted(start, bench.policy)
    return None


def _sought(bench: Bench, base: Trial, found: tuple[Fit, Term], workers: Workers = ALONE) -> Fit:
    """A term's fit, or a better one from elsewhere; where two end alike no third is asked for."""
    fit = found[0]
    for again in workers.ahead(partial(anew, bench), _afresh(bench, base, found)):
        if again is None:
            continue
        apart = abs(again.deviance - fit.deviance)
        fit = min(fit, again, key=lambda one: one.deviance)
        if apart < bench.policy.noticed:
            break
    return fit


def _optional_starts(term: Term) -> Iterator[dict[str, float]]:
    """Where the catalogue begins numbers that an effect may do without."""
    kind = term.kind
    if isinstance(kind, RivalKind):
        return
    optional = {i.name for i in kind.parameters if i.optional}
    for start in kind.starts:
        if more := {k: v for k, v in start.items() if k in optional and term.effect.parameters[k] == 0}:
            yield more


def _fuller(bench: Bench, base: Trial, leader: Trial, more: dict[str, float]) -> Trial | None:
    """The leader with numbers that its effect may do without, None where no window can be simulated with them.

    No score reaches them from 0.
    """
    term = replace(leader.terms[-1], effect=leader.terms[-1].effect.replace(**more))
    windows = bench.windows((*leader.terms[:-1], term))
    found = {(n.name, n.run): x for n, x in zip(leader.fit.windows.numbers, leader.fit.at, strict=True)}
    at = np.array([found.get((n.name, n.run), n.start) for n in windows.numbers])
    fit = from_near(bench, replace(leader.fit, windows=windows, at=at))
    return None if fit is None else trial_beside(bench, base, fit, term)


def _afresh(bench: Bench, base: Trial, found: tuple[Fit, Term]) -> Iterator[Fit]:
    """
    Starts with a size that is known: from the readings alone, at the declared law, then at the null's.

    Of a fit that has constants far from where they are declared the last is that fit with these as declared: without
    the effect they did its work, and readings of a force are as they were where all forces and its gain move together.
    """
    fit, term = found
    first = begun(bench.windows((*base.terms, term)))
    yield first
    yield replace(first, at=np.concatenate([base.fit.at, first.at[len(base.fit.at) :]]))
    if fit.windows.prior.farthest(fit.at) > BEYOND:
        yield replace(fit, at=fit.windows.prior.as_declared(fit.at))


def of_scatter(bench: Bench, fit: Fit, term: Term, gain: float) -> float:
    """
    Return what of a wave's gain is no finding: it may be one of the waves that scatter is made of.

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
