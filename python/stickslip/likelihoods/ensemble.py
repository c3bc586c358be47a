"""Forecasts as distributions: many runs of a model, each with friction and a belt of its own from event to event.

What scatters, and by how much, the past says: its windows are fitted with random effects. A run to come begins where
the last window of the past ends, its state and its own friction drawn from what that window leaves open; whenever the
block sticks again, the friction of its next event is drawn, correlated with the last one as the past's events are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated
from stickslip.declared.model import Model
from stickslip.declared.scatter import EventScatter
from stickslip.fitted.data import Data
from stickslip.likelihoods.band import MEMBERS, SHOWN, band, standing
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit import fitted
from stickslip.likelihoods.fit_state import Fit, begin, unexplained
from stickslip.likelihoods.in_common import Common, in_common
from stickslip.likelihoods.members import ComingEvents, Members
from stickslip.likelihoods.memory import KINETIC, memory, of_effects
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.population import factor, population_of
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.stretches import Stretch, stretches, timed
from stickslip.likelihoods.symmetric_root import symmetric_root

Floats = NDArray[np.float64]
AGES = "static_aging"
YIELDS = "contact_compliance"  # under it nothing sticks, and no window begins


@dataclass(frozen=True)
class Distribution:
    """
    Readings to come.

    Parameters
    ----------
    mean, low, high : (n, channels) expected readings, and the band that holds 95 % of the readings to come
    """

    mean: Floats
    low: Floats
    high: Floats


def distribution(
    model: Model, run: Data, sensors: Sensors, future: Floats, seed: int = 0
) -> Distribution | None:
    """
    Return the readings that follow a run; None where its windows do not tell.

    Parameters
    ----------
    model : with the phases of this run
    run : the past
    sensors : of the rig
    future : (n,) times after the past's, in its time
    seed : of the draws
    """
    cut = [one for one in stretches([run]) if one.stuck]  # where it next sticks is known
    known = model.scatter if len(cut) < POLICY.fewest_windows else None  # so few do not tell it
    if len(cut) < (SHOWN if known is None else 1) or not _has_windows(model):
        return None
    try:
        fit = _fitted(begin(BeltWindows(model, [run], cut, [], Declared(), sensors, POLICY)), known)
        if any(one.name == AGES for one in model.effects):  # for as long as sticks last, which the fit knows
            cut = timed(cut, fit.windows.motions(fit.at, fit.own))
            again = BeltWindows(model, [run], cut, [], Declared(), sensors, POLICY)
            fit = _fitted(replace(begin(again), own=fit.own), known)
    except (FloatingPointError, np.linalg.LinAlgError):
        return None
    # no model of these windows: its scatter is that of something else
    if unexplained(fit) > POLICY.noise_left:
        return None
    try:
        shared = in_common(fit, POLICY) if known is None else None
    except (FloatingPointError, np.linalg.LinAlgError):
        shared = None
    if shared is not None:
        fit = shared.fit
    windows = fit.windows
    assert isinstance(windows, BeltWindows)
    cut = timed(cut, windows.motions(fit.at, fit.own))
    last = cut[-1]
    rest = float(np.median([one.rest for one in cut]))
    tail = Stretch(0, last.stop, len(run.t), last.dwell, rest)
    rng = np.random.default_rng(seed)
    events, common = _events(fit, shared, rng) if known is None else _of_others(fit, rng)
    members = Members(windows, fit.at, _extended(run, future), events, rest, rng)
    expected = common + events.memory.mean(axis=0) * (fit.random[-1] - common)
    own = members.begun(tail, fit.population, fit.noise, expected)
    if own is None:
        return None
    whole = members.run(own, tail, len(run.t) + len(future)).readings[:, len(run.t) - tail.start :]
    return _summed(whole, run, fit, rng)


def _fitted(first: Fit, known: EventScatter | None) -> Fit:
    """The windows of a past at their best; where its scatter is `known` from other runs, with that."""
    if known is None:
        return fitted(first, POLICY)
    return fitted(replace(first, population=population_of(known)), POLICY, held=POLICY.most_steps)


def _of_others(fit: Fit, rng: np.random.Generator) -> tuple[ComingEvents, Floats]:
    """What other runs show of the events to come, whose mean event is the law's."""
    _, like = of_effects(fit, MEMBERS, rng)
    none = np.zeros(fit.windows.effects)
    root = factor(fit.population, fit.windows.places)[0]
    return ComingEvents(root, like, np.tile(none, (MEMBERS, 1)), np.ones(MEMBERS)), none


def _has_windows(model: Model) -> bool:
    """Whether windows have a place for its effects: beside their own friction for one curve of the motion."""
    curves = [one for one in model.effects if isinstance(one, Tabulated)]
    taken = len(curves) > 1 or any(one.of_reading for one in curves)
    return not taken and all(one.name != YIELDS for one in model.effects)


def _events(fit: Fit, shared: Common | None, rng: np.random.Generator) -> tuple[ComingEvents, Floats]:
    """What a past shows of the events to come, and what its own have in common."""
    found, _ = memory(fit, KINETIC)
    # the past tells correlations poorly: every member has some that may be the true ones
    _, like = of_effects(fit, MEMBERS, rng)
    root = factor(fit.population, fit.windows.places)[0]
    if shared is not None:
        n = len(fit.random)
        wide = np.sqrt(n / rng.chisquare(n - 1, MEMBERS))
        size = len(shared.covariance)
        doubt = rng.standard_normal((MEMBERS, size)) @ symmetric_root(shared.covariance)
        # events that are alike, and scatter more than they seem to, tell less of what they have in common
        more = np.sqrt(np.maximum(wide**2 * (1 + found) / (1 - found) - 1, 0.0) / n)
        drawn = more[:, None] * (rng.standard_normal((MEMBERS, root.shape[1])) @ root.T)
        return ComingEvents(root, like, doubt + drawn, wide, ahead=_ahead(shared, rng)), np.zeros(size)
    # the law is that of other runs: what the events of this one have in common is known from them alone
    count = len(fit.random) * (1 - found) / (1 + found)
    # so few events tell their standard deviation roughly: each member has one that they may come from
    wide = np.sqrt(len(fit.random) / rng.chisquare(len(fit.random), MEMBERS))
    spread = wide[:, None] * (rng.standard_normal((MEMBERS, root.shape[1])) @ root.T)
    common = fit.random.mean(axis=0)
    return ComingEvents(root, like, common + spread / math.sqrt(max(count, 1.0)), wide), common


def _ahead(shared: Common, rng: np.random.Generator) -> Floats | None:
    """By how much x1 is ahead of the model over an event, of each member."""
    n = len(shared.ahead)
    if n < SHOWN:
        return None
    doubt = float(np.std(shared.ahead, ddof=1)) / math.sqrt(n)
    return np.asarray(shared.ahead.mean() + doubt * rng.standard_t(n - 1, MEMBERS))


def _summed(whole: Floats, run: Data, fit: Fit, rng: np.random.Generator) -> Distribution | None:
    """Mean and band of the members (m, n, channels), noise of the readings included."""
    members = standing(whole)
    if members is None:
        return None
    low, high = band(members, run.noise * np.sqrt(np.maximum(fit.noise, 1.0)), rng)
    return Distribution(members.mean(axis=0), low, high)


def _extended(run: Data, future: Floats) -> Data:
    """The run with times to come, at which nothing is read."""
    n, c = len(future), run.readings.shape[1]
    pad = np.zeros((n, c))
    return replace(
        run,
        t=np.concatenate([run.t, future]),
        readings=np.concatenate([run.readings, pad]),
        weight=np.concatenate([run.weight, pad]),
        v=np.concatenate([run.v, np.zeros(n)]),
        held=np.concatenate([run.held, np.zeros((n, c), dtype=bool)]),
    )
