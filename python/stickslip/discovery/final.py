"""The last fit of what was chosen: on long windows, from more than one side, to its very end."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery import unlisted
from stickslip.discovery.search import CLEAN, LONG, SHORT, Search, Trial

Floats = NDArray[np.float64]
FAR_OFF = 50.0  # of CLEAN: a misfit whose numbers are not worth perfecting
WORSE = 1.05  # of the cost of the first fit: one that stays beyond has ended somewhere else


def final(search: Search, trial: Trial) -> Trial:
    """The trial on long windows, which say more, where these are fitted as well as the short ones.

    Of one within the noise the records are taken from their beginning: a start says much, where it is understood.
    """
    short, vector = trial, _in_order(trial)
    again = _finely(search, vector, trial=trial, cycles=SHORT, windows_of=trial)
    named_anew = not np.array_equal(vector, trial.fit.vector)
    if again is not None and (named_anew or again.fit.cost < trial.fit.cost):
        short = again
    enough = max(short.excess, 0.0) + 0.8
    law = search.with_declared_law(short).fit.vector
    learned = unlisted.has_curve(trial)
    ways = (True, False) if short.excess < CLEAN else (False,)
    # of a curve nothing else is to be done meanwhile
    begun = {
        whole: search.submit(_long, short, trial=trial, whole=whole)
        for whole in (ways[1:] if learned else ())
    }
    for whole in ways:
        long = partial(_finely, trial=trial, cycles=LONG, whole=whole)
        known = begun.get(whole)
        best = known.result() if known else _long(search, short, trial=trial, whole=whole)
        if best is None:
            continue
        if short.excess < 5 * CLEAN and not learned:
            # the narrow valleys of (4.1) end a fit early: from other sides too
            worst = WORSE * best.fit.cost
            tasks = (
                search.submit(long, short.fit.vector, worst=worst),
                search.submit(long, law, states_of=short, worst=worst),
            )
            tried = [search.trimmed(one) for task in tasks if (one := task.result()) and one.fit.cost < worst]
            best = min([best, *tried], key=lambda one: one.fit.cost)
        if best.excess < enough:
            return best
    return short


def _long(search: Search, short: Trial, *, trial: Trial, whole: bool) -> Trial | None:
    """The trial on long windows from where it is on short ones."""
    first = _finely(search, short.fit.vector, trial=trial, cycles=LONG, whole=whole, states_of=short)
    return None if first is None else search.trimmed(first)


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
