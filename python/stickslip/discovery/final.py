"""The last fit of what was chosen: on long windows, from more than one side, to its very end."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery import unlisted
from stickslip.discovery.search import CLEAN, LONG, Search, Trial

Floats = NDArray[np.float64]
FAR_OFF = 50.0  # of CLEAN: a misfit whose numbers are not worth perfecting
FEW = 12  # steps, after which a fit that still falls is helped along
FIRST_LEAP, NEXT_LEAP, LEAST_LEAP = 32.0, 2.0, 0.5  # in ways of so many steps
FALL = 0.1  # of chi-squared, that is worth a leap
TURNS = 5  # of a valley, at most
WORSE = 1.05  # of the cost of the first fit: one that stays beyond has ended somewhere else


def final(search: Search, trial: Trial) -> Trial:
    """The trial on long windows, which say more, where these are fitted as well as the short ones."""
    short, vector = trial, _in_order(trial)
    again = _finely(search, vector, trial=trial, windows_of=trial)
    named_anew = not np.array_equal(vector, trial.fit.vector)
    if again is not None and (named_anew or again.fit.cost < trial.fit.cost):
        short = again
    enough = max(short.excess, 0.0) + 0.8
    long = _longest(search, short, trial)
    return short if long is None or long.excess >= enough else long


def _longest(search: Search, short: Trial, trial: Trial) -> Trial | None:
    """The trial on long windows, from more than one side where it is near the noise."""
    long = partial(_finely, trial=trial, cycles=LONG)
    first = long(search, short.fit.vector, states_of=short)
    best = None if first is None else search.trimmed(first)
    if best is None or short.excess >= 5 * CLEAN or unlisted.has_curve(trial):
        return best
    # the narrow valleys of (4.1) end a fit early
    worst = WORSE * best.fit.cost
    law = search.with_declared_law(short).fit.vector
    tasks = (
        search.submit(long, short.fit.vector, worst=worst),
        search.submit(long, law, states_of=short, worst=worst),
    )
    tried = [search.trimmed(one) for task in tasks if (one := task.result()) and one.fit.cost < worst]
    return _onward(search, min([best, *tried], key=lambda one: one.fit.cost))


def _onward(search: Search, best: Trial) -> Trial:
    """The trial at the end of the valley that its fit creeps along until its steps are used up.

    The way that a few steps make is gone many times over, and the valley's floor sought again from there.
    """
    for _ in range(TURNS):
        start = last = best
        best, leap = _steps(search, best, best.fit.vector) or best, FIRST_LEAP
        while best.fit.iterations >= FEW and leap >= LEAST_LEAP and search.left > 0:
            way = best.fit.vector - last.fit.vector
            tasks = [search.submit(_steps, best, best.fit.vector + k * way) for k in (leap, leap / 4)]
            found = [one for task in tasks if (one := task.result())]
            end = min(found, key=lambda one: one.fit.cost, default=best)
            if end.fit.cost < best.fit.cost - FALL:
                last, best, leap = best, end, NEXT_LEAP
            else:
                leap /= 16
        if best.fit.iterations < FEW or best.fit.cost > start.fit.cost - FALL or search.left < 0:
            break
    return best


def _steps(search: Search, trial: Trial, vector: Floats) -> Trial | None:
    """A few steps of the trial's own windows from a vector; None where it cannot be simulated or none is better."""
    engine = trial.fit.engine
    found = search.run(
        trial.hypothesis, cycles=LONG, tolerance=1e-9, rounds=0, iterations=FEW, windows_of=trial,
        vector=np.clip(vector, engine.low, engine.high), anyway=True, learned=engine.learned,
    )  # fmt: skip
    return None if found is None or found.fit.cost > trial.fit.cost else found


def _finely(search: Search, vector: Floats, *, trial: Trial, **options: Any) -> Trial | None:
    """The trial from these numbers to its very end."""
    near = trial.excess < FAR_OFF * CLEAN  # beyond, a few digits more of the numbers mean nothing
    exact = 1e-7 if unlisted.has_curve(trial) else 1e-9  # a curve's values are in its band
    return search.run(
        trial.hypothesis, tolerance=exact if near else 1e-5, rounds=3 if near else 1,
        vector=vector, anyway=True, learned=trial.fit.engine.learned, **options,
    )  # fmt: skip


def _in_order(trial: Trial) -> Floats:
    """The vector with the faster of the two exponentials of (4.1) first: their order is a convention."""
    vector = trial.fit.vector.copy()
    at = {u.name: i for i, u in enumerate(trial.fit.engine.hypothesis.shared)}
    if {"A1", "A2", "t1", "t2"} <= set(at) and vector[at["t1"]] > vector[at["t2"]]:
        for one, other in (("A1", "A2"), ("t1", "t2")):
            vector[[at[one], at[other]]] = vector[[at[other], at[one]]]
    return vector
