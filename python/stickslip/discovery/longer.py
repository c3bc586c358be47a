"""A second look through longer windows, where what short ones explain does not last.

A window has its initial state to itself, and within one cycle that takes up much of a wrong friction law. Over two
cycles a whole slip is foretold, and a law or a name that only fits by its windows' states is seen to be wrong.
"""

from __future__ import annotations

from stickslip.discovery.choice import Choice, choose
from stickslip.discovery.search import CLEAN, LONG, Search, Trial
from stickslip.discovery.trace import MARGIN, decide_single

LEAST = 20.0  # processor seconds for the second look


def looked_at_longer(search: Search, choice: Choice) -> tuple[Search, Choice]:
    """The search and its choice; or those in longer windows, where what explains all of the short ones does not explain
    these and another does better.
    """
    chosen = choice.trial
    if choice.place is not None or chosen.excess > CLEAN or search.left < 0:
        return search, choice
    lasting = _longer(search, chosen)
    if lasting is None or lasting.excess < CLEAN:
        return search, choice
    search.progress("what explains single cycles does not last over two: once more over two")
    null = lasting if chosen is choice.null else _longer(search, choice.null)
    second = search.afresh(search.data, LONG)
    second.most = max(second.most, second.budget - second.left + LEAST)
    second.extend(search.most)
    again = choose(second, decide_single(second, null), one_cause=len(chosen.names) == 1)
    better = again.trial.bic < lasting.bic - MARGIN
    return (second, again) if again.trial.names and better else (search, choice)


def _longer(search: Search, trial: Trial) -> Trial | None:
    """A trial in longer windows, from more than one side unless it is within the noise."""
    first = _fitted(search, trial, trial)
    if first is None or first.excess < CLEAN:
        return first
    best = search.trimmed(first)
    if best.excess < CLEAN:
        return best
    other = _fitted(search, search.with_declared_law(trial), trial)
    return best if other is None else min(best, search.trimmed(other), key=lambda one: one.fit.cost)


def _fitted(search: Search, trial: Trial, states_of: Trial) -> Trial | None:
    return search.run(
        trial.hypothesis, cycles=LONG, states_of=states_of, vector=trial.fit.vector,
        learned=trial.fit.engine.learned, anyway=True,
    )  # fmt: skip
