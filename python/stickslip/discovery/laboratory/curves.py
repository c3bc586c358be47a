"""The best curves that no name explains, and what the best of all gains where nothing is lacking."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stickslip.discovery.laboratory.gate import gate
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.screen import Screen, Shapes
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.fit_state import Fit


def leading(
    bench: Bench,
    beside: Trial,
    best: Fit,
    seed: int,
    workers: Workers = ALONE,
    least: float = 0.0,
    names: float = 0.0,
    every: Sequence[ScoredCurve] | None = None,
) -> list[ScoredCurve]:
    """
    Return the best curves beside a hypothesis, best first, with the gate that draws set for all curves.

    Events that remember each other make a curve in t, friction that differs along the belt one in x1: curves are many,
    and none of the names that the other gate is drawn for is as free. What passes as a curve passes that gate, too.

    Parameters
    ----------
    bench, beside : the hypothesis
    best : the fit whose scatter is drawn
    seed : of the draws
    workers : score them
    least : what a curve is worth at least; without one no gate is drawn
    names : the gate of names beside the hypothesis
    every : the curves beside it, if they are scored already
    """
    fit, count = beside.fit, len(bench.stretches)
    if every is None:
        every = bench.curves(fit, beside.terms, workers)
    worthy = [one for one in every if one.worth(count) > least]
    if not worthy:
        return []
    threshold = max(drawn(bench, fit, best, every, seed), names)
    told = [replace(one, threshold=threshold) for one in worthy if one.worth(count) > threshold]
    return sorted(told, key=lambda one: -one.worth(count))[: bench.policy.fullest]


def drawn(bench: Bench, fit: Fit, best: Fit, every: Sequence[ScoredCurve], seed: int) -> float:
    """Return what the best of these curves gains, prices paid, in one of `1/false_alarm` records that lack nothing."""
    screen = Screen((), tuple(Shapes(one.count, (one.columns,)) for one in every))
    return gate(bench, fit, screen, seed, best, tight=True).threshold
