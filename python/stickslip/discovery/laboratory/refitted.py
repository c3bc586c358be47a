"""The gate of a wave: what one gains of records that all the scatter of the hypothesis makes, each fitted anew.

A wave takes from scatter what is a wave of it, so that the gain of the readings is had with scatter estimated anew,
beside the wave and without it. So is that of each record here: a field along the belt gives much to a wave, too.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.laboratory.gate import SearchGate, quantile, records
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.null import Null
from stickslip.discovery.laboratory.screen import Screen
from stickslip.discovery.laboratory.waves import Waves
from stickslip.discovery.workers import ALONE, Workers
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.memory import BELT, KINETIC, STATIC, memory
from stickslip.likelihoods.score import TURNS, beside, plain
from stickslip.likelihoods.variances import estimate

Floats = NDArray[np.float64]
RECORDS = 30  # of the draws, as each is fitted twice; waves that act gain five times the gate and more


def refitted(
    bench: Bench, fit: Fit, screen: Screen, name: str, seed: int, best: Fit, workers: Workers = ALONE
) -> SearchGate:
    """
    Return the gate of a wave beside a hypothesis, and what it gains of the readings by the same measure.

    Parameters
    ----------
    bench, fit, screen : the hypothesis, and what was scored beside it
    name : of the wave
    seed : of the draws
    best : the fit whose scatter, noise and memory of events the records have: all that the hypothesis has, for a field
        along the belt is a model of the windows; that beside the wave where the hypothesis is no model of them
    workers : take the records between them
    """
    fit = replace(fit, population=best.population, noise=best.noise)
    null, waves = Null(fit), screen.wave(name)
    like = tuple(memory(best, k) for k in (KINETIC, STATIC, BELT))
    drawn = records(bench, fit, null, screen, like, np.random.default_rng(seed))
    every = [None if one is None else one[:, :RECORDS] for one in drawn]
    price = waves.count * math.log(len(bench.stretches))
    often = waves.often(null, every, null.shared_pull(every, RECORDS))
    of_record = partial(_gained_of, bench, fit, every, waves)
    draws = np.array(workers.map(of_record, enumerate(often.tolist()))) - price
    away, _ = fit.windows.prior.at(fit.at)
    observed = _gained(bench, _reading(fit, null.rights, 0), waves, waves.best(null), away) - price
    # how friction is alike along the belt a fit tells poorly: a wave pays for its numbers once more
    return SearchGate(
        draws, max(quantile(draws, bench.policy.false_alarm / screen.gates), 0.0) + price, observed
    )


def _reading(fit: Fit, every: list[Floats | None], record: int) -> Fit:
    """The fit's windows with a record in the place of the readings, which nothing of its own explains yet."""
    assert fit.linear is not None
    blocks: list[Floats | None] = []
    for block, one, weight in zip(fit.blocks, every, fit.linear.weight, strict=True):
        if block is None or one is None:
            blocks.append(None)
            continue
        left = one[:, record].reshape(block.shape[:2]) * np.sqrt(fit.noise / weight)
        blocks.append(np.concatenate([block[:, :, :-1], left[:, :, None]], axis=2))
    return replace(fit, blocks=blocks, own=np.zeros_like(fit.own))


def _gained_of(
    bench: Bench, fit: Fit, every: list[Floats | None], waves: Waves, one: tuple[int, float]
) -> float:
    """What the wave gains of a record, by its number and the frequency that it is sought at."""
    record, w = one
    return _gained(bench, _reading(fit, every, record), waves, w, np.zeros(len(fit.at)))


def _gained(bench: Bench, fit: Fit, waves: Waves, w: float, away: Floats) -> float:
    """What a wave gains, scatter estimated with it and without it; `away` is how far the prior's centre lies."""
    runs, p, policy = len(bench.data), len(fit.at), bench.policy
    k, place = 2 * runs, [[2 * s.run, 2 * s.run + 1] for s in bench.stretches]
    both = beside(fit, waves.at(w), place, k)
    _, held = fit.windows.prior.at(fit.at)
    wide = np.zeros((p + k, p + k))
    wide[:p, :p] = held
    low, high = fit.windows.steps(fit.at)
    wider = np.pad(low, (0, k), constant_values=-np.inf), np.pad(high, (0, k), constant_values=np.inf)
    places, start = fit.windows.places, (fit.population, fit.noise)
    there = estimate(both, places, *start, (np.pad(away, (0, k)), wide), fit.random, policy, TURNS, wider)
    alone = plain(both, p, k)
    without = estimate(alone, places, *start, (away, held), fit.random, policy, TURNS, (low, high))
    return without.deviance - there.deviance
