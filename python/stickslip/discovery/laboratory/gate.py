"""The gate: what scatter, wobble and noise alone would gain, drawn from the fitted hypothesis (a parametric bootstrap).

Draws are of the linearised windows. Friction that differs along the belt is drawn as one field along a run, what
differs from event to event with the correlation that the fit shows from one event to the next, and the belt's wobble
as slow waves in time, or slower than events by as much as their belts are alike: the windows of the fit are
independent, and all of it may look like an effect.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.null import Null
from stickslip.discovery.laboratory.screen import Screen
from stickslip.discovery.laboratory.waves import WaveColumns
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.memory import BELT, KINETIC, MOST, STATIC, memory

Floats = NDArray[np.float64]
GUMBEL = 0.5772156649  # Euler's constant


@dataclass(frozen=True)
class SearchGate:
    """
    The largest gains, prices paid, that draws from a hypothesis that lacks nothing show.

    Parameters
    ----------
    draws : (n,) largest gain of any effect; below 0 where none is worth its price
    threshold : what is exceeded by one of `1/false_alarm` such records, all gates of a step together
    observed : what the readings gain by the same measure; that of a trial is its own
    """

    draws: Floats
    threshold: float
    observed: float = math.nan


def gate(bench: Bench, fit: Fit, screen: Screen, seed: int, best: Fit, tight: bool = False) -> SearchGate:
    """
    Return the gate of a fitted hypothesis.

    Parameters
    ----------
    bench, fit, screen : the hypothesis, and what was scored beside it
    seed : of the draws
    best : the fit whose scatter, noise and memory of events the records have. What a hypothesis lacks swells its own,
        and a drift that is lacking looks like memory: they are those of its best rival
    tight : whether the constants stay where they are while the columns are scored
    """
    rng = np.random.default_rng(seed)
    like = tuple(memory(best, k) for k in (KINETIC, STATIC, BELT))
    fit = replace(fit, population=best.population, noise=best.noise)
    null = Null(fit, tight)
    drawn = records(bench, fit, null, screen, like, rng)
    shared = null.shared_pull(drawn, bench.policy.draws)
    count, most = len(bench.stretches), np.full(bench.policy.draws, -np.inf)
    for one in screen.shapes:
        most = np.maximum(most, one.gains(null, drawn, shared) - one.count * math.log(count))
    return SearchGate(most, max(quantile(most, bench.policy.false_alarm / screen.gates), 0.0))


def quantile(best: Floats, probability: float) -> float:
    """Return a quantile beyond what so few draws show, from the extreme-value distribution through their moments."""
    scale = float(np.std(best)) * math.sqrt(6.0) / math.pi
    place = float(np.mean(best)) - GUMBEL * scale
    return place - scale * math.log(-math.log1p(-probability))


def records(
    bench: Bench,
    fit: Fit,
    null: Null,
    screen: Screen,
    like: Sequence[tuple[float, float]],
    rng: np.random.Generator,
) -> list[Floats | None]:
    """
    Return readings of each window less the model's, (rows, draws), as they would be if nothing were lacking.

    Parameters
    ----------
    bench, fit, null, screen : the hypothesis, whose scatter and noise they have, and what was scored beside it
    like : correlation from one event to the next and its error, of kinetic and of static friction, and of the belt
    rng : of the draws
    """
    draws = bench.policy.draws
    waves = _wobble(bench, screen, rng, bench.wobble(fit.population))
    alone = _astray(null, waves)
    # the fit tells a correlation poorly: every draw has one that may be the true one
    (apart,) = rng.spawn(1)  # so that what is drawn of friction is the same for belts of any memory
    *correlations, slow = (
        np.clip(found + error * r.standard_normal(draws), 0.0, MOST)
        for (found, error), r in zip(like, (rng, rng, apart), strict=True)
    )
    effects = bench.drawn(fit, correlations, rng, belt=alone)
    if (place := fit.windows.belt) is not None:
        effects[:, place] = np.sqrt(1 - slow) * effects[:, place] + wandering_belt(fit, slow, apart)
    out: list[Floats | None] = []
    for i, row in enumerate(null.rows):
        if row is None:
            out.append(None)
            continue
        n = row.local.shape[0]
        made = rng.standard_normal((n, draws)) + row.effects @ effects[i]
        for w, amplitudes in () if alone[i] else waves:
            column = w.columns[i]
            if column is not None:
                made += null.over_noise(column, i) @ (amplitudes[bench.stretches[i].run] * np.sqrt(1 - slow))
        out.append(made)
    return out


def chain(n: int, like: Floats, rng: np.random.Generator) -> Floats:
    """Return stationary chains of unit variance, one a correlation, (n, draws)."""
    out = rng.standard_normal((n, len(like)))
    for j in range(1, n):
        out[j] = like * out[j - 1] + np.sqrt(1 - like**2) * out[j]
    return out


def wandering_belt(fit: Fit, slow: Floats, rng: np.random.Generator) -> Floats:
    """
    Return speeds of the belt that hardly change from one event to the next, (w, draws).

    Waves within events are not alike from one to the next: as far as the belts of events are, they wander slower.

    Parameters
    ----------
    fit : whose belt it is
    slow : (draws,) share of the belt's variance
    rng : of the draws
    """
    out = np.zeros((len(fit.own), len(slow)))
    for members in fit.windows.by_run:
        out[members] = chain(len(members), np.full(len(slow), MOST), rng)
    return np.asarray(fit.population.belt * np.sqrt(slow) * out)


def _astray(null: Null, waves: Sequence[tuple[WaveColumns, Floats]]) -> NDArray[np.bool_]:
    """
    Return the windows that slow waves of the belt, as they are drawn, leave more of than the readings do.

    There they set off other events than those of the readings, or the motion is none of theirs: a first order says
    nothing of them, and the belt wanders by what is the window's own. It does so in all where there are no waves.
    """
    left = np.full(len(null.rows), 0.0 if waves else np.inf)
    for w, amplitudes in waves:
        left += float(np.mean(amplitudes**2)) * np.trace(null.projected(w.columns).square, axis1=1, axis2=2)
    return left > null.left


def _wobble(
    bench: Bench, screen: Screen, rng: np.random.Generator, whole: float
) -> Sequence[tuple[WaveColumns, Floats]]:
    """Slow waves of the belt, each with amplitudes (runs, 2, draws), their sum as large as the belt wobbles."""
    waves = screen.of_belt(bench.policy)
    if not waves:
        return []
    size = whole / math.sqrt(len(waves))
    shape = (len(bench.data), 2, bench.policy.draws)
    return [(w, size * rng.standard_normal(shape)) for w in waves]
