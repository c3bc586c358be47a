"""Tracing: every listed effect as a rival fitted jointly with the law, then pairs, chosen by penalised likelihood."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.check_model import idle
from stickslip.declared.effect import CATALOGUE, Effect
from stickslip.declared.friction_law import FrictionLaw
from stickslip.discovery.periodic import periodic_starts
from stickslip.discovery.ripple import freed_of_sensor, ripple_starts
from stickslip.discovery.rivals import PERIODIC, Start, hypothesis, shapes
from stickslip.discovery.search import CLEAN, JUDGED, Search, Trial, stands
from stickslip.discovery.workers import each
from stickslip.errors import StickslipError
from stickslip.fitted.solve import QUIET
from stickslip.progress import StageStep, trying

Floats = NDArray[np.float64]
FAR = 1.15  # of the cost of one that reaches the noise: a rival beyond is none
BEYOND = 3.0  # and the same for the second of all
FARTHEST = 12.0  # of the cost of the best: a rival fitted crudely beyond is not fitted closely
AFRESH = 10.0  # processor seconds for these, at least
STUCK = 0.5  # of the excess of a base: where all rivals leave more, those that did not move are tried afresh
PLAIN = 2.0  # chi-squared per reading above which half of the windows will do
NEARLY = 1.5  # chi-squared per reading that is near the noise
MANY = 4  # rivals, beside the best, that leave nearly as little as it: they only shake the base
OTHER = frozenset({"contact_compliance"})  # a contact of another kind: a law fitted without it leads astray
CRUDELY = (
    0.01  # of what a base leaves over the noise: a rival that falls by less in a step is ranked as it is
)
LITTLE = 20.0  # of chi-squared: about what a name must gain
STEPS = 24  # of a rival, before it is ranked
SHAKEN = 8  # rivals whose windows are sought anew before they are ranked; and of those not judged yet
AHEAD = 3  # rivals begun for each process: some take a hundred times as long as others
LITTLE_ALONE = 0.9  # of the cost of the declared law: an effect that leaves more by itself explains little
MOVED = 0.99  # of the cost of a base: a rival that leaves more did not move
UNFITTED = (
    1.05  # of the cost of a base: a rival that leaves more than its own special case has found no way down
)
OUTRUN = 1.5  # of the cost of what explains all: a rival that stalls beyond does not do so too
MARGIN = 10.0  # what an effect must gain beyond the penalty for its numbers


def declared(search: Search, known: Trial | None = None) -> Trial | None:
    """The declared law alone, on the search's windows; from where it is `known` to end on readings cleaned less."""
    if known is not None:
        return search.run(known.hypothesis, windows_of=known, vector=known.fit.vector)
    return search.run(hypothesis(search.model, []))


def starts_of(trial: Trial) -> list[Start]:
    """A trial's own effects as starts, to build on."""
    h = trial.hypothesis
    out = []
    for term in h.model.effects:
        if isinstance(term, Effect):
            out.append(Start(term, tuple(h.phases.get(f"{term.name}.phi", ()))))
    return out


def screen(search: Search, base: Trial, exclude: Sequence[str] = ()) -> list[Trial]:
    """Every effect added to `base` (on short windows), crudely fitted; best first.

    Where the misfit is plain, half of the windows show it as well: the trials are then `partial`.
    """
    part = search.half(base) if base.chi2 > PLAIN and not base.partial else base
    skip = {*base.names, *exclude, *_idle(search.model.friction, base.names)}
    search.progress("looking for lines in the residual's spectrum")
    lines = search.submit(_lines, base, tuple(n for n in PERIODIC if n not in skip), search.ripples)

    def starts() -> Iterator[tuple[str, Start]]:
        for name in _promising_first(search):
            if name not in skip and name not in PERIODIC:
                yield from ((name, start) for start in shapes(name, search.data))
        found, search.ripples = lines.result()
        yield from found

    def say(one: tuple[str, Start]) -> StageStep:
        return trying(base.names, one[0])

    tried, best = [], dict[str, Trial]()
    ends: list[tuple[str, Trial]] = []
    for one, task in each(search, partial(_screened, base=part), starts(), say, AHEAD):
        tried.append(one)
        _take(best, ends, one[0], task.result())
    for end, task in each(search, partial(_shaken, base=part), _worth_more(ends, part), ahead=AHEAD):
        _take(best, ends, end[0], task.result())
    anew, ends = _anew(search, part, tried, best), []
    for one, task in each(search, partial(_screened, base=part, afresh=True), anew, say, AHEAD):
        _take(best, ends, one[0], task.result())
    again = partial(_shaken, base=part, afresh=True)
    for end, task in each(search, again, _worth_more(ends, part, afresh=True), ahead=AHEAD):
        _take(best, ends, end[0], task.result())
    search.screened += best.values()
    return sorted(best.values(), key=lambda one: one.bic)


def _take(best: dict[str, Trial], ends: list[tuple[str, Trial]], name: str, trial: Trial | None) -> None:
    """Note where a rival has ended, and if that is the best of its name."""
    if trial is not None:
        ends.append((name, trial))
        if name not in best or trial.fit.cost < best[name].fit.cost:
            best[name] = trial


def _worth_more(
    ends: Sequence[tuple[str, Trial]], base: Trial, afresh: bool = False
) -> list[tuple[str, Trial]]:
    """The rivals of several that are worth the search for better states of their windows: the best, and those that
    ended before they could be judged; but none that stands where the base does.
    """
    able = [one for one in ends if one[1].mean > QUIET and one[1].fit.iterations < _steps(one[0], afresh)]
    able.sort(key=lambda one: one[1].fit.cost)
    if afresh:
        able = [one for one in able if one[1].fit.cost < FARTHEST * base.fit.cost]
        return able[:SHAKEN] + [one for one in able[SHAKEN:] if one[0] in OTHER]
    hopeless = _no_better(base)
    moved = [one for one in able if not stands(one[1].fit.cost, hopeless)]
    early = [one for one in moved[SHAKEN:] if one[1].fit.cost > hopeless and one[1].fit.iterations < JUDGED]
    return moved[:SHAKEN] + early[:SHAKEN]


def _anew(
    search: Search, base: Trial, tried: Sequence[tuple[str, Start]], best: Mapping[str, Trial]
) -> list[tuple[str, Start]]:
    """What is to be tried from the declared law as well: all that stalled, where every one did; else what ended worse
    than the base, which it has for a special case, and another contact, unless that is known to explain little alone.
    """
    cost = {name: trial.fit.cost / base.fit.cost for name, trial in best.items()}
    hopeless = OTHER & _little_alone(search) if base.names else frozenset[str]()
    able = [one for one in tried if one[0] not in hopeless]
    if _stuck(base, best.values()):
        search.extend(AFRESH)
        return [one for one in able if cost.get(one[0], 1.0) > MOVED]
    least = min((one.chi2 for one in best.values()), default=base.chi2)
    plain = base.excess > CLEAN and min(least, base.chi2) > NEARLY
    return [one for one in able if plain and (one[0] in OTHER or cost.get(one[0], 1.0) > UNFITTED)]


def _little_alone(search: Search) -> frozenset[str]:
    """Effects that alone left most of what the declared law leaves."""
    null = search.tried[()]
    return frozenset(
        one.names[0] for one in search.screened if len(one.names) == 1 and one.mean > LITTLE_ALONE * null.mean
    )


def _idle(law: FrictionLaw, beside: Sequence[str]) -> set[str]:
    """Effects that could do nothing under a law, alone or beside others: no rivals."""
    return {name for name in CATALOGUE if idle(law, [name]) or idle(law, [*beside, name])}


def _promising_first(search: Search) -> list[str]:
    """The catalogue in the order in which its effects alone explained most: time may run out."""
    alone = {one.names[0]: one.mean for one in reversed(search.screened) if len(one.names) == 1}
    return sorted(CATALOGUE, key=lambda name: alone.get(name, math.inf))


def _stuck(base: Trial, trials: Iterable[Trial]) -> bool:
    """Do all leave most of what the base leaves, or as many do of what the best leaves? Then the right one may find no
    way out of where the base is.
    """
    left = sorted(one.chi2 - 1 for one in trials) or [base.chi2 - 1]
    idle = min([base.chi2 - 1, *left[MANY : MANY + 1]])  # so much falls away with whatever is added
    return base.excess > CLEAN and base.chi2 > NEARLY and left[0] > STUCK * idle


def _screened(search: Search, one: tuple[str, Start], *, base: Trial, afresh: bool = False) -> Trial | None:
    """An effect added to the base, from the base's law or `afresh` from the declared one."""
    model = search.model if afresh else base.hypothesis.model
    return search.run(
        hypothesis(model, [*starts_of(base), one[1]], search.model),
        iterations=_steps(one[0], afresh),
        tolerance=_crudely(base),
        rounds=0,
        windows_of=base,
        worst=math.inf if afresh else _no_better(base),
    )


def _shaken(search: Search, one: tuple[str, Trial], *, base: Trial, afresh: bool = False) -> Trial | None:
    """A rival that has stalled, fitted on with the states of its windows sought anew."""
    name, trial = one
    return search.run(
        trial.hypothesis,
        iterations=_steps(name, afresh) - trial.fit.iterations,
        tolerance=_crudely(base),
        rounds=1,
        windows_of=trial,
        vector=trial.fit.vector,
        worst=math.inf if afresh else _no_better(base),
    )


def _steps(name: str, afresh: bool) -> int:
    """Of a rival, before it is ranked: most stop far earlier; one that is still falling must not be ranked yet."""
    return STEPS // 2 if afresh and name not in OTHER else STEPS


def _crudely(base: Trial) -> float:
    """The relative fall of the cost in a step at which a rival is ranked."""
    return CRUDELY * max(base.fit.cost - base.fit.readings, LITTLE) / base.fit.cost


def _no_better(base: Trial) -> float:
    """The cost beyond which a rival is no better than its base."""
    return (0.985 if base.excess > CLEAN else 1.01) * base.fit.cost


def _lines(
    search: Search, base: Trial, names: Sequence[str], ripples: list[Start] | None
) -> tuple[list[tuple[str, Start]], list[Start] | None]:
    """Starts of periodic effects, and the ripples that the readings themselves show, sought if they are not known."""
    found = periodic_starts(base.fit, names)
    if "belt_speed_ripple" in found:
        # lines in the sticks: of the block itself where the base has an effect of its sensor
        if any(CATALOGUE[name].where == "x1 channel" for name in base.names if name in CATALOGUE):
            found["belt_speed_ripple"] += ripple_starts(freed_of_sensor(base.fit))
        else:
            ripples = ripple_starts(search.data) if ripples is None else ripples
            found["belt_speed_ripple"] += ripples
    return [(name, start) for name, some in found.items() for start in some], ripples


def polished(search: Search, trials: Sequence[Trial], most: int = 4) -> list[Trial]:
    """The most promising trials fitted in earnest, best first; hopeless ones are left out."""
    return deepened(search, closely(search, trials, most))


def closely(search: Search, trials: Sequence[Trial], most: int = 4) -> list[Trial]:
    """The most promising trials fitted closely on short windows, best first; hopeless ones are left out."""
    close: list[Trial] = []
    say = lambda trial: f"fitting {' + '.join(trial.names)} closely"  # noqa: E731
    for trial, task in each(search, Search.close, trials[:most], say):
        if close and (search.left < 0 or trial.mean > FARTHEST * close[0].mean):
            break
        least = min(close, key=lambda one: one.fit.cost, default=trial)
        far = FAR if len(close) >= 2 else BEYOND
        if close and least.excess < CLEAN and trial.mean > far * least.mean:
            break
        done = task.result()
        if done.partial:  # what cannot be fitted on all windows
            continue
        close.append(done)
        if min(one.excess for one in close) < CLEAN and len(close) >= 3:
            break
    for one in close:
        search.keep(one, tuple(sorted(one.names)))
    return sorted(close, key=lambda one: one.bic)


def deepened(search: Search, trials: Sequence[Trial]) -> list[Trial]:
    """The two best trials, closely fitted, shaken out of poor minima where they are above the noise; best first."""
    out, best = list(trials), None
    chosen = [i for i, one in enumerate(trials) if one.names][:2]
    for i, task in each(search, partial(_polished, trials=trials), chosen):
        if best is not None and (best.excess < CLEAN or out[i].fit.cost > 3 * best.fit.cost):
            break
        if out[i].excess > CLEAN:
            search.progress(f"fitting {' + '.join(out[i].names)} from other sides")
            out[i] = task.result()
            search.keep(out[i], tuple(sorted(out[i].names)))
        best = out[i]
    return sorted(out, key=lambda one: one.bic)


def _polished(search: Search, i: int, *, trials: Sequence[Trial]) -> Trial:
    return search.polish(trials[i], closed=True)


def beside(search: Search, trials: Sequence[Trial], curve: Trial, most: int = 4) -> list[Trial]:
    """The trials, single effects fitted also from where a learned curve has the law and the windows; best first.

    A curve that reaches the noise has every window on the right side of its transitions.
    """
    out = list(trials)
    singles = [i for i, trial in enumerate(trials[:most]) if len(trial.names) == 1]
    say = lambda i: f"fitting {trials[i].names[0]} from where the curve is"  # noqa: E731
    for i, task in each(search, partial(_beside, trials=trials, curve=curve), singles, say):
        again = task.result()
        if again is not None and again.fit.cost < out[i].fit.cost:
            out[i] = again
            search.keep(again, again.names)
    return sorted(out, key=lambda one: one.bic)


def _beside(search: Search, i: int, *, trials: Sequence[Trial], curve: Trial) -> Trial | None:
    h = hypothesis(curve.hypothesis.model, starts_of(trials[i]), search.model)
    worst = OUTRUN * curve.fit.cost
    return search.run(h, windows_of=curve, tolerance=1e-3, worst=worst, anyway=True)


def decide_single(search: Search, known: Trial | None = None) -> list[Trial]:
    """The declared law, from where it is `known` to end, and single effects, closely fitted; best first."""
    null = declared(search, known)
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
            again = search.run(h, windows_of=trial, iterations=30, tolerance=1e-3)
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
    other = search.run(law, windows_of=winner, tolerance=2e-5)
    if other is not None and other.fit.cost < null.fit.cost:
        null = other
        search.keep(null, ())
    return null


__all__ = [
    "Search",
    "Trial",
    "beside",
    "closely",
    "decide_single",
    "declared",
    "deepened",
    "explained",
    "polished",
    "screen",
    "settled",
    "starts_of",
]
