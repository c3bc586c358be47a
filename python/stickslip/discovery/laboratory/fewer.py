"""What was found with fewer effects: what is left to claim where runs never used speak against all of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.laboratory.trials import Trial


def fewer(found: Searched) -> Iterator[Searched]:
    """
    Yield the search's end with some of its effects, most first, of as many the best first.

    Each of the effects passes its gate beside the others; what was not fitted on the way is not asked for.

    Parameters
    ----------
    found : with two effects or more; of one alone nothing is left
    """
    whole = frozenset(found.chosen.names)
    every = [*found.trials, *(step.base for step in found.steps), *found.without.values()]
    best: dict[frozenset[str], Trial] = {frozenset(): found.null}
    for one in sorted(every, key=lambda trial: trial.deviance):
        if one.terms and one.freed is None:
            best.setdefault(frozenset(one.names), one)
    parts = [names for names in best if names and names < whole]
    for names in sorted(parts, key=lambda own: (-len(own), best[own].worth())):
        less = {gone: best[names - {gone}] for gone in names if names - {gone} in best}
        if len(less) == len(names) and all(
            best[names].over(rest) > _gate(found, gone) for gone, rest in less.items()
        ):
            yield replace(found, chosen=best[names], without=less)


def beside_others(found: Searched) -> dict[str, tuple[Trial, float]]:
    """
    Return for each of several effects the best without it, and by how much it passes its gate beside the others.

    Parameters
    ----------
    found : the search's end; of one effect alone nothing is returned
    """
    chosen = found.chosen
    if len(chosen.terms) < 2:
        return {}
    less = {name: found.without[name] for name in chosen.names if name in found.without}
    return {name: (one, max(chosen.over(one) - _gate(found, name), 0.0)) for name, one in less.items()}


def _gate(found: Searched, name: str) -> float:
    """The highest gate that an effect may be asked to pass."""
    return max(step.waves.get(name, step.gate).threshold for step in found.steps)
