"""What the events of a run have in common that its model lacks, told apart from what differs between them.

A law that is a little off, or a sensor that is none of the model's, makes every event differ from the model alike. As
scatter it would be drawn anew at every event to come.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit import ALONE, LAST_TURNS, fitted
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.members import with_windows
from stickslip.likelihoods.mixed import WindowProducts
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import Population, factor
from stickslip.likelihoods.single_windows import settled
from stickslip.likelihoods.variances import PopulationEstimate, estimate
from stickslip.simulated.states import X1

Floats = NDArray[np.float64]
ROUNDS = 2  # fits about what was found in common: the windows are linear near it
EXACT = 1e-12  # variance, on the diagonal, of effects that are none


@dataclass(frozen=True)
class Common:
    """
    A fit whose random effects are counted from what its windows have in common.

    Parameters
    ----------
    fit : the fit; its windows hold what is in common
    covariance : (effects, effects) of what is in common
    ahead : (k,) by how much x1 is ahead of the model where the next event begins, of events that follow one another
    """

    fit: Fit
    covariance: Floats
    ahead: Floats


def in_common(fit: Fit, policy: Policy) -> Common | None:
    """
    Return the fit about what its windows have in common; None where that is nothing worth its numbers.

    Parameters
    ----------
    fit : of the windows of one run, without shared numbers, at its best
    policy : what steers a fit
    """
    windows = fit.windows
    assert isinstance(windows, BeltWindows)
    if windows.loose:  # windows that begin in slips have not their belts told from their states
        return None
    prior, alone = _covariance(fit), _alone(fit, policy)
    least, found = min(alone.deviance, fit.deviance) - alone.held, _solved(fit, prior, policy)
    likely = _unlikely(fit, found, prior, first=True) < least
    for _ in range(ROUNDS):
        if not likely:
            return None
        fit = fitted(_about(fit, found), policy, held=0)
        found = _solved(fit, prior, policy)
        likely = _unlikely(fit, found, prior, first=False) < least
    if not likely:
        return None
    covariance = np.zeros((fit.windows.effects,) * 2)
    covariance[np.ix_(_lasting(windows), _lasting(windows))] = found.solution.covariance
    return Common(fit, covariance, _ahead(fit))


def _alone(fit: Fit, policy: Policy) -> PopulationEstimate[Population]:
    """Scatter and noise with nothing in common."""
    assert fit.linear is not None
    nothing = np.zeros(0), np.zeros((0, 0))
    return estimate(
        fit.linear, fit.windows.places, fit.population, fit.noise, nothing, fit.random, policy, LAST_TURNS
    )


def _unlikely(fit: Fit, found: PopulationEstimate[Population], prior: Floats, first: bool) -> float:
    """-2 log of the evidence: what is in common integrated over what one event's scatter would let it be."""
    windows = fit.windows
    assert isinstance(windows, BeltWindows)
    spread = float(np.linalg.slogdet(found.solution.covariance)[1] - np.linalg.slogdet(prior)[1])
    if first:
        return found.deviance - spread
    held = windows.common[_lasting(windows)]
    return fit.deviance + float(held @ np.linalg.solve(prior, held)) - spread


def _ahead(fit: Fit) -> Floats:
    """By how much x1 is ahead of what events alike make of it, (k,).

    Windows begin anew: what friction cannot explain may leave each a little early or late, and a run would add that up.
    """
    windows, own = fit.windows, fit.own.copy()
    assert isinstance(windows, BeltWindows)
    own[:, windows.begins :] = 0.0
    own, *_ = settled(replace(fit, own=own, population=fit.population.without()), ALONE)
    own[:, windows.begins :] = 0.0
    every, last = windows.stretches, len(windows.data[0].t)
    longer = [replace(one, stop=min(one.stop + 1, last)) for one in every]
    motions = with_windows(windows, longer, windows.data[0]).motions(fit.at, own)
    place = list(windows.sensors.begins).index(X1)
    out = [
        own[i + 1, place] - motion.state[-1, X1]
        for i, motion in enumerate(motions[:-1])
        if motion is not None and every[i + 1].start == every[i].stop and every[i + 1].stuck
    ]
    return np.array(out)


def _covariance(fit: Fit) -> Floats:
    """The covariance of what events may have in common, if it were one event's scatter."""
    assert isinstance(fit.windows, BeltWindows)
    root = factor(fit.population, fit.windows.places)[0][_lasting(fit.windows)]
    return np.asarray(root @ root.T + EXACT * np.eye(len(root)))


def _solved(fit: Fit, prior: Floats, policy: Policy) -> PopulationEstimate[Population]:
    """Scatter and noise beside a step of what is in common, as the shared numbers."""
    windows, linear = fit.windows, fit.linear
    assert isinstance(windows, BeltWindows)
    assert linear is not None
    return estimate(
        _with_common(linear, _lasting(windows)),
        windows.places,
        fit.population,
        fit.noise,
        (-windows.common[_lasting(windows)], np.asarray(np.linalg.inv(prior), dtype=np.float64)),
        fit.random,
        policy,
        LAST_TURNS,
    )


def _with_common(linear: WindowProducts, which: list[int]) -> WindowProducts:
    """The windows with some effects as shared numbers, too."""
    columns = np.array([*(linear.own + i for i in which), *range(linear.own + linear.effects + 1)])
    return replace(linear, gram=linear.gram[:, :, columns[:, None], columns], shared=len(which))


def _lasting(windows: BeltWindows) -> list[int]:
    """
    The effects that events may have in common.

    A belt does not know when windows begin: its waves are their own. Where an effect moves the belt, its mean makes up
    for what a window does not know of the belt's state at its start.
    """
    moved = any(one.where == "belt" for one in windows.model.effects)
    belt = [] if moved or windows.belt is None else [windows.belt]
    return [*windows.statics, *windows.kinetics[0], *belt]


def _about(fit: Fit, found: PopulationEstimate[Population]) -> Fit:
    """The fit a step on, its windows about what they were found to have in common."""
    was = fit.windows
    assert isinstance(was, BeltWindows)
    common = was.common.copy()
    common[_lasting(was)] += found.solution.shared
    windows = with_windows(was, was.stretches, was.data[0], common)
    own = fit.own.copy()
    own[:, : windows.begins] += found.solution.own
    own[:, windows.begins :] = found.solution.effects
    return replace(fit, windows=windows, own=own, population=found.population, noise=found.noise)
