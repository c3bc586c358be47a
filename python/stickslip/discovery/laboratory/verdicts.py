"""What the windows of a case say: names that stand, and curves that no name explains."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.laboratory.curves import leading
from stickslip.discovery.laboratory.hum import humming
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.learned import Learned
from stickslip.discovery.laboratory.left import Left
from stickslip.discovery.laboratory.proven import beside as fitted_beside
from stickslip.discovery.laboratory.search import Searched, search
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.rig_numbers import BEYOND
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.fit import closed, fitted, null
from stickslip.likelihoods.remembered import remembered
from stickslip.likelihoods.repeating import lost
from stickslip.likelihoods.shared import Declared

BenchT = TypeVar("BenchT", bound=Bench)


@dataclass(frozen=True)
class Verdicts(Generic[BenchT]):
    """
    What was searched.

    Parameters
    ----------
    bench, searched : the case, and all that was tried
    curve : what no name explains, None if there is nothing
    beside : whether the curve is what the names found leave over: they only stand in for what acts
    """

    bench: BenchT
    searched: Searched
    curve: Learned | None
    beside: bool = False

    @property
    def told(self) -> Trial:
        """What the model after has: names that stand, or stand in; nothing where a curve does better than all."""
        found = self.searched
        return found.null if self.curve is not None and not self.beside else found.chosen

    @property
    def before(self) -> Trial:
        """
        The declared model alone; all of it as declared where a constant is wrong, for the others may do its work.

        So is it where what is lacking has driven a constant of the law alone far from what is declared.
        """
        null_fit = self.searched.null.fit
        astray = bool(self.told.terms) and null_fit.windows.prior.farthest(null_fit.at) > BEYOND
        if self.told.freed is None and not astray:
            return self.searched.null
        plain = replace(self.bench, declared=Declared())
        return Trial((), null(plain.windows(), plain.policy, twice=True))


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
        base = Trial((), null(bench.windows(), bench.policy, twice=True))
    bench = bench.timed(base.fit)
    there = closed(replace(base.fit, windows=bench.windows()), bench.policy)
    found = search(bench, known, tell, seed, replace(base, fit=there), workers)
    tell("looking for a curve that no name explains")
    left = _left_over(bench, found, seed, workers)
    chosen = found.chosen
    if chosen.terms and left is None and not lost(chosen.fit):  # names stand that leave nothing over
        return Verdicts(bench, found, None)
    alone = _curve(bench, found, seed, workers)
    if alone is not None:
        return Verdicts(bench, found, alone)
    return Verdicts(bench, found, left, left is not None)


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
    return replace(verdicts, curve=replace(hum, threshold=least), beside=False)


def _curve(bench: Bench, found: Searched, seed: int, workers: Workers = ALONE) -> Learned | None:
    """The curve that explains more than every name does, its shapes paid for."""
    alone, chosen = found.null, found.chosen
    best = leading(bench, alone.fit, chosen.fit, seed, workers)
    # as explanations they are held against each other whole: what of a wave scatter has too is the gate's question
    # names beside which friction scatters without bound explain nothing
    named = 0.0 if lost(chosen.fit) else alone.whole() - chosen.whole()
    return _proven(bench, alone, best, named)


def _left_over(bench: Bench, found: Searched, seed: int, workers: Workers = ALONE) -> Learned | None:
    """
    The curve beside the names found that passes the gate: what acts is then not what they say.

    One that is next to nothing beside what they explain is what the model of the measurement is short of.
    """
    chosen = found.chosen
    if not chosen.terms:
        return None
    left = _proven(bench, chosen, leading(bench, chosen.fit, chosen.fit, seed, workers))
    if left is None or left.gain < bench.policy.stands_in**2 * _explained(bench, found):
        return None
    return left


def _explained(bench: Bench, found: Searched) -> float:
    """
    Return what the names explain: how much worse the law alone does where friction scatters as it does beside them.

    With a scatter of its own the law alone passes most of what it lacks off as that.
    """
    chosen, policy = found.chosen.fit, bench.policy
    alone = replace(found.null.fit, population=chosen.population, noise=chosen.noise)
    return fitted(alone, policy, held=policy.most_steps).deviance - chosen.deviance


def _proven(bench: Bench, beside: Trial, best: Learned, least: float = 0.0) -> Learned | None:
    """
    A curve that passes its gate, as scored and with all else fitted beside it; a fit that fails proves nothing.

    What it explains is held against what events that remember explain without it, and is worth `least` at least.
    """
    count = len(bench.stretches)
    if best.worth(count) <= best.threshold:
        return None
    try:
        there = fitted_beside(bench, beside.fit, beside.terms, best)
    except FloatingPointError:
        return None
    gain = beside.fit.deviance - beside.remembered - there.deviance + remembered(there)
    return best if replace(best, gain=gain).worth(count) > max(best.threshold, least) else None
