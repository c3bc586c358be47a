"""The search: score everything, fit the best, refit the null from where they stand, go forward, then back."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.laboratory.constants import Freed, freed
from stickslip.discovery.laboratory.gate import SearchGate, gate
from stickslip.discovery.laboratory.hypothesis import Bench, sizes_of, terms_at
from stickslip.discovery.laboratory.refitted import refitted
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.discovery.laboratory.screen import Candidate, Screen, screened
from stickslip.discovery.laboratory.trials import (
    Trial,
    again_from,
    all_full,
    anew,
    fitted_beside,
    from_near,
    held_against,
    leader_anew,
)
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.event_windows import own_in
from stickslip.likelihoods.fit import begun, null
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.repeating import beyond_shown, explained, swollen
from stickslip.likelihoods.shared import SharedNumber


@dataclass
class SearchStep:
    """
    One step forward.

    Parameters
    ----------
    base, screen, trials : the hypothesis before it, what was scored beside it, and what was fitted
    gate : what scatter alone would gain of effects that do not come and go
    beside : what was scored beside the best of the trials, where the gate is from there
    waves : the gates of those that come and go, by name, as far as they were asked for
    """

    base: Trial
    screen: Screen
    trials: list[Trial]
    gate: SearchGate
    beside: Screen | None = None
    waves: dict[str, SearchGate] = field(default_factory=dict)

    def gained(self, trial: Trial) -> float:
        """Return what a trial gains, prices paid, and what of it is no finding."""
        return trial.over(self.base)

    def gate_of(self, trial: Trial) -> SearchGate:
        """Return the gate that a trial must pass."""
        return self.waves.get(trial.names[-1], self.gate)

    def passes(self, trial: Trial) -> bool:
        """Return whether a trial is beyond what scatter alone gains."""
        if not self.promises(trial):
            return False
        own = self.waves.get(trial.names[-1])
        return not trial.comes_and_goes or (own is not None and own.observed > own.threshold)

    def promises(self, trial: Trial) -> bool:
        """
        Return whether it passes the gate that is drawn for effects that do not come and go.

        What scatter makes of those that do their own gate asks, of records that have all of it.
        """
        gained = trial.explains(self.base) if trial.comes_and_goes else self.gained(trial)
        return min(gained, told_by_sizes(trial)) > self.gate.threshold


@dataclass
class Searched:
    """The search's end: what stands, the declared model alone, and all that was tried on the way."""

    null: Trial
    chosen: Trial
    steps: list[SearchStep] = field(default_factory=list)
    without: dict[str, Trial] = field(default_factory=dict)

    @property
    def trials(self) -> list[Trial]:
        """Everything that was fitted."""
        return [self.null, *(t for step in self.steps for t in step.trials)]


def search(
    bench: Bench,
    known: Uncertainty,
    tell: Callable[[str], None],
    seed: int = 0,
    base: Trial | None = None,
    workers: Workers = ALONE,
    ends: Callable[[Trial], bool] = lambda _: False,
) -> Searched:
    """
    Return what the runs say of every effect, alone and beside others, and of the declared constants.

    Parameters
    ----------
    bench, known : the case, and how well its constants are known
    tell, seed : told what is being done; of the gate's draws
    base : the declared model as fitted; None: it is fitted first
    workers : do what does not wait for one another; what is found does not depend on how many they are
    ends : whether nothing more is to be sought beside what a step found, as it is to be sought anew
    """
    if base is None:
        tell("fitting the declared law, its constants and its scatter")
        base = Trial((), null(bench.windows(), bench.policy, twice=True, each=workers.map))
    out = Searched(base, base)
    screen: Screen | None = None
    while len(base.terms) < bench.policy.most_effects:
        step, base = _forward(bench, base, tell, seed, workers, screen, out.steps)
        if not base.terms:
            out.null = base
        out.steps.append(step)
        found = _passing(bench, step, tell, seed, workers)
        if found is None:
            break
        base = found
        if ends(base):
            break
        screen = step.beside if base is _leader(step) else None
    out.chosen = with_wrong_constant(bench, known, out.null, _back(bench, base, out, tell, workers))
    return out


def _passing(
    bench: Bench, step: SearchStep, tell: Callable[[str], None], seed: int, workers: Workers
) -> Trial | None:
    """The best trial that passes its gate; that of a wave is drawn when it is asked."""
    for trial in sorted(step.trials, key=Trial.whole):
        if trial.comes_and_goes and step.promises(trial):
            name, base = trial.names[-1], step.base.fit
            tell(f"asking what scatter alone would gain of {name}")
            step.waves[name] = refitted(
                bench, base, step.screen, name, seed, base if is_usual(base) else trial.fit, workers
            )
        if step.passes(trial) and _stands_beside_waves(bench, step, trial):
            return trial
    return None


def _stands_beside_waves(bench: Bench, step: SearchStep, trial: Trial) -> bool:
    """
    Whether what is no wave passes its gate beside one that explains more, too, if there is one that did not pass.

    Scatter may make such a wave. What is no better than that is no finding, unless it says something else.
    """
    waves = [t for t in step.trials if t.comes_and_goes and t.whole() < trial.whole()]
    if trial.comes_and_goes or not waves:
        return True
    wave = min(waves, key=Trial.whole)
    both = fitted_beside(bench, wave, trial.terms[-1])
    return both is not None and both.over(wave) > step.gate.threshold


def _leader(step: SearchStep) -> Trial:
    """The best of what does not come and go, or of what it stands beside."""
    return min([step.base, *(t for t in step.trials if not t.comes_and_goes)], key=Trial.worth)


def told_by_sizes(trial: Trial) -> float:
    """
    Return what the sizes of its last effect, its shape as found, are worth by their own errors, their price paid.

    A fall of the deviance that they do not tell is what the fit without the effect was short of. The shape is held, as
    both may be known only together: of a peak narrower than the readings tell, height times width is. Of an effect
    that is one time alone, as a lag, that is the size. Of a contact that yields, which is nothing at no number, and of
    a user's effects without a size nothing is asked. A size that runs against its bound is none that the runs tell,
    and no wave is told whose frequency does: what acts is another, faster or slower than any that is sought.
    """
    one, fit = trial.terms[-1], trial.fit
    numbers = fit.windows.numbers
    names = {f"{one.name}.{i.name}" for i in sizes_of(one.kind)}
    own = [i for i, n in enumerate(numbers) if n.name.rpartition(".")[0] == one.name]
    sizes = np.array([numbers[i].name in names and not numbers[i].logarithmic for i in own])
    time_alone = len(own) == 1 and not isinstance(one.kind, RivalKind)
    if fit.solution is None or not (sizes.any() or time_alone):
        return math.inf
    often = f"{one.name}.{one.kind.wave.parameter}" if one.kind.wave else ""
    asked = [i for i, size in zip(own, sizes, strict=True) if size or numbers[i].name == often]
    if not one.kind.nameless and any(_at_bound(numbers[i], float(fit.at[i])) for i in asked):
        return -math.inf
    covariance = fit.solution.covariance[np.ix_(own, own)]
    price = math.log(len(fit.own))
    if not sizes.any():  # to first order its share of itself is known as well as its logarithm
        alone = 1.0 if numbers[own[0]].logarithmic else float(fit.at[own[0]])
        return alone**2 / float(covariance[0, 0]) - price
    size = fit.at[own][sizes]
    precision = np.linalg.inv(covariance)[np.ix_(sizes, sizes)]
    return float(size @ precision @ size) - len(size) * price


def _at_bound(number: SharedNumber, at: float) -> bool:
    """Whether a size, or how often a wave comes, is as large or as small as it may be; a size of 0 is none."""
    ends = (number.low, number.high)
    return any(math.isfinite(end) and (end != 0 or number.logarithmic) and at == end for end in ends)


def with_wrong_constant(bench: Bench, known: Uncertainty, null: Trial, chosen: Trial) -> Trial:
    """What was chosen, or a declared constant that is wrong in its place or beside it."""
    rivals = [chosen]
    for one in (null, chosen) if chosen.terms else (chosen,):
        # no model of the windows: its constants move with what is lacking
        if beyond_shown(one.fit) or not explained(one.fit):
            continue
        every = freed(bench, one.fit, known)
        if every and every[0].beyond:
            first = replace(every[0], rivals=tuple(every[1:]))
            rivals.append(with_freed(bench, known, one, first))
    return min(rivals, key=Trial.strict)


def with_freed(bench: Bench, known: Uncertainty, trial: Trial, wrong: Freed) -> Trial:
    """Return a hypothesis fitted with one constant free; itself if that constant is as declared after all."""
    free = replace(bench, declared=wrong.declared)
    first = replace(trial.fit, windows=free.windows(trial.terms))
    fit = from_near(bench, first)
    if fit is None:
        return trial
    # what the readings say of it where it is free
    again = next((one for one in freed(bench, fit, known) if one.name == wrong.name), wrong)
    terms = terms_at(trial.terms, fit.windows, fit.at)
    found = replace(again, gain=wrong.gain, rivals=wrong.rivals)
    return Trial(terms, fit, trial.known, found) if again.beyond else trial


def _forward(
    bench: Bench,
    base: Trial,
    tell: Callable[[str], None],
    seed: int,
    workers: Workers,
    scored: Screen | None = None,
    before: Sequence[SearchStep] = (),
) -> tuple[SearchStep, Trial]:
    """
    Score and fit what could stand beside a hypothesis; the hypothesis, as it stands best, is the second.

    What is `scored` beside it already is not scored again; `before` are the steps that led there.
    """
    trials: list[Trial] = []
    for turn in range(2):
        screen = _scored(bench, base, tell, workers) if scored is None or turn else scored
        worthy = worth_fitting(bench, base, screen)
        tell(f"fitting {', '.join(one.term.name for one in worthy)}")
        fits, done = all_full(bench, base, worthy, workers)
        if others := _of_another_kind(bench, [base, *fits], screen, before):
            tell(f"fitting {', '.join(one.term.name for one in others)}")
            more, failed = all_full(bench, base, others, workers, fits)
            fits, done = [*fits, *more], (*done, *failed)
        trials = _every([*leader_anew(bench, base, fits, workers, done), *trials])
        # where to stand, a wave shows as well as any: what of its gain is no finding is of no matter here
        again = again_from(bench, base, min(trials, key=lambda one: one.fit.deviance)) if trials else base
        fell = base.fit.deviance - again.fit.deviance
        least = min((t.fit.deviance for t in trials), default=np.inf)
        stuck = fell > bench.policy.noticed and fell > bench.policy.stuck * (base.fit.deviance - least)
        if fell > 0:
            base, trials = again, held_against(bench, again, trials)
        if not stuck or turn:
            break
    tell("asking what scatter alone would gain")
    step = SearchStep(base, screen, trials, SearchGate(np.zeros(0), math.inf))
    best = _leader(step)
    if swollen(base.fit) and is_usual(best.fit):
        # what scatter would do to motions that are not those of the readings, nobody asks
        step.beside = _scored(bench, best, tell, workers)
        step.gate = gate(bench, best.fit, step.beside, seed, best.fit)
    else:
        # what a rival lacks, too, may swell its scatter: records of that show anything
        like = base.fit if swollen(best.fit) and not swollen(base.fit) else best.fit
        step.gate = gate(bench, base.fit, screen, seed, like)
    return step, base


def is_usual(fit: Fit) -> bool:
    """Return whether a fit is a model of its windows, with no more scatter than friction has."""
    return explained(fit) and not swollen(fit)


def _scored(bench: Bench, base: Trial, tell: Callable[[str], None], workers: Workers) -> Screen:
    tell("scoring every effect" + (f" beside {' and '.join(base.names)}" if base.terms else ""))
    return screened(bench, base.fit, base.terms, workers)


def worth_fitting(bench: Bench, base: Trial, screen: Screen) -> list[Candidate]:
    """
    What is fitted in full: what may pay, the best of all in any case.

    A wave pays its price once more at its own gate (`refitted`), which asks a score: beside a model of the windows one
    that does not gain as much by its score cannot pass. There a curve that no one declared must promise more than what
    goes unnoticed, too.
    """
    count, usual = len(bench.stretches), is_usual(base.fit)

    def idle(one: Candidate) -> bool:
        kind = one.term.kind
        if kind.nameless:
            return one.worth(count) <= bench.policy.noticed
        return kind.wave is not None and one.gain <= 2 * one.price(count)

    ranked = [one for one in screen.ranked if not (usual and idle(one))][: bench.policy.fullest]
    first = next((i for i, one in enumerate(ranked) if one.worth(count) <= 0), len(ranked))
    return ranked[: max(first, 1)]


def _of_another_kind(
    bench: Bench, tried: Sequence[Trial], screen: Screen, before: Sequence[SearchStep]
) -> list[Candidate]:
    """
    Contacts that no score reaches: where nothing tried is a model of the windows they are fitted all the same.

    What gained nothing so in a step before is not.
    """
    if any(explained(one.fit) for one in tried):
        return []
    idle = {t.names[-1] for step in before for t in step.trials if step.gained(t) <= 0}
    rest = screen.ranked[bench.policy.fullest :]
    return [c for c in rest if c.term.kind.anywhere.bristle is not None and c.term.name not in idle]


def _every(trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials, of those with the same effects the best: what was fitted from another null stays a rival."""
    best: dict[tuple[str, ...], Trial] = {}
    for one in trials:
        if one.names not in best or one.deviance < best[one.names].deviance:
            best[one.names] = one
    return list(best.values())


def _back(bench: Bench, chosen: Trial, out: Searched, tell: Callable[[str], None], workers: Workers) -> Trial:
    """The hypothesis less what it does not need."""
    while len(chosen.terms) > 1:
        tell(f"once more without {' or '.join(chosen.names)}")
        less = workers.map(partial(without, bench, chosen), range(len(chosen.terms)))
        tried = [*out.trials, *(step.base for step in out.steps)]
        # a fit that begins beside the effect that it is to do without may go astray: what was fitted before is as good
        every = {
            name: [*([] if one is None else [one]), *_alike({*chosen.names} - {name}, tried)]
            for name, one in zip(chosen.names, less, strict=True)
        }
        out.without = rivals = {
            name: min(some, key=lambda t: t.deviance) for name, some in every.items() if some
        }
        if not rivals:
            break
        best = min(rivals.values(), key=Trial.worth)
        if chosen.over(best) > out.steps[-1].gate.threshold:
            break
        chosen = _refitted(bench, best)
    return chosen


def _alike(names: Collection[str], tried: Sequence[Trial]) -> list[Trial]:
    """What was tried with these effects."""
    return [t for t in tried if t.freed is None and sorted(t.names) == sorted(names)]


def _refitted(bench: Bench, trial: Trial) -> Trial:
    """What is left, or the same fitted from the readings: it was begun beside an effect that it does not need."""
    fit = anew(bench, begun(trial.fit.windows))
    if fit is not None and fit.deviance < trial.fit.deviance:
        return replace(trial, fit=fit, terms=terms_at(trial.terms, fit.windows, fit.at))
    return trial


def without(bench: Bench, trial: Trial, index: int) -> Trial | None:
    """Return a hypothesis without one of its effects, None where no window can be simulated without it."""
    terms = tuple(one for i, one in enumerate(trial.terms) if i != index)
    windows = bench.windows(terms)
    gone = trial.terms[index].name + "."
    kept = [i for i, n in enumerate(trial.fit.windows.numbers) if not n.name.startswith(gone)]
    own = own_in(trial.fit.own, trial.fit.windows, windows)
    fit = from_near(bench, replace(trial.fit, windows=windows, at=trial.fit.at[kept], own=own))
    return None if fit is None else Trial(terms_at(terms, windows, fit.at), fit, trial.known)
