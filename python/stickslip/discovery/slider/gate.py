"""The gate: what the process noise alone gains, over all candidates, in simulated tables of events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.slider.candidates import Declared, candidates
from stickslip.discovery.slider.population import Block, estimated
from stickslip.discovery.slider.weigh import ranked, whitened

Floats = NDArray[np.float64]
DRAWS = 100
LEVEL = 0.02  # how often the process noise alone may pass
LEAST = 16.0  # score asked for even where the draws stay lower: whole records have heavier tails than their tables


@dataclass(frozen=True)
class Null:
    """Largest scores of `DRAWS` tables without any effect, sorted, and the threshold."""

    draws: Floats
    threshold: float


def null(blocks: Sequence[Block], declared: Declared, seed: int, draws: int = DRAWS) -> Null:
    """Draw tables from the process noise found, estimate it afresh in each, and take the best candidate's score."""
    rng = np.random.default_rng(seed)
    scores = np.zeros(draws)
    for i in range(draws):
        drawn = [_drawn(one, rng) for one in blocks]
        white = whitened(drawn)
        best = ranked(white, list(candidates(drawn, declared)))
        scores[i] = max(best[0].score, 0.0) if best else 0.0
    scores.sort()
    top = float(np.quantile(scores, 1 - LEVEL)) if draws else 0.0
    return Null(scores, max(LEAST, top))


def _drawn(block: Block, rng: np.random.Generator) -> Block:
    if not len(block):
        return block
    y = block.drawn(rng)
    if block.name != "level":
        return estimated(replace(block, y=y))
    x, load = np.empty_like(block.x), np.empty_like(block.x)
    dwell = block.dwell.copy()
    for run in np.unique(block.run):
        at = np.flatnonzero(block.run == run)
        mean = float(block.load[at].mean())
        carried = float((block.load - block.x)[at[0]])
        load[at] = mean * (1 + y[at])
        x[at] = load[at] - carried
        fall = block.fall[at][rng.integers(0, len(at), len(at))]
        climbed = x[at][1:] - (x[at][:-1] - fall[:-1])
        rise = np.maximum(climbed, 0.02 * float(np.median(block.fall[at])))
        dwell[at[1:]] = rise / block.speed[at[1:]]
        y[at] = load[at] / float(load[at].mean()) - 1
    return estimated(replace(block, y=y, x=x, load=load, dwell=dwell))
