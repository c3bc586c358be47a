"""What the windows of a case say: names that stand, and curves that no name explains."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.laboratory.curves import leading
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.learned import Learned
from stickslip.discovery.laboratory.proven import proven
from stickslip.discovery.laboratory.search import Searched, Trial, search
from stickslip.likelihoods.repeating import lost

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


def searched(
    bench: BenchT, known: Uncertainty, tell: Callable[[str], None], seed: int, base: Trial | None = None
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
    """
    found = search(bench, known, tell, seed, base)
    tell("looking for a curve that no name explains")
    alone = _curve(bench, found, seed)
    if alone is not None:
        return Verdicts(bench, found, alone)
    left = _left_over(bench, found, seed)
    return Verdicts(bench, found, left, left is not None)


def _curve(bench: Bench, found: Searched, seed: int) -> Learned | None:
    """The curve that explains more than every name does, its shapes paid for."""
    count = len(bench.stretches)
    null = found.null
    best = leading(bench, null.fit, found.chosen.fit, seed)
    # as explanations they are held against each other whole: what of a wave scatter has too is the gate's question
    # names beside which friction scatters without bound explain nothing
    chosen = found.chosen
    named = 0.0 if lost(chosen.fit) else null.whole() - chosen.whole()
    return _proven(bench, null, best) if best.worth(count) > max(best.threshold, named) else None


def _left_over(bench: Bench, found: Searched, seed: int) -> Learned | None:
    """
    The curve beside the names found that passes the gate: what acts is then not what they say.

    One that is next to nothing beside what they explain is what the model of the measurement is short of. Where
    friction beside the names neither differs nor is bent, they leave nothing that acts.
    """
    null, chosen = found.null, found.chosen
    scatter = chosen.fit.population
    if not chosen.terms or max(scatter.level, scatter.curve) < bench.policy.repeats:
        return None
    left = _proven(bench, chosen, leading(bench, chosen.fit, chosen.fit, seed))
    if left is None or left.gain < bench.policy.stands_in**2 * (null.fit.deviance - chosen.fit.deviance):
        return None
    return left


def _proven(bench: Bench, beside: Trial, best: Learned) -> Learned | None:
    """A curve that passes its gate, as scored and with all else fitted beside it; a fit that fails proves nothing."""
    count = len(bench.stretches)
    if best.worth(count) <= best.threshold:
        return None
    try:
        gain = proven(bench, beside.fit, beside.terms, best)
    except FloatingPointError:
        return None
    return best if replace(best, gain=gain).worth(count) > best.threshold else None
