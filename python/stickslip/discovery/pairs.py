"""Pairs of effects: sought on the best single ones, held against each of the two alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from stickslip.discovery.rivals import Start, hypothesis
from stickslip.discovery.search import CLEAN, Search, Trial
from stickslip.discovery.trace import (
    MARGIN,
    NEARLY,
    PLAIN,
    STUCK,
    closely,
    deepened,
    explained,
    polished,
    screen,
    starts_of,
)
from stickslip.discovery.workers import each

PROMISING = 0.03  # of the excess of the declared law: pairs that leave more may be built on the wrong effect
OUTSTANDING = (
    0.3  # of what the next best pair leaves: one that leaves less is fitted closely before another base
)
LIKELY = 0.1  # of the excess of their base: crude pairs that leave less, or noise, are fitted closely before any curve
RIVAL = 2.0  # of the cost of the best effect: pairs on the next are as likely where it leaves less
WEAKER = 4.0  # of the cost of the best effect, or of a plain misfit: one that leaves more is no other to build pairs on
SAME = 0.95  # of the cost that a base had: one that leaves less has other pairs
FREED = 0.5  # of the cost of the best effect: one that then leaves less alone is another to build pairs on
ANOTHER = 45.0, 20.0  # processor seconds for pairs on the best effect, at least, and on each further one
ALONE = 1.05  # of the cost of a pair: one of its effects that alone leaves more is not fitted to the end
BESIDE = 1.3  # of the cost of a pair: one of its effects that alone leaves less after a few steps is fitted to the end
HOPELESS = (
    2.0  # of the cost of a pair: an effect of it that alone leaves more after a few steps will not come near
)


def likely_pairs(search: Search, trials: Sequence[Trial]) -> list[Trial]:
    """The trials with pairs on the best single effect, or on the next that does nearly as well, if one that is crudely
    fitted all but reaches the noise and one that is closely fitted does; best first. Else none.
    """
    null = search.tried[()]
    bases = [one for one in trials if len(one.names) == 1][:2]
    for base in bases:
        if base.fit.cost > RIVAL * bases[0].fit.cost:
            break
        search.extend(ANOTHER[base is not bases[0]])
        found = _pairs_on(search, base)
        if not _likely(found, base):
            found = [*found, *_pairs_on_partner(search, base, found)]
        if not _likely(found, base):
            continue
        pairs = polished(search, sorted(found, key=lambda one: one.bic_of(null.fit.readings)))
        if not pairs or not explained(pairs[0], null):
            continue
        return _together(search, trials, _eliminated(search, pairs[0]), pairs)
    return []


def _likely(pairs: Sequence[Trial], base: Trial) -> bool:
    """Does a pair, crudely fitted, all but reach the noise?"""
    least = min(pairs, key=lambda one: one.chi2, default=base)
    return least.excess <= CLEAN or least.chi2 - 1 <= LIKELY * (base.chi2 - 1)


def _together(
    search: Search, trials: Sequence[Trial], singles: Sequence[Trial], pairs: Sequence[Trial]
) -> list[Trial]:
    """All of them but pairs that one of their effects can do without; best first."""
    needed = [one for one in pairs if _both_needed(search, one)]
    return sorted([*trials, *singles, *needed], key=lambda one: one.bic)


def _pairs_on(search: Search, base: Trial) -> list[Trial]:
    """Pairs on a single effect, crudely fitted; those that are known, unless the effect itself fits far better now."""
    known = search.pairs.get(base.names)
    if known is None or base.fit.cost < SAME * known[0]:
        known = search.pairs[base.names] = base.fit.cost, screen(search, base)
    return known[1]


def _pairs_on_partner(search: Search, base: Trial, pairs: Sequence[Trial]) -> list[Trial]:
    """Pairs on the best partner of a base, alone from where their pair has the law and the windows; none where it is no
    other to build on.

    Of two effects a third may explain most alone, and one of the two then goes best with it; by itself that one may
    never have come to its place.
    """
    pair = min(pairs, key=lambda one: one.chi2, default=base)
    if pair.chi2 - 1 > STUCK * (base.chi2 - 1):
        return []
    alone = search.once("partner", base, lambda: _partner(search, base, pair))
    if alone is None or alone.mean > RIVAL * base.mean or search.left < 0:
        return []
    return _pairs_on(search, alone)


def _partner(search: Search, base: Trial, pair: Trial) -> Trial | None:
    """What a pair has beside its base, alone, on the pair's windows: others may not follow it yet."""
    start = next(one for one in starts_of(pair) if one.term.name not in base.names)
    search.progress(f"fitting {start.term.name} from where it goes with {base.names[0]}")
    h = hypothesis(pair.hypothesis.model, [start], search.model)
    return search.run(h, windows_of=pair, tolerance=1e-3, iterations=25, rounds=1)


def decide_pairs(search: Search, trials: Sequence[Trial], most: int = 3) -> list[Trial]:
    """Pairs built on the best single effects (on `most` of them at most), and what there was; best first.

    A single effect that explains most may only stand in for the two there are: where no pair on it promises to explain
    the rest, or none does once it is fitted closely, pairs on the next are screened too. One that a pair has brought to
    its place, and that then does far better alone than any before, is another to build on.
    """
    null = search.tried[()]
    readings = null.fit.readings
    bases = [one for one in trials if len(one.names) == 1 and one.fit.cost < 0.9 * null.fit.cost]
    bases = [one for one in bases if one.mean < WEAKER * max(bases[0].mean, PLAIN)][:most]
    left, pairs = list(bases), list[Trial]()
    while left and not (pairs and explained(pairs[0], null)):
        found: list[Trial] = []
        while left and not (found and _promising(found, null)):
            search.extend(ANOTHER[len(left) < len(bases)])
            base = left.pop(0)
            found += (more := _pairs_on(search, base))
            if not (found and _promising(found, null)):
                found += _pairs_on_partner(search, base, more)
        few = pairs or not (found and _promising(found, null))
        close = closely(search, sorted(found, key=lambda one: one.bic_of(readings)), most=2 if few else 4)
        if close and not _no_partner(close[0], search):
            close = deepened(search, close)
        pairs = sorted([*pairs, *close], key=lambda one: one.bic)
    singles = _eliminated(search, pairs[0]) if pairs else []
    freed = min(singles, key=lambda one: one.fit.cost, default=None)
    if most > 1 and freed and not explained(pairs[0], null) and freed.fit.cost < FREED * bases[0].fit.cost:
        search.extend(ANOTHER[True])
        more = polished(search, screen(search, freed), most=3)
        if more and more[0].bic < pairs[0].bic:
            singles += _eliminated(search, more[0])
        pairs = sorted([*pairs, *more], key=lambda one: one.bic)
    return _together(search, trials, singles, pairs)


def _promising(pairs: Sequence[Trial], null: Trial) -> bool:
    """Does a pair, crudely fitted, come so near the noise that a close fit may reach it? Or does it stand out?"""
    best = min(pairs, key=lambda one: one.chi2)
    left = best.chi2 - 1
    others = [one.chi2 - 1 for one in pairs if set(one.names) != set(best.names)]
    return (
        left < NEARLY - 1
        or left < PROMISING * (null.chi2 - 1)
        or left < OUTSTANDING * min(others, default=0.0)
    )


def _no_partner(pair: Trial, search: Search) -> bool:
    """Does a pair leave most of what the better of its effects leaves alone? Then it is none, from whatever side."""
    alone = [one.chi2 for name in pair.names if (one := search.tried.get((name,))) is not None]
    return pair.chi2 - 1 > STUCK * (min(alone, default=math.inf) - 1)


def _eliminated(search: Search, pair: Trial) -> list[Trial]:
    """Each effect of a pair alone, refitted from where the pair is."""
    out = []
    say = lambda start: f"fitting {start.term.name} without its partner"  # noqa: E731
    for _, task in each(search, partial(_alone, pair=pair), starts_of(pair), say):
        alone = task.result()
        if alone is not None:
            out.append(alone)
            search.keep(alone, alone.names)
    return out


def _alone(search: Search, start: Start, *, pair: Trial) -> Trial | None:
    h = hypothesis(pair.hypothesis.model, [start], search.model)
    crude = search.run(h, windows_of=pair, tolerance=1e-2, iterations=4, rounds=0, anyway=True)
    if crude is None or crude.fit.cost > HOPELESS * pair.fit.cost:
        return crude
    near = crude.fit.cost < BESIDE * pair.fit.cost  # it may do as well, however slowly it comes there
    if search.left < 0 and not near:
        return crude
    worst = math.inf if near else ALONE * (pair.fit.cost + MARGIN)
    return search.run(crude.hypothesis, windows_of=crude, tolerance=2e-5, worst=worst, anyway=True)


def slimmed(search: Search, trial: Trial) -> Trial:
    """A pair, or the one of its effects that does as well alone, refitted from where the pair is."""
    singles = _eliminated(search, trial) if len(trial.names) > 1 else []
    return trial if _both_needed(search, trial) else min(singles, key=lambda one: one.bic, default=trial)


def _both_needed(search: Search, pair: Trial) -> bool:
    """Backward elimination: neither effect can go at less than the price of its numbers."""
    for name in pair.names:
        single = search.tried.get((name,))
        if single is not None and single.bic < pair.bic + MARGIN:
            return False
    return True
