"""The fit of a hypothesis to windows: linearise, solve, step, and let the population follow (Lindstrom and Bates 1990).

A window that a step makes worse is polished alone; one that has landed on the wrong side of a transition is sought
anew from several starts; one that still does not fit counts by the logarithm of its chi-squared.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.fit_state import Cost, Fit, Windowed, begin, misfits, unexplained
from stickslip.likelihoods.mixed import products, solve, taken
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import factor
from stickslip.likelihoods.repeating import beyond_shown, explained, lost, swollen
from stickslip.likelihoods.shown_levels import shown_levels, shown_scatter
from stickslip.likelihoods.single_windows import lifted, polished, rescued, settled, stand
from stickslip.likelihoods.variances import PopulationEstimate, estimate

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Each = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
STEPS = (1.0, 0.4, 0.1)
WORSE = (5.0, 0.02)  # growth of a window's cost, absolute and relative, from which it is polished alone
LAST_TURNS = 40  # of it at the end of a fit
TURNS = 6  # of the population's optimiser in a step
ALONE = 15  # steps of each window alone before all are fitted
WIDE = 10.0  # times the usual scatter
ROUNDS = 4  # of a fit of laws with states that ran out of steps


def null(windows: Windowed, policy: Policy, twice: bool = False, each: Each = map) -> Fit:
    """
    Return the fit from the declared numbers.

    Windows of a rig of bodies settle alone first: what is not read of where they begin is a guess. Where the readings
    of each window show its friction by themselves, a fit begins there, too, with as much scatter as they show. Where
    scatter takes all, so that nothing is left to see what lacks by, it is held at what they show, or as usual.

    Parameters
    ----------
    windows, policy : what is fitted, and what steers it
    twice : fit once more from scatter as usual, where the first has not settled or is no usual model of the windows,
        and keep the better: what a search calls lacking must not be what a fit missed. Scatter that is more than
        friction has, which may be what is lacking, is held as usual, too
    each : calls a function with every item, as `map` does; fits that do not wait for one another may be made at once

    """
    first = begun(windows)
    if isinstance(windows, BodiesWindows):
        fit = _of_bodies(first, policy)
        if not twice:
            return fit
    elif (shown := shown_levels(windows, first.at)) is not None:
        begun_there = replace(first, population=shown_scatter(windows, shown), own=shown)
        fit = _best_of_shown(first, begun_there, policy, twice, each)
        if unexplained(fit) >= policy.noise_left:
            return fit
    else:
        fit = _again(fitted(first, policy), policy, twice)
    hides = lost(fit) or (twice and beyond_shown(fit))
    return fitted(first, policy, held=policy.most_steps) if hides else fit


def _of_bodies(first: Fit, policy: Policy) -> Fit:
    """The fit of a rig of bodies; where it explains little, one from windows that settle alone may do better."""
    fit = fitted(first, policy)
    if unexplained(fit) >= policy.noise_left:
        fit = _best(fit, _alone_first(_wide(first), policy))
    windows = first.windows
    assert isinstance(windows, BodiesWindows)
    for _ in range(ROUNDS if windows.of_laws.count else 0):  # by stiff laws the way is long
        if fit.steps < policy.most_steps:
            break
        fit, before = _best(fit, fitted(fit, policy)), fit
        if fit.deviance > before.deviance - policy.noticed:
            break
    return fit


def _best_of_shown(first: Fit, shown: Fit, policy: Policy, twice: bool, each: Each) -> Fit:
    """The best of the fits from the declared numbers and from what the readings of each window show of friction."""
    fit, there = each(_called, (partial(fitted, first, policy), partial(_alone_first, shown, policy)))
    fits: list[Fit] = [_again(fit, policy, twice), there]
    if not explained(there) or swollen(there):  # a scatter that is free may take what a fit is short of
        held = policy.most_steps
        fits += each(
            _called, (partial(_alone_first, shown, policy, held), partial(fitted, shown, policy, held=held))
        )
    return min(fits, key=_lost_first)


def _again(fit: Fit, policy: Policy, twice: bool) -> Fit:
    """The fit, or the better one from scatter as usual where it may not be the best there is and `twice` is asked."""
    if not (twice and doubtful(fit, policy)):
        return fit
    return _best(fit, fitted(replace(fit, population=fit.windows.scatter()), policy))


def _lost_first(fit: Fit) -> tuple[bool, float]:
    return lost(fit), fit.deviance


def _called(fit: Callable[[], Fit]) -> Fit:
    """A fit that was put off."""
    return fit()


def _best(*fits: Fit) -> Fit:
    return min(fits, key=lambda one: one.deviance)


def _wide(first: Fit) -> Fit:
    """Windows of bodies as their readings show them, with scatter to take what a law that is far off leaves."""
    return replace(first, population=first.windows.scatter().wider(WIDE), own=first.windows.first())


def _alone_first(fit: Fit, policy: Policy, held: int | None = None) -> Fit:
    """The fit from windows that settle alone first: where a law is far off, they say so."""
    return fitted(replace(fit, own=settled(fit, ALONE)[0]), policy, held=held)


def doubtful(fit: Fit, policy: Policy) -> bool:
    """
    Whether a fit may not be the best there is.

    A scatter that was nothing on the way has no slope to come back by: from scatter as usual it would.
    """
    if fit.steps >= policy.most_steps or not explained(fit) or swollen(fit):
        return True
    usual = replace(fit, population=fit.windows.scatter())
    found = _estimate(usual, policy, LAST_TURNS)
    there = replace(usual, population=found.population, noise=found.noise)
    return _valued(there, found).deviance < fit.deviance - policy.settled


def begun(windows: Windowed) -> Fit:
    """Return a fit at the declared numbers; windows of a rig of bodies settle alone first."""
    first = begin(windows)
    return replace(first, own=settled(first, ALONE)[0]) if isinstance(windows, BodiesWindows) else first


def fitted(fit: Fit, policy: Policy, most: int | None = None, held: int | None = None) -> Fit:
    """
    Return the fit at its best.

    Parameters
    ----------
    fit : where to start
    policy : what steers it
    most : steps
    held : steps in which the population stays where it is
    """
    held = policy.held if held is None else held
    most = policy.most_steps if most is None else most
    fit, damping = replace(fit, at=fit.windows.bounded(fit.at)), 0.0
    moved, failed, free = True, False, False
    for step in range(most):
        free = free or step >= held
        if moved:
            fit = _linearised(fit, policy)
        if step in (3, 7, 11, 15):
            sought = lifted(rescued(fit))
            if sought is not fit:
                fit = _linearised(sought, policy)
        trial, cost, whole = _stepped(fit, policy, damping, free)
        moved = trial is not None
        if trial is not None:
            fit = replace(trial, steps=step + 1)
        little = cost < policy.settled
        if little and not whole:  # a step that holds in part alone says nothing of where the best is
            damping, failed = max(damping * 10, 1e-2), True
            if damping > 10:
                if free or held >= most:
                    break
                free, damping = True, 0.0  # with scatter as it is nothing is to be gained
            continue
        if not failed:  # what has just been needed is needed again
            damping = damping / 10 if damping > 1e-5 else 0.0
        failed = False
        if little and step > held:
            break
    return _closed(_linearised(fit, policy) if moved else fit, policy, LAST_TURNS if held < most else 0)


def closed(fit: Fit, policy: Policy, turns: int = LAST_TURNS) -> Fit:
    """
    Return the fit linearised where it stands, with its population and deviance.

    The deviance is that of the windows as simulated. Where a fit has not settled, what the linearised windows promise
    of a further step is no likelihood; that step is taken if it holds.
    """
    return _closed(_linearised(fit, policy), policy, turns)


def _closed(here: Fit, policy: Policy, turns: int) -> Fit:
    """See `closed`; the fit is linearised."""
    found = _estimate(here, policy, turns)
    moved = _moved(here, found, policy)
    stayed = _valued(here, _estimate(here, policy, 0))
    # a step that does not hold leaves what the windows say of their scatter where they stand
    known = replace(here, population=found.population, noise=found.noise)
    scattered = _valued(known, _estimate(known, policy, 0))
    return min(moved, scattered, stayed, key=lambda one: one.deviance)


def _moved(fit: Fit, found: PopulationEstimate[Any], policy: Policy) -> Fit:
    """The fit a whole step on, under another population."""
    assert fit.linear is not None
    solution = found.solution
    own = fit.own.copy()
    begins = fit.windows.begins
    own[:, :begins] += solution.own
    own[:, begins:] = solution.effects
    at = fit.windows.bounded(fit.at + solution.shared)
    there = replace(fit, at=at, own=own, population=found.population, noise=found.noise)
    blocks = fit.windows.blocks(at, own, shared=(), local=False)
    if sum(b is None for b in blocks) > sum(b is None for b in fit.blocks):
        return replace(there, deviance=np.inf)
    there = _linearised(there, policy)
    return _valued(there, _estimate(there, policy, 0))


def _valued(fit: Fit, found: PopulationEstimate[Any]) -> Fit:
    """The fit with its deviance: the cost of the windows as simulated, their own numbers integrated."""
    cost = Cost(fit, fit.population, fit.noise)
    _, total = cost.total(fit.blocks, fit.own, fit.at)
    deviance = total + found.solution.volume + found.held
    return replace(fit, deviance=deviance, solution=found.solution)


def _linearised(fit: Fit, policy: Policy) -> Fit:
    windows = fit.windows
    blocks = windows.blocks(fit.at, fit.own)
    if all(b is None for b in blocks):
        raise FloatingPointError("no window can be simulated")
    linear = products(blocks, windows.runs, len(windows.numbers), windows.begins, windows.channels)
    fit = replace(fit, linear=linear, blocks=blocks)
    chi, count = misfits(fit), np.maximum(linear.count.sum(1), 1)
    good = linear.weight > 0
    middle = max(float(np.median(chi[good] / count[good])), 1.0)
    sizes = windows.sizes * windows.channels
    knee = policy.knee * middle * sizes
    weight = np.where(good, np.minimum(1.0, knee / np.maximum(chi, 1e-9)), 0.0)
    return replace(fit, linear=replace(linear, weight=weight), knee=knee)


def _estimate(fit: Fit, policy: Policy, turns: int) -> PopulationEstimate[Any]:
    assert fit.linear is not None
    prior = fit.windows.prior.at(fit.at)
    return estimate(
        fit.linear,
        fit.windows.places,
        fit.population,
        fit.noise,
        prior,
        fit.random,
        policy,
        turns,
        fit.windows.steps(fit.at),
    )


def _stepped(fit: Fit, policy: Policy, damping: float, free: bool) -> tuple[Fit | None, float, bool]:
    """
    The fit a step on, the deviance that it saves, and whether the whole step does; None where none saves any.

    A population that is free may follow the linearised windows where the windows themselves do not: it moves with a
    step that lowers the deviance, its own part included, or where that fails without one, as far as scatter is usual.
    What is lacking would be taken by more: beside friction that scatters by a fifth no effect stands out.
    """
    stay = _estimate(fit, policy, 0)
    if not free:
        trial = _tried(fit, stay, _freed_noise(fit, stay), damping)
        return trial or (None, 0.0, False)
    here = _deviance(fit, stay)
    found = _estimate(fit, policy, TURNS)
    if (moved := _tried(fit, found, found.noise, damping, STEPS[:2], here)) is not None:
        return moved
    apart = _apart(fit, found, here, policy)
    if apart is None:
        trial = _tried(fit, stay, fit.noise, damping, STEPS, here)
        return trial or (None, 0.0, False)
    there, stay, saved = apart
    trial = _tried(there, stay, there.noise, damping, STEPS, here - saved)
    return (there, saved, False) if trial is None else (trial[0], saved + trial[1], trial[2])


def _deviance(fit: Fit, stay: PopulationEstimate[Any]) -> float:
    """The deviance of a fit where it stands; `stay` is how its windows are solved there."""
    _, total = Cost(fit, fit.population, fit.noise).total(fit.blocks, fit.own, fit.at)
    return total + stay.solution.volume + stay.held


def _apart(
    fit: Fit, found: PopulationEstimate[Any], here: float, policy: Policy
) -> tuple[Fit, PopulationEstimate[Any], float] | None:
    """The fit with population and noise on the way to others while its windows stay, as solved, and what that saves."""
    was, to = fit.population.coordinates(), found.population.coordinates()
    for size in STEPS:
        population = fit.population.moved(was + size * (to - was))
        there = replace(fit, population=population, noise=fit.noise * (found.noise / fit.noise) ** size)
        if swollen(there):
            continue
        stay = _estimate(there, policy, 0)
        if (saved := here - _deviance(there, stay)) > policy.settled:
            return there, stay, saved
    return None


def _tried(
    fit: Fit,
    found: PopulationEstimate[Any],
    noise: Floats,
    damping: float,
    sizes: Sequence[float] = STEPS,
    deviance: float | None = None,
) -> tuple[Fit, float, bool] | None:
    """The fit a step on under some population, what that saves of a deviance or a cost, and if the step is whole."""
    assert fit.linear is not None
    windows, population, solution = fit.windows, found.population, found.solution
    if damping or deviance is None:
        roots = factor(population, windows.places)
        prior = windows.prior.at(fit.at)
        solution = solve(fit.linear, roots, noise, *prior, fit.random, damping, windows.steps(fit.at))
    stride = np.array([n.stride for n in windows.numbers])
    share = min(1.0, float(np.min(stride / np.maximum(np.abs(solution.shared), 1e-300), initial=np.inf)))
    cost = Cost(fit, population, noise)
    each, now = cost.total(fit.blocks, fit.own, fit.at)
    least, added = (now, 0.0) if deviance is None else (deviance, found.solution.volume + found.held)
    for size in sizes:
        at = windows.bounded(fit.at + size * share * solution.shared)
        own = fit.own.copy()
        own[:, : windows.begins] += size * share * np.clip(solution.own, -1, 1)
        own[:, windows.begins :] += size * share * np.clip(solution.effects - fit.random, -1, 1)
        blocks = windows.blocks(at, own, shared=(), local=False)
        new, then = cost.total(blocks, own, at)
        worse = (new > each + WORSE[0] + WORSE[1] * each) | ~stand(fit.blocks, blocks)
        if worse.any() and (worse.sum() < 0.5 * len(worse) or size == sizes[-1]):
            alone = np.where(worse[:, None], fit.own, own)
            alone = polished(replace(fit, at=at), cost, alone, worse, 3)
            again = windows.blocks(at, alone, worse, shared=(), local=False)
            blocks = [b if w else a for a, b, w in zip(blocks, again, worse, strict=True)]
            other, _ = cost.total(blocks, alone, at)
            own = np.where((other < new)[:, None], alone, own)
            then += float(np.minimum(other - new, 0.0).sum())
        if then + added < least - 1e-3:
            there = replace(fit, at=at, own=own, population=population, noise=noise)
            return there, least - then - added, size == 1.0
    return None


def _freed_noise(fit: Fit, found: PopulationEstimate[Any]) -> Floats:
    """The noise's factors from what is left and what the windows' own numbers take of it."""
    assert fit.linear is not None
    count = (fit.linear.count * fit.linear.weight[:, None]).sum(0)
    left = found.solution.misfit.sum(0)
    roots = factor(fit.population, fit.windows.places)
    free = np.maximum(count - taken(fit.linear, roots, found.solution, fit.noise), 1.0)
    return np.clip(np.where(count > 0, left / free, 1.0), 0.3, 1e4)
