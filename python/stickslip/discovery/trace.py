"""Tracing: every listed effect as a rival fitted jointly with the law, then pairs, chosen by penalised likelihood."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.periodic import periodic_starts
from stickslip.discovery.ripple import freed_of_sensor, ripple_starts
from stickslip.discovery.rivals import PERIODIC, Start, hypothesis, shapes
from stickslip.discovery.search import CLEAN, SHORT, Search, Trial
from stickslip.effects import CATALOGUE, Effect
from stickslip.errors import StickslipError

Floats = NDArray[np.float64]
FAR = 1.15  # of the cost of one that reaches the noise: a rival beyond is none
BEYOND = 3.0  # and the same for the second of all
ASTRAY = 0.1  # of the excess of the declared law: pairs that leave more were built on the wrong effect
ANOTHER = 20.0  # processor seconds for the pairs of one effect
FARTHEST = 12.0  # of the cost of the best: a rival fitted crudely beyond is not fitted closely
ALONE = 1.05  # of the cost of a pair: one of its effects that alone leaves more is not fitted to the end
MARGIN = 10.0  # what an effect must gain beyond the penalty for its numbers


def declared(search: Search) -> Trial | None:
    """The declared law alone, on short windows."""
    return search.run(hypothesis(search.model, []), cycles=SHORT)


def starts_of(trial: Trial) -> list[Start]:
    """A trial's own effects as starts, to build on."""
    h = trial.hypothesis
    out = []
    for term in h.model.effects:
        if isinstance(term, Effect):
            out.append(Start(term, tuple(h.phases.get(f"{term.name}.phi", ()))))
    return out


def screen(search: Search, base: Trial, exclude: Sequence[str] = ()) -> list[Trial]:
    """Every effect added to `base` (on short windows), crudely fitted; best first."""
    model = base.hypothesis.model
    own = starts_of(base)
    skip = {*base.names, *exclude}
    candidates = {n: shapes(n, search.data) for n in CATALOGUE if n not in skip and n not in PERIODIC}
    search.progress("looking for lines in the residual's spectrum")
    candidates |= periodic_starts(base.fit, [n for n in PERIODIC if n not in skip])
    if "belt_speed_ripple" in candidates:
        candidates["belt_speed_ripple"] += _ripples(search, base)
    found = []
    for name, starts in candidates.items():
        search.progress(f"trying {' + '.join([*base.names, name])}")
        best: Trial | None = None
        for start in starts:
            trial = search.run(
                hypothesis(model, [*own, start], search.model),
                cycles=SHORT,
                iterations=24,  # most stop far earlier; one that is still falling must not be ranked yet
                tolerance=1e-2,
                rounds=1,
                windows_of=base,
                worst=0.985 * base.fit.cost if base.excess > CLEAN else 1.01 * base.fit.cost,
            )
            if trial is not None and (best is None or trial.fit.cost < best.fit.cost):
                best = trial
        if best is not None:
            found.append(best)
    search.screened += found
    return sorted(found, key=lambda one: one.bic)


def _ripples(search: Search, base: Trial) -> list[Start]:
    """Lines in the sticks, of the block itself where the base has an effect of its sensor."""
    if any(CATALOGUE[name].where == "x1 channel" for name in base.names if name in CATALOGUE):
        return ripple_starts(freed_of_sensor(base.fit))
    if search.ripples is None:
        search.ripples = ripple_starts(search.data)
    return search.ripples


def polished(search: Search, trials: Sequence[Trial], most: int = 4) -> list[Trial]:
    """The most promising trials fitted in earnest, best first; hopeless ones are left out."""
    return deepened(search, closely(search, trials, most))


def closely(search: Search, trials: Sequence[Trial], most: int = 4) -> list[Trial]:
    """The most promising trials fitted closely on short windows, best first; hopeless ones are left out."""
    close: list[Trial] = []
    for trial in trials[:most]:
        if close and (search.left < 0 or trial.fit.cost > FARTHEST * close[0].fit.cost):
            break
        least = min(close, key=lambda one: one.fit.cost, default=trial)
        far = FAR if len(close) >= 2 else BEYOND
        if close and least.excess < CLEAN and trial.fit.cost > far * least.fit.cost:
            break
        search.progress(f"fitting {' + '.join(trial.names)} closely")
        close.append(search.close(trial))
        if min(one.excess for one in close) < CLEAN and len(close) >= 3:
            break
    for one in close:
        search.keep(one, tuple(sorted(one.names)))
    return sorted(close, key=lambda one: one.bic)


def deepened(search: Search, trials: Sequence[Trial]) -> list[Trial]:
    """The two best trials shaken out of poor minima where they are left above the noise; best first."""
    out, best = list(trials), None
    for i in [i for i, one in enumerate(trials) if one.names][:2]:
        if best is not None and (best.excess < CLEAN or out[i].fit.cost > 3 * best.fit.cost):
            break
        if out[i].excess > CLEAN:
            search.progress(f"fitting {' + '.join(out[i].names)} from other sides")
            out[i] = search.polish(out[i])
            search.keep(out[i], tuple(sorted(out[i].names)))
        best = out[i]
    return sorted(out, key=lambda one: one.bic)


def beside(search: Search, trials: Sequence[Trial], curve: Trial, most: int = 4) -> list[Trial]:
    """The trials, single effects fitted also from where a learned curve has the law and the windows; best first.

    A curve that reaches the noise has every window on the right side of its transitions.
    """
    out = list(trials)
    for i, trial in enumerate(trials[:most]):
        if len(trial.names) != 1:
            continue
        search.progress(f"fitting {trial.names[0]} from where the curve is")
        h = hypothesis(curve.hypothesis.model, starts_of(trial), search.model)
        again = search.run(h, cycles=SHORT, windows_of=curve, tolerance=1e-3, anyway=True)
        if again is not None and again.fit.cost < trial.fit.cost:
            out[i] = again
            search.keep(again, again.names)
    return sorted(out, key=lambda one: one.bic)


def decide_single(search: Search) -> list[Trial]:
    """The declared law and single effects, closely fitted; best first."""
    null = declared(search)
    if null is None:
        raise StickslipError(
            "the declared model cannot be simulated from the readings: check the rig's numbers"
        )
    null = search.polish(null)
    search.keep(null, ())
    singles = closely(search, screen(search, null))
    if not singles:
        return [null]
    null = _refitted(search, null, singles[0])
    if singles[0].bic > null.bic - MARGIN:
        return [null, *singles]
    return sorted([null, *singles], key=lambda one: one.bic)


def decide_pairs(search: Search, trials: Sequence[Trial]) -> list[Trial]:
    """Pairs built on the best single effects, and what there was; best first."""
    null = search.tried[()]
    pairs: list[Trial] = []
    bases = [one for one in trials if len(one.names) == 1 and one.fit.cost < 0.9 * null.fit.cost][:3]
    for base in bases:
        if pairs and search.left < 0.3 * search.budget and not _astray(pairs, null):
            break
        search.extend(ANOTHER)
        pairs += polished(search, screen(search, base), most=3)
        if any(explained(one, null) for one in pairs):
            break
    pairs.sort(key=lambda one: one.bic)
    singles = _eliminated(search, pairs[0]) if pairs else []
    pairs = [one for one in pairs if _both_needed(search, one)]
    return sorted([*trials, *singles, *pairs], key=lambda one: one.bic)


def _astray(pairs: Sequence[Trial], null: Trial) -> bool:
    """Do all pairs leave so much that another effect must be among them?"""
    return min(one.chi2 for one in pairs) - 1 > ASTRAY * (null.chi2 - 1)


def _eliminated(search: Search, pair: Trial) -> list[Trial]:
    """Each effect of a pair alone, refitted from where the pair is."""
    out = []
    for start in starts_of(pair):
        search.progress(f"fitting {start.term.name} without its partner")
        h = hypothesis(pair.hypothesis.model, [start], search.model)
        worst = ALONE * (pair.fit.cost + MARGIN)
        alone = search.run(h, cycles=SHORT, windows_of=pair, tolerance=2e-5, worst=worst, anyway=True)
        if alone is not None:
            out.append(alone)
            search.keep(alone, alone.names)
    return out


def settled(search: Search, trial: Trial) -> Trial:
    """A named trial that is left above the noise, also fitted from the other shapes that its effects may start from."""
    best = trial
    for name in trial.names:
        for start in shapes(name, search.data) if name in CATALOGUE and name not in PERIODIC else []:
            if best.excess < CLEAN or search.left < 0:
                return best
            search.progress(f"fitting {' + '.join(trial.names)} from another start")
            others = [one for one in starts_of(trial) if one.term.name != name]
            h = hypothesis(trial.hypothesis.model, [*others, start], search.model)
            again = search.run(h, cycles=SHORT, windows_of=trial, iterations=30, tolerance=1e-3)
            if again is not None and again.fit.cost < 3 * best.fit.cost:
                again = search.polish(again, turns=1)
            if again is not None and again.fit.cost < best.fit.cost:
                best = again
    search.keep(best, tuple(sorted(best.names)))
    return best


def explained(trial: Trial, null: Trial) -> bool:
    """Is what a trial leaves within the noise, or next to nothing of what there was?"""
    rest, before = trial.chi2 - 1.0, null.chi2 - 1.0
    return trial.excess < CLEAN or (rest < 0.1 and rest < 0.01 * before)


def _refitted(search: Search, null: Trial, winner: Trial) -> Trial:
    """The declared law again, from where the winner has its law: refit against refit."""
    law = hypothesis(winner.hypothesis.model, [], search.model)
    other = search.run(law, cycles=SHORT, windows_of=winner, tolerance=2e-5)
    if other is not None and other.fit.cost < null.fit.cost:
        null = other
        search.keep(null, ())
    return null


def _both_needed(search: Search, pair: Trial) -> bool:
    """Backward elimination: neither effect can go at less than the price of its numbers."""
    for name in pair.names:
        single = search.tried.get((name,))
        if single is not None and single.bic < pair.bic + MARGIN:
            return False
    return True


__all__ = [
    "Search",
    "Trial",
    "beside",
    "closely",
    "decide_pairs",
    "decide_single",
    "declared",
    "deepened",
    "explained",
    "polished",
    "screen",
    "settled",
    "starts_of",
]
