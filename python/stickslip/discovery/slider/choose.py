"""The search: candidates join one by one while the best of them passes the gate; then the algebra of constants."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import CONSTANTS
from stickslip.discovery.slider.candidates import Candidate, Declared, candidates, waves
from stickslip.discovery.slider.gate import LEAST, Null, null
from stickslip.discovery.slider.population import Block, blocks
from stickslip.discovery.slider.weigh import (
    Weighed,
    White,
    beside_wander,
    columns_of,
    ranked,
    weigh,
    whitened,
)
from stickslip.fitted.block_events.table import Measured

Floats = NDArray[np.float64]
MOST = 4
TIED = 6.0  # difference of scores below which two rivals are not told apart: odds of 20 to 1
FEWEST = 8  # events


@dataclass(frozen=True)
class Choice:
    """What was chosen, each fitted beside the others, and every step of the search.

    `steps` holds the ranking of each step, best first, the last one being what did not pass; `ties` maps each chosen
    name to its rivals, best first, weighed in its place.
    """

    blocks: tuple[Block, ...]
    white: White
    declared: Declared
    null: Null
    chosen: tuple[Weighed, ...]
    steps: tuple[tuple[Weighed, ...], ...]
    rivals: dict[str, tuple[Weighed, ...]]

    def accepted(self, without: str = "") -> Floats:
        """Whitened columns of what was chosen, (N, q)."""
        return columns_of(self.white, [one.candidate for one in self.chosen if one.candidate.name != without])


def choose(runs: Sequence[Measured], seed: int, tell: Callable[[str], None], draws: int) -> Choice:
    """Search the events of the train runs.

    Parameters
    ----------
    runs : sequence of Measured
    seed : int
        Of the gate's draws.
    tell : callable
    draws : int
        Of the gate.
    """
    first = runs[0].run
    declared = Declared(first.rig, first.force_channel)
    tell("estimating what differs from event to event")
    made = blocks(runs)
    white = whitened(made)
    everything = list(candidates(made, declared))
    first_step = ranked(white, everything)
    tell("drawing what such process noise alone would give")
    # a score below the least that is ever asked for needs no draws to be refused
    enough = bool(first_step) and first_step[0].score >= LEAST
    gate = null(made, declared, seed, draws if enough else draws // 5)
    taken: list[Candidate] = []
    steps: list[tuple[Weighed, ...]] = []
    for _ in range(MOST + 1):
        tell("trying each effect" + "".join(f" + {one.name}" for one in taken))
        step = ranked(white, everything, taken) if taken else first_step
        steps.append(tuple(step))
        if not step or len(taken) == MOST or step[0].score < gate.threshold:
            break
        taken.append(_sharpened(white, made, step[0], taken))
    taken = _normal(everything, taken)
    chosen = tuple(_beside(white, one, taken) for one in taken)
    rivals = {
        one.name: tuple(
            w
            for w in ranked(white, everything, [other for other in taken if other is not one])
            if w.candidate.name != one.name
        )
        for one in taken
    }
    return Choice(tuple(made), white, declared, gate, chosen, tuple(steps), rivals)


def _beside(white: White, candidate: Candidate, taken: Sequence[Candidate]) -> Weighed:
    """A chosen candidate fitted beside the others."""
    others = columns_of(white, [one for one in taken if one is not candidate])
    found = weigh(white, replace(candidate, sign=0), others)
    assert found is not None  # it was accepted with a gain
    return beside_wander(white, found, [one for one in taken if one is not candidate])


def _sharpened(white: White, made: Sequence[Block], found: Weighed, taken: Sequence[Candidate]) -> Candidate:
    """A periodic candidate with its wavelength between those tried."""
    if not found.candidate.per_run:
        return found.candidate
    accepted = columns_of(white, taken)
    best = weigh(white, found.candidate, accepted) or found
    for width in (0.06, 0.02):
        centre = best.candidate.scale
        for scale in centre * np.linspace(1 - width, 1 + width, 25):
            one = weigh(white, waves(made, found.candidate.name, float(scale)), accepted)
            if one is not None and one.gain > best.gain:
                best = one
    return best.candidate


def _normal(everything: Sequence[Candidate], taken: list[Candidate]) -> list[Candidate]:
    """Two wrong constants as a gain and a mass: by algebra any two of the three do the same."""
    wrong = [one for one in taken if one.name in CONSTANTS or one.name == "contact_compliance"]
    if len(wrong) < 2:
        return taken
    pair = [next(one for one in everything if one.name == name) for name in ("sensor_gain", "rig_mass")]
    return [*pair, *(one for one in taken if one not in wrong)]
