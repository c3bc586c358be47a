"""What is chosen: names, a curve where they do not reach, a place where nothing does. Validate runs have no say."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stickslip.declared.effect import CATALOGUE
from stickslip.discovery import drifting, unlisted
from stickslip.discovery import evidence as ev
from stickslip.discovery.drifting import DROOP, drift_of
from stickslip.discovery.lagging import lag_of, time_constant
from stickslip.discovery.messages import absurd
from stickslip.discovery.pairs import decide_pairs, likely_pairs, slimmed
from stickslip.discovery.place import place_of, promises
from stickslip.discovery.recurring import learn_hum, learn_recurring
from stickslip.discovery.result import Curve, Interval
from stickslip.discovery.rig_numbers import KINDS, freed
from stickslip.discovery.rivals import PERIODIC, sought
from stickslip.discovery.search import CLEAN, Search, Trial
from stickslip.discovery.trace import MARGIN, beside, deepened, explained, settled

SETTLING = 25.0  # more, to fit in earnest what is named but leaves something over
ALMOST = 0.2  # share of the excess that names may leave to be fitted from other shapes
STANDS_IN = 0.2  # share that what only stands in for something else may leave and be in the model
DRIFTS = 0.02  # and leave, for no other explanation to be sought
MOST_LEFT = 0.7  # share of the excess that a named effect may leave and still be claimed
LEFT_OVER = 0.3  # of chi-squared per reading above 1, and this share of what there was, that names may leave and stand
SHARE_LEFT = 0.003
DISTINCT = 0.1  # of the excess of the next best names: names that leave less stand all the same
DOUBTFUL = 1.0  # sampling errors of chi-squared above 1: what leaves less has no rival among curves
ON_TRACK = (
    0.3  # share of what the best name leaves: where a crude curve leaves less, curves come before pairs
)
SURPASSED = 0.05  # share of what the best name leaves: where a curve leaves less, no pair of names is sought
CURVES = 30.0  # processor seconds for curves, at least, where the names took all there were
REPEATS = 15.0  # processor seconds for what repeats in time, at least, where the names took all there were
WIDE = 0.95  # of the greatest width: a peak that stopped there
DECISIVE = 100.0  # of BIC, by which a curve within the noise must surpass names that leave a little
BETTER = 0.5  # share of the excess that a learned curve may leave of what the best named effects leave


@dataclass
class Choice:
    """What was chosen: the declared law, the trial, the curve in it if any, all trials, the likely place of what
    neither a name nor a curve explains, the error on windows held out over what it was, and the law with numbers of the
    rig that do as well; how the belt's speed drifts in time, or the time constant of a lag of the y1 reading, if that
    is what was chosen.
    """

    null: Trial
    trial: Trial
    term: unlisted.Term | None
    trials: list[Trial]
    place: tuple[str, tuple[str, ...]] | None = None
    held: float = 1.0
    tied: tuple[Trial, ...] = ()
    drift: Curve | None = None
    lag: Interval | None = None


def choose(search: Search, trials: list[Trial], *, one_cause: bool = False) -> Choice:
    """The choice for the runs of a search and the trials of single effects, held against windows left out.

    `one_cause`: a curve or a name is known to come near, so that curves come before pairs.
    """
    null = search.tried[()]
    hum = learn_hum(search, null)
    if _settles(hum, trials[0], null):
        return _held(search, _curve_of(null, hum, trials))
    single = Choice(null, trials[0], None, trials)
    choice = _with_drift(search, single, alone=True)
    if choice is single:
        choice = _with_lag(search, single, alone=True)
    if choice is single:
        choice = _with_lag(search, _with_drift(search, _choose(search, trials, one_cause)))
    return _held(search, _with_rig(search, choice))


def _with_lag(search: Search, choice: Choice, alone: bool = False) -> Choice:
    """The choice; or, where a delay of the y1 reading was chosen and a lag of it explains more, that.

    `alone`: it must explain all, for the delay may yet have a partner.
    """
    found = lag_of(search, choice.trial)
    if found is None or (alone and not explained(found[1], choice.null)):
        return choice
    delay, lag = found
    stands_in = delay.chi2 - 1 < STANDS_IN * (choice.null.chi2 - 1)
    best = delay if stands_in else choice.null
    tau = time_constant(lag)
    return Choice(choice.null, best, None, choice.trials, ("y1 channel", ("memory",)), lag=tau)


def _with_drift(search: Search, choice: Choice, alone: bool = False) -> Choice:
    """The choice; or, where a droop of the belt was chosen whose load has no say, a belt that drifts in time.

    `alone`: it must leave next to nothing, for a curve may yet leave less.
    """
    if DROOP not in choice.trial.names and (choice.place is None or choice.place[0] != "belt"):
        return choice
    found = drift_of(search)
    if found is None:
        return choice
    wave, curve = found
    left, before = wave.chi2 - 1, choice.null.chi2 - 1
    if left > (DRIFTS if alone else STANDS_IN) * before and not (alone and explained(wave, choice.null)):
        return choice  # it stands in for something else, as the droop did
    on = () if drifting.steady(curve, wave) else ("t",)
    return Choice(choice.null, wave, None, [wave, *choice.trials], ("belt", on), drift=curve)


def _with_rig(search: Search, choice: Choice) -> Choice:
    """The choice, or a number of the declared rig that is wrong where that explains more with less."""
    chosen = choice.trial
    if chosen.names in KINDS or not (chosen.names or choice.place):
        return choice
    wrong = [one for one in freed(search, chosen, closely=True) if explained(one, choice.null)]
    if wrong and wrong[0].bic < chosen.bic - MARGIN:
        return Choice(choice.null, wrong[0], None, [*wrong, *choice.trials])
    return replace(choice, tied=tuple(one for one in wrong if one.bic < chosen.bic + MARGIN))


def _choose(search: Search, trials: list[Trial], one_cause: bool = False) -> Choice:
    null, best = search.tried[()], trials[0]
    if explained(best, null) and best.excess < DOUBTFUL and not _wide(best):
        return Choice(null, best, None, trials)
    if explained(best, null) and not best.names:  # a line is far sharper than chi-squared over all
        curves = learn_recurring(search, null)
        if _settles(curves, best, null):
            return _curve_of(null, curves, trials)
        return Choice(null, best, None, trials)
    if not explained(best, null):
        wrong = freed(search, best)
        if wrong and wrong[0].excess < CLEAN:  # one number: no pair and no curve does that with less
            return Choice(null, wrong[0], None, [*wrong, *trials])
    search.extend(CURVES)
    crude = unlisted.crude(search, null)
    off_track = crude.beyond(best) > ON_TRACK and not one_cause
    if not explained(best, null) and best.names and off_track:
        pairs = likely_pairs(search, trials)
        if pairs and len(pairs[0].names) > 1 and pairs[0].excess < DOUBTFUL:
            return Choice(null, pairs[0], None, pairs)
        trials = pairs or trials  # a pair that leaves more is held against curves as a single name is
        best = trials[0]
    curves = unlisted.learn(search, null, beat=best, known=crude)
    if explained(best, null) and set(best.names) <= set(PERIODIC):
        curves = sorted([*curves, *learn_recurring(search, null, best)], key=lambda one: one[1].bic)
    curved = _settles(curves, best, null)
    trials = beside(search, trials, curves[0][1]) if curved else deepened(search, trials)
    best = trials[0]
    if explained(best, null) and not (curved and _surpasses(curves[0][1], best)):
        trials = _with_partner(search, trials)
        return Choice(null, trials[0], None, trials)
    outdone = min((unlisted.beyond(t, best) for _, t in curves), default=1.0)
    if not curved and outdone > SURPASSED:
        alone = outdone > unlisted.OUTDONE
        unnamed = best.chi2 - 1 > MOST_LEFT * (null.chi2 - 1)
        if alone and unnamed and not promises(search, null).wandering:
            curves += learn_recurring(search, null)
            if _settles(curves, best, null):
                return _curve_of(null, curves, trials)
        trials = decide_pairs(search, trials, most=3 if alone else 1)
        best = trials[0]
        if explained(best, null):
            return Choice(null, best, None, trials)
        far = best.chi2 - 1 > STANDS_IN * (null.chi2 - 1)
        if alone and not unnamed and far and not promises(search, null).wandering:
            search.extend(REPEATS)
            curves += learn_recurring(search, null)
        if len(best.names) == 1 and best.fit.cost < 0.5 * null.fit.cost and search.left > 0:
            curves += unlisted.learn(search, best, 3)
    curves.sort(key=lambda one: one[1].bic)
    absurd(min([best, *(t for _, t in curves)], key=lambda one: one.fit.cost), search.data)
    if curves and _surpasses(curves[0][1], best):
        return _curve_of(null, curves, trials)
    if best.chi2 - 1 > MOST_LEFT * (
        null.chi2 - 1
    ):  # no name and no curve explains it: say so, and guess the place
        return Choice(null, null, None, trials, place_of(search, null, best))
    if best.chi2 - 1 < ALMOST * (null.chi2 - 1):
        search.extend(SETTLING)
        best = slimmed(search, settled(search, best))
    return weighed(search, null, best, curves, trials)


def _with_partner(search: Search, trials: list[Trial]) -> list[Trial]:
    """The trials; with pairs where the best name leaves next to nothing, but not noise, and a second takes the rest."""
    if len(trials[0].names) != 1 or trials[0].excess < CLEAN:
        return trials
    pairs = likely_pairs(search, trials)
    return pairs if pairs and pairs[0].excess < CLEAN else trials


def _settles(curves: list[tuple[unlisted.Term, Trial]], best: Trial, null: Trial) -> bool:
    """Does the best of the curves explain everything, and surpass the best of the named?"""
    least = min((t for _, t in curves), key=lambda one: one.bic, default=None)
    return least is not None and _surpasses(least, best) and explained(least, null)


def _curve_of(null: Trial, curves: list[tuple[unlisted.Term, Trial]], trials: list[Trial]) -> Choice:
    term, least = min(curves, key=lambda one: one[1].bic)
    ranked = sorted([*trials, *(t for _, t in curves)], key=lambda one: one.bic)
    return Choice(null, least, term, ranked)


def weighed(
    search: Search, null: Trial, best: Trial, curves: list[tuple[unlisted.Term, Trial]], trials: list[Trial]
) -> Choice:
    """The best names as they are, or where they only stand in for something else: its place, and in the model what
    leaves little enough.
    """
    place = stood_in_for(search, null, best)
    if place is None:
        return Choice(null, best, None, trials)
    if curves and curves[0][1].chi2 < best.chi2:  # a curve knows the place better than names
        term, best = curves[0]
        place = term.where, (term.variable,)
    if best.chi2 - 1 > STANDS_IN * (null.chi2 - 1):
        wandering = promises(search, null).wandering
        return Choice(null, null, None, trials, (wandering, ("t",)) if wandering else place)
    if unlisted.has_curve(best):
        return Choice(null, best, curves[0][0], trials)
    return Choice(null, best, None, trials, place)


def _held(search: Search, choice: Choice) -> Choice:
    """The choice if it does better on windows held out of the fit; else the declared law, and a place at most."""
    if not choice.trial.names:
        return choice
    held = ev.held_out(choice.null, choice.trial)
    if held < 1.0:
        return replace(choice, held=held)
    place = place_of(search, choice.null, choice.trial) if choice.null.excess > CLEAN else None
    return Choice(choice.null, choice.null, None, choice.trials, place)


def stood_in_for(search: Search, null: Trial, best: Trial) -> tuple[str, tuple[str, ...]] | None:
    """Place of what the names only stand in for: it acts most like the one of them that explains most by itself."""
    rest = best.chi2 - 1
    if rest < LEFT_OVER or rest < SHARE_LEFT * (null.chi2 - 1):
        return None
    rivals = [
        t.chi2 - 1
        for t in search.tried.values()
        if len(t.names) == len(best.names) and set(t.names) != set(best.names)
    ]
    if rivals and rest < DISTINCT * min(rivals):  # what is left is in the details: no other names come near
        return None
    alone = {name: search.tried.get((name,)) for name in best.names}
    kind = CATALOGUE[min(alone, key=lambda name: np.inf if (one := alone[name]) is None else one.fit.cost)]
    return kind.where, kind.depends_on


def _surpasses(curve: Trial, named: Trial) -> bool:
    """Does a learned curve do clearly better than the best of the named, pairs too?

    It leaves less than half. Or it is within the noise and far more likely, and they leave more than a sampling error;
    a curve at the place and in the variable of the name has that for a special case, and need only be more likely. A
    peak as wide as all slip is none, and gives way to a curve that does as well.
    """
    if curve.bic < named.bic - MARGIN and curve.chi2 - 1 < BETTER * max(named.chi2 - 1, 1e-9):
        return True
    if curve.excess >= CLEAN:
        return False
    alike = _curve_for(named) in curve.names
    if alike and _wide(named):
        return True
    return named.excess > DOUBTFUL and curve.bic < named.bic - (MARGIN if alike else DECISIVE)


def _curve_for(named: Trial) -> str:
    """Name of the curve that has a single name for a special case; none for several."""
    kind = CATALOGUE[named.names[0]] if len(named.names) == 1 and named.names[0] in CATALOGUE else None
    return "" if kind is None or len(kind.depends_on) != 1 else f"tabulated_{kind.where}_{kind.depends_on[0]}"


def _wide(named: Trial) -> bool:
    """Is it a Stribeck peak at the greatest width that one may have?"""
    if named.names != ("stribeck_peak",):
        return False
    return named.model.parameters["stribeck_peak.v_s"] > WIDE * sought("stribeck_peak.v_s")[1]
