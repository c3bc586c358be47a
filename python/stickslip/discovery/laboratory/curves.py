"""The best curve that no name explains, and what the best of all curves gains where nothing is lacking."""

from __future__ import annotations

from dataclasses import replace

from stickslip.discovery.laboratory.gate import gate
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.learned import Learned
from stickslip.discovery.laboratory.screen import Screen, Shapes
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.fit_state import Fit


def leading(bench: Bench, fit: Fit, best: Fit, seed: int, workers: Workers = ALONE) -> Learned:
    """
    Return the best curve beside a hypothesis, with the gate that draws set for all curves.

    Events that remember each other make a curve in t, friction that differs along the belt one in x1: curves are many,
    and none of the names that the other gate is drawn for is as free.

    Parameters
    ----------
    bench, fit : the hypothesis
    best : the fit whose scatter is drawn
    seed : of the draws
    workers : score them
    """
    every, count = bench.curves(fit, workers), len(bench.stretches)
    screen = Screen((), tuple(Shapes(one.count, (one.columns,)) for one in every))
    threshold = gate(bench, fit, screen, seed, best, tight=True).threshold
    return replace(max(every, key=lambda one: one.worth(count)), threshold=threshold)
