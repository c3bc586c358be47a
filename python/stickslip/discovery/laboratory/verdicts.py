"""What the windows of a case say: names that stand, and curves that no name explains."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic, TypeVar

import numpy as np

from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.laboratory import outcome
from stickslip.discovery.laboratory.curves import leading
from stickslip.discovery.laboratory.fewer import beside_others, fewer
from stickslip.discovery.laboratory.hum import humming
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.left import Left
from stickslip.discovery.laboratory.proven import proven
from stickslip.discovery.laboratory.search import Searched, SearchStep, search
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.rig_numbers import BEYOND
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.fit import closed, fitted, null
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.repeating import lost, unlike, wild
from stickslip.likelihoods.shared import Declared

BenchT = TypeVar("BenchT", bound=Bench)
_Told = tuple[ScoredCurve, Trial]  # a curve, and the hypothesis with it


@dataclass(frozen=True)
class Verdicts(Generic[BenchT]):
    """
    What was searched.

    Parameters
    ----------
    bench, searched : the case, and all that was tried
    curve : what no name explains, None if there is nothing
    after : the hypothesis that explains the windows, the curve in it
    beside : whether the curve is what the names found leave over: they only stand in for what acts
    """

    bench: BenchT
    searched: Searched
    curve: ScoredCurve | None
    after: Trial
    beside: bool = False

    @property
    def fit(self) -> Fit:
        """The fit that explains the windows."""
        return self.after.fit

    @property
    def told(self) -> Trial:
        """What the model after has: names that stand, or stand in, and a curve, but for one of the belt."""
        found = self.searched
        if self.curve is not None and self.curve.effect is not None:
            return self.after
        return found.null if self.curve is not None and not self.beside else found.chosen

    def before(self, workers: Workers = ALONE) -> Trial:
        """
        Return the declared model alone; all of it as declared where a constant is wrong: others may do its work.

        So is it where what is lacking has driven a constant of the law alone far from what is declared. What is fitted
        then the `workers` fit from several starts at once.
        """
        null_fit = self.searched.null.fit
        astray = bool(self.told.terms) and null_fit.windows.prior.farthest(null_fit.at) > BEYOND
        if self.told.freed is None and not astray:
            return self.searched.null
        plain = replace(self.bench, declared=Declared())
        return Trial((), null(plain.windows(), plain.policy, twice=True, each=workers.map))

    def without(self, before: Trial) -> Fit | None:
        """Return what is held against what was found on runs never used: effects, all else as free as beside them."""
        if self.told.terms:
            return self.searched.null.fit
        return before.fit if self.told.freed is not None else None

    def spare(self) -> float | None:
        """Return by how much what is told passes its gate; None where that has none, as a wrong constant alone."""
        if not self.told.terms:
            return None
        if self.curve is not None:
            return max(self.curve.worth(len(self.bench.stretches)) - self.curve.threshold, 0.0)
        gate = outcome.gate(self.searched)
        return max(gate.observed - gate.threshold, 0.0)

    def beside_others(self) -> dict[str, tuple[Fit, float]]:
        """Return the fit without each of several names, and by how much that one passes its gate; none with a curve."""
        if self.curve is not None:
            return {}
        return {name: (one.fit, spare) for name, (one, spare) in beside_others(self.searched).items()}

    def fewer(self) -> Iterator[Verdicts[BenchT]]:
        """Yield the same with fewer names told, the best first: without a curve beside them, then some of them."""
        alone = replace(self, curve=None, after=self.searched.chosen, beside=False)
        if self.curve is None or self.beside:
            if self.beside:
                yield alone
            for found in fewer(self.searched):
                yield replace(alone, searched=found, after=found.chosen)

    def silent(self) -> Verdicts[BenchT]:
        """Return the same with nothing told."""
        found = replace(self.searched, chosen=self.searched.null)
        return replace(self, searched=found, curve=None, after=found.null, beside=False)


def searched(
    bench: BenchT,
    known: Uncertainty,
    tell: Callable[[str], None],
    seed: int,
    base: Trial | None = None,
    workers: Workers = ALONE,
) -> Verdicts[BenchT]:
    """
    Return what the train runs say.

    Parameters
    ----------
    bench : the declared model, the runs and their windows
    known : how well its constants are known
    tell : told what is being done
    seed : of the gate's draws
    base : the declared model as fitted; None: it is fitted first
    workers : do what does not wait for one another
    """
    if base is None:
        tell("fitting the declared law, its constants and its scatter")
        base = Trial((), null(bench.windows(), bench.policy, twice=True, each=workers.map))
    bench = bench.timed(base.fit)
    there = closed(replace(base.fit, windows=bench.windows()), bench.policy)
    found = search(bench, known, tell, seed, replace(base, fit=there), workers)
    if (
        found.chosen.terms
        and wild(found.chosen.fit)
        and (alike := bench.less(unlike(found.chosen.fit))) is not bench
    ):
        tell("windows stand out from what was found: once more without them")
        bench = alike
        found = search(bench, known, tell, seed, workers=workers)
    tell("looking for a curve that no name explains")
    chosen = found.chosen
    over = bench.curves(chosen.fit, chosen.terms, workers) if chosen.terms else ()
    left = left_over(bench, found, seed, workers, over)
    alone = curve_alone(bench, found, seed, workers, more_than_names(bench, chosen, left), over)
    if alone is not None:
        return Verdicts(bench, found, *alone)
    if left is not None:
        return Verdicts(bench, found, *left, beside=True)
    return Verdicts(bench, found, None, chosen)


def more_than_names(bench: Bench, chosen: Trial, left: _Told | None) -> float:
    """
    Return by how much more than the names a curve must explain that does without them.

    Names that leave nothing over fall only to what explains the runs better than they do by more than a little. One
    cause is likelier than several: each further name must be worth that much beside a curve.

    Parameters
    ----------
    bench, chosen : the case, and the hypothesis with the names
    left : the curve that they leave over; None where they leave nothing
    """
    stand = bool(chosen.terms) and left is None and not lost(chosen.fit)
    return bench.policy.noticed * (stand - max(len(chosen.terms) - 1, 0))


def beside_a_hum(verdicts: Verdicts[BenchT], left: Left) -> Verdicts[BenchT]:
    """
    Return the same, or a hum of a sensor where that explains more than all names do.

    Parameters
    ----------
    verdicts : what was searched
    left : what the declared model alone leaves
    """
    found, count = verdicts.searched, len(verdicts.bench.stretches)
    hum = humming(left)
    if hum is None or hum.worth(count) <= found.null.independent() - found.chosen.independent():
        return verdicts
    least = found.steps[0].gate.threshold
    return replace(verdicts, curve=replace(hum, threshold=least), after=found.null, beside=False)


def curve_alone(
    bench: Bench,
    found: Searched,
    seed: int,
    workers: Workers = ALONE,
    more: float = 0.0,
    over: Sequence[ScoredCurve] = (),
) -> _Told | None:
    """
    The curve that explains more than every name does, its shapes paid for; by so much `more`.

    The names with a curve beside them explain what the curve does alone. One that gains less than `more` beside names
    that stand, as scored among those `over`, is not fitted.
    """
    alone, chosen = found.null, found.chosen
    # as explanations they are held against each other whole: what of a wave scatter has too is the gate's question
    # names beside which friction scatters without bound explain nothing
    named = 0.0 if lost(chosen.fit) else alone.whole() - chosen.whole()
    least = max(named + more, 0.0)
    promised = least if more else 0.0  # names that stand are not doubted where no curve promises more
    every = leading(bench, alone, chosen.fit, seed, workers, promised, gate_of(found.steps[:1]))
    beside = {(one.where, one.variable): one.gain for one in over if more}
    every = [one for one in every if beside.get((one.where, one.variable), math.inf) > more]
    return _proven(bench, alone, every, workers, least)


def left_over(
    bench: Bench,
    found: Searched,
    seed: int,
    workers: Workers = ALONE,
    over: Sequence[ScoredCurve] | None = None,
) -> _Told | None:
    """
    The curve beside the names found that passes the gate: what acts is then not what they say.

    One that is next to nothing beside what they explain is what the model of the measurement is short of. `over` are
    the curves beside the names, if they are scored already.
    """
    chosen = found.chosen
    if not chosen.terms:
        return None
    # names that passed are not doubted for less
    gate = gate_of(found.steps) + bench.policy.noticed
    every = leading(bench, chosen, chosen.fit, seed, workers, names=gate, every=over)
    left = _proven(bench, chosen, every, workers)
    if left is None or left[0].gain < bench.policy.stands_in**2 * explained_by_names(bench, found):
        return None
    return left


def gate_of(steps: Sequence[SearchStep]) -> float:
    """Return the gate of names of the last of these steps."""
    return steps[-1].gate.threshold if steps else 0.0


def explained_by_names(bench: Bench, found: Searched) -> float:
    """
    Return what the names explain: how much worse the law alone does where friction scatters as it does beside them.

    With a scatter of its own the law alone passes most of what it lacks off as that.
    """
    chosen, policy = found.chosen.fit, bench.policy
    alone = replace(found.null.fit, population=chosen.population, noise=chosen.noise)
    return fitted(alone, policy, held=policy.most_steps).deviance - chosen.deviance


def _proven(
    bench: Bench, beside: Trial, every: Sequence[ScoredCurve], workers: Workers = ALONE, least: float = 0.0
) -> _Told | None:
    """
    The best curve that passes its gate, as scored and with all else fitted beside it; a fit that fails proves nothing.

    It is worth `least` at least.
    """
    count, found = len(bench.stretches), list[tuple[float, _Told]]()
    shown_all = workers.ahead(partial(_shown, bench, beside), every)
    for one in every:
        if found and max(worth for worth, _ in found) > one.worth(count):
            break  # none of the others promises as much
        told = next(shown_all)
        if told is None or lost(told[1].fit):  # as of names: beside what explains them windows are not lost
            continue
        shown, there = told
        if (worth := shown.worth(count)) > least and shown.passes(count):
            found.append((worth, (shown, there)))
    return max(found, key=lambda each: each[0])[1] if found else None


def _shown(bench: Bench, beside: Trial, one: ScoredCurve) -> _Told | None:
    """A curve with all else fitted beside it; None where that fails."""
    with suppress(FloatingPointError, np.linalg.LinAlgError):
        return proven(bench, beside, one)
    return None
