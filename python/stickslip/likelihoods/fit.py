"""The fit of a hypothesis to windows: linearise, solve, step, and let the population follow (Lindstrom and Bates 1990).

A window that a step makes worse is polished alone; one that has landed on the wrong side of a transition is sought
anew from several starts; one that still does not fit counts by the logarithm of its chi-squared.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.mixed import Solution, Windows, products, solve, taken
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import Population, factor, start
from stickslip.likelihoods.shown_levels import shown_levels
from stickslip.likelihoods.variances import Estimate, estimate

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
STEPS = (1.0, 0.4, 0.1)
LOST = 100.0  # chi-squared per reading of a window that cannot be simulated
WORSE = (5.0, 0.02)  # growth of a window's cost, absolute and relative, from which it is polished alone
SHIFTS = (0.0, 0.0, 0.03, -0.03, -0.08)  # static friction that a lost window is sought anew with
LAST_TURNS = 40  # of it at the end of a fit
TURNS = 6  # of the population's optimiser in a step
BLANK = 1e-9
UNSETTLED = 2.0  # chi-squared per reading in the median window from which a fit may have failed
ALONE = 15  # steps of each window alone before all are fitted
WIDE = 10.0  # times the usual scatter


@dataclass
class Fit:
    """
    Where a fit stands.

    Parameters
    ----------
    windows : what is fitted
    at : (p,) coordinates of the shared numbers
    own : (w, own) the windows' own numbers
    population, noise : variances; noise is a factor of the declared variance, by channel
    linear : windows linearised there, weighted
    estimate : what they say of the population, None before the end
    knee : (w,) chi-squared beyond which a window counts by its logarithm
    steps : taken
    """

    windows: BeltWindows
    at: Floats
    own: Floats
    population: Population
    noise: Floats
    knee: Floats
    linear: Windows | None = None
    blocks: list[Floats | None] = field(default_factory=list, repr=False)
    deviance: float = np.inf
    solution: Solution | None = None
    steps: int = 0

    @property
    def freedom(self) -> Floats:
        """How many readings' worth of noise the windows' own numbers explain, by channel."""
        assert self.linear is not None
        assert self.solution is not None
        return taken(self.linear, factor(self.population, self.windows.places), self.solution, self.noise)

    @property
    def random(self) -> Floats:
        """Random effects of the windows, (w, effects)."""
        return self.own[:, self.windows.begins :]

    def values(self, run: int = 0) -> dict[str, float]:
        """Numbers of a run by name."""
        return self.windows.values(self.at, run)


def begin(windows: BeltWindows) -> Fit:
    """Return a fit at the declared numbers."""
    policy, count = windows.policy, len(windows.stretches)
    at = np.array([one.start for one in windows.numbers])
    return Fit(windows, at, windows.first(), start(policy), np.ones(windows.channels), np.full(count, np.inf))


def null(windows: BeltWindows, policy: Policy) -> Fit:
    """
    Return the fit from the declared numbers.

    One that leaves much is begun again with friction as each window shows it by itself, where its readings do, and
    with scatter to take it.
    """
    fit = fitted(begin(windows), policy)
    if unexplained(fit) < UNSETTLED or (shown := shown_levels(windows)) is None:
        return fit
    p = start(policy)
    wide = replace(p, level=WIDE * p.level, curve=WIDE * p.curve, static=WIDE * p.static)
    again = replace(begin(windows), population=wide, own=shown)
    again = fitted(replace(again, own=settled(again, ALONE)[1]), policy)
    return min(fit, again, key=lambda one: one.deviance)


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
    damping, calm = 0.0, 0
    for step in range(most):
        fit = _linearised(fit, policy)
        if step in (3, 7, 11, 15):
            sought = _rescued(fit)
            if sought is not fit:
                fit = _linearised(sought, policy)
        trial, cost = _stepped(fit, policy, damping, free=step >= held)
        if trial is None:
            damping = max(damping * 10, 1e-2)
            if damping > 10:
                break
            continue
        damping = damping / 10 if damping > 1e-5 else 0.0
        fit = replace(trial, steps=step + 1)
        calm = calm + 1 if cost < policy.settled else 0
        if calm and step > held:
            break
    return closed(fit, policy)


def closed(fit: Fit, policy: Policy) -> Fit:
    """
    Return the fit linearised where it stands, with its population and deviance.

    The deviance is that of the windows as simulated. Where a fit has not settled, what the linearised windows promise
    of a further step is no likelihood; that step is taken if it holds.
    """
    here = _linearised(fit, policy)
    moved = _moved(here, _estimate(here, policy, LAST_TURNS), policy)
    stayed = _valued(here, _estimate(here, policy, 0))
    return min(moved, stayed, key=lambda one: one.deviance)


def _moved(fit: Fit, found: Estimate, policy: Policy) -> Fit:
    """The fit a whole step on, under another population."""
    assert fit.linear is not None
    solution = found.solution
    low, high = (np.array([getattr(n, k) for n in fit.windows.numbers]) for k in ("low", "high"))
    own = fit.own.copy()
    begins = fit.windows.begins
    own[:, :begins] += solution.own
    own[:, begins:] = solution.effects
    at = np.clip(fit.at + solution.shared, low, high)
    there = replace(fit, at=at, own=own, population=found.population, noise=found.noise)
    blocks = fit.windows.blocks(at, own, shared=(), local=False)
    if sum(b is None for b in blocks) > sum(b is None for b in fit.blocks):
        return replace(there, deviance=np.inf)
    there = _linearised(there, policy)
    return _valued(there, _estimate(there, policy, 0))


def _valued(fit: Fit, found: Estimate) -> Fit:
    """The fit with its deviance: the cost of the windows as simulated, their own numbers integrated."""
    cost = _Cost(fit, fit.population, fit.noise)
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
    chi, count = _chi(fit), np.maximum(linear.count.sum(1), 1)
    good = linear.weight > 0
    middle = max(float(np.median(chi[good] / count[good])), 1.0)
    sizes = windows.sizes * windows.channels
    knee = policy.knee * middle * sizes
    weight = np.where(good, np.minimum(1.0, knee / np.maximum(chi, 1e-9)), 0.0)
    return replace(fit, linear=replace(linear, weight=weight), knee=knee)


def _chi(fit: Fit) -> Floats:
    """Chi-squared by window where it is linearised; of one that failed, a large one."""
    assert fit.linear is not None
    chi = fit.linear.gram[:, :, -1, -1] @ (1.0 / fit.noise)
    lost = np.array([b is None for b in fit.blocks])
    return np.where(lost, LOST * fit.windows.sizes, chi)


def unexplained(fit: Fit) -> float:
    """Return chi-squared per reading of the median window, over the noise that is declared or seen."""
    chi = _chi(replace(fit, noise=np.ones(fit.windows.channels)))
    return float(np.median(chi / (fit.windows.sizes * fit.windows.channels)))


def _soft(chi: Floats, knee: Floats) -> Floats:
    return np.where(chi > knee, knee * (1 + np.log(np.maximum(chi / knee, 1.0))), chi)


def _estimate(fit: Fit, policy: Policy, turns: int) -> Estimate:
    assert fit.linear is not None
    prior = fit.windows.prior.at(fit.at)
    return estimate(
        fit.linear, fit.windows.places, fit.population, fit.noise, prior, fit.random, policy, turns
    )


class _Cost:
    """Penalised cost of windows at a population."""

    def __init__(self, fit: Fit, population: Population, noise: Floats) -> None:
        self.fit, self.noise = fit, noise
        roots = factor(population, fit.windows.places)
        covariance = roots @ roots.transpose(0, 2, 1)
        e = covariance.shape[1]
        # a scatter that is nothing holds its effects where they are
        self.inverse = np.linalg.inv(covariance + BLANK * np.eye(e))[fit.windows.runs]

    def of(self, blocks: list[Floats | None], own: Floats) -> tuple[Floats, Floats]:
        """Chi-squared and penalty of each window."""
        chi = np.array(
            [
                LOST * size if b is None else float((b[:, :, -1] ** 2).sum(0) @ (1.0 / self.noise))
                for b, size in zip(blocks, self.fit.windows.sizes, strict=True)
            ]
        )
        u = own[:, self.fit.windows.begins :]
        return _soft(chi, self.fit.knee), np.einsum("wi,wij,wj->w", u, self.inverse, u)

    def total(self, blocks: list[Floats | None], own: Floats, at: Floats) -> tuple[Floats, float]:
        """Cost by window, and of all with the prior."""
        chi, held = self.of(blocks, own)
        each = chi + held
        return each, float(each.sum()) + self.fit.windows.prior.penalty(at)


def _stepped(fit: Fit, policy: Policy, damping: float, free: bool) -> tuple[Fit | None, float]:
    """The fit a step on and the cost that it saves; None where no step saves any."""
    assert fit.linear is not None
    windows = fit.windows
    found = _estimate(fit, policy, TURNS if free else 0)
    population, noise = found.population, found.noise
    if not free:
        noise = _freed_noise(fit, found)
    roots = factor(population, windows.places)
    prior = windows.prior.at(fit.at)
    solution = solve(fit.linear, roots, noise, *prior, fit.random, damping)
    cost = _Cost(fit, population, noise)
    each, now = cost.total(fit.blocks, fit.own, fit.at)
    stride = np.array([n.stride for n in windows.numbers])
    share = min(1.0, float(np.min(stride / np.maximum(np.abs(solution.shared), 1e-12), initial=np.inf)))
    low, high = (np.array([getattr(n, k) for n in windows.numbers]) for k in ("low", "high"))
    for size in STEPS:
        at = np.clip(fit.at + size * share * solution.shared, low, high)
        own = fit.own.copy()
        own[:, : windows.begins] += size * share * np.clip(solution.own, -1, 1)
        own[:, windows.begins :] += size * share * np.clip(solution.effects - fit.random, -1, 1)
        blocks = windows.blocks(at, own, shared=(), local=False)
        new, then = cost.total(blocks, own, at)
        worse = new > each + WORSE[0] + WORSE[1] * each
        if worse.any() and (worse.sum() < 0.5 * len(worse) or size == STEPS[-1]):
            own[worse] = fit.own[worse]
            own = polished(replace(fit, at=at), cost, own, worse, 3)
            again = windows.blocks(at, own, worse, shared=(), local=False)
            blocks = [b if w else a for a, b, w in zip(blocks, again, worse, strict=True)]
            new, then = cost.total(blocks, own, at)
        if then < now - 1e-3:
            return replace(fit, at=at, own=own, population=population, noise=noise), now - then
    return None, 0.0


def _freed_noise(fit: Fit, found: Estimate) -> Floats:
    """The noise's factors from what is left and what the windows' own numbers take of it."""
    assert fit.linear is not None
    count = (fit.linear.count * fit.linear.weight[:, None]).sum(0)
    left = found.solution.misfit.sum(0)
    roots = factor(fit.population, fit.windows.places)
    free = np.maximum(count - taken(fit.linear, roots, found.solution, fit.noise), 1.0)
    return np.clip(np.where(count > 0, left / free, 1.0), 0.3, 1e4)


def polished(fit: Fit, cost: _Cost, own: Floats, select: Mask, turns: int) -> Floats:
    """Return own numbers after Levenberg's steps of the selected windows, each alone."""
    windows, own, select = fit.windows, own.copy(), select.copy()
    damping = np.full(len(own), 1e-2)
    blocks = windows.blocks(fit.at, own, select, shared=())
    now = np.add(*cost.of(blocks, own))
    for _ in range(turns):
        trial = own.copy()
        for i in np.flatnonzero(select):
            if (block := blocks[i]) is not None:
                trial[i] += _local_step(block, own[i], cost.inverse[i], cost.noise, damping[i])
        new = windows.blocks(fit.at, trial, select, shared=())
        then = np.add(*cost.of(new, trial))
        better = select & (then < now)
        done = better & (now - then < 0.3)
        own[better], damping[better] = trial[better], np.maximum(damping[better] / 10, 1e-6)
        now = np.where(better, then, now)
        blocks = [n if b else a for a, n, b in zip(blocks, new, better, strict=True)]
        damping[select & ~better] *= 10
        select &= ~done & (damping < 1e6)
        if not select.any():
            break
    return own


def _local_step(block: Floats, own: Floats, inverse: Floats, noise: Floats, damping: float) -> Floats:
    q = len(own) - len(inverse)
    scaled = (block / np.sqrt(noise)[None, :, None]).reshape(-1, block.shape[2])
    gram = scaled[:, :-1].T @ scaled[:, :-1]
    pull = scaled[:, :-1].T @ scaled[:, -1]
    gram[q:, q:] += inverse
    pull[q:] -= inverse @ own[q:]
    diagonal = np.arange(len(gram))
    gram[diagonal, diagonal] = gram[diagonal, diagonal] * (1 + damping) + 1e-12
    return np.asarray(np.linalg.solve(gram, pull))


def _rescued(fit: Fit) -> Fit:
    """The fit with its worst windows sought anew from several starts of their own."""
    assert fit.linear is not None
    windows = fit.windows
    per = _chi(fit) / np.maximum(fit.windows.sizes * windows.channels, 1)
    lost = per > max(1.5 * float(np.median(per)), 1.3)
    if not lost.any():
        return fit
    cost = _Cost(fit, fit.population, fit.noise)
    best, least = fit.own.copy(), np.add(*cost.of(fit.blocks, fit.own))
    fresh = windows.first()
    near, q = _neighbours(windows, lost), windows.begins
    for number, shift in enumerate(SHIFTS):
        trial = fit.own.copy()
        trial[lost, :q] = fresh[lost, :q]
        for i in np.flatnonzero(lost).tolist():
            trial[i, q:] = 0.0 if number == 0 or not near[i] else fit.own[near[i], q:].mean(0)
            trial[i, q] += shift
        trial = polished(fit, cost, trial, lost, 8)
        found = np.add(*cost.of(windows.blocks(fit.at, trial, lost, shared=(), local=False), trial))
        better = lost & (found < least)
        best[better], least[better] = trial[better], found[better]
    return replace(fit, own=best)


def _neighbours(windows: BeltWindows, lost: Mask) -> dict[int, list[int]]:
    """The three nearest windows of the same run that are not lost, for each that is."""
    out = {}
    for i in np.flatnonzero(lost):
        same = [j for j in windows.by_run[windows.runs[i]] if not lost[j]]
        out[int(i)] = sorted(same, key=lambda j: abs(j - i))[:3]
    return out


def settled(fit: Fit, turns: int = 2) -> tuple[float, Floats]:
    """Return the cost of a start and its own numbers once each window has settled alone."""
    cost = _Cost(fit, fit.population, fit.noise)
    own = polished(fit, cost, fit.own, np.ones(len(fit.own), dtype=bool), turns)
    blocks = fit.windows.blocks(fit.at, own, shared=(), local=False)
    return cost.total(blocks, own, fit.at)[1], own


def events(fit: Fit, turns: int = 15) -> tuple[Floats, Floats]:
    """Return chi-squared of each window and its cost with the scatter's, once each has settled alone."""
    cost = _Cost(fit, fit.population, fit.noise)
    own = polished(fit, cost, fit.own, np.ones(len(fit.own), dtype=bool), turns)
    chi, held = cost.of(fit.windows.blocks(fit.at, own, shared=(), local=False), own)
    return chi, chi + held


def window_posterior(fit: Fit, policy: Policy) -> tuple[Floats, Floats] | None:
    """
    Return what the readings say of the numbers of one window alone: (own,) and their covariance; None where it fails.

    Parameters
    ----------
    fit : of one window, its population and noise known
    policy : what steers it
    """
    cost = _Cost(fit, fit.population, fit.noise)
    own = polished(fit, cost, fit.own, np.ones(1, dtype=bool), policy.most_steps)
    (block,) = fit.windows.blocks(fit.at, own, shared=())
    if block is None:
        return None
    scaled = (block / np.sqrt(fit.noise)[None, :, None]).reshape(-1, block.shape[2])
    gram = scaled[:, :-1].T @ scaled[:, :-1]
    begins = fit.windows.begins
    gram[begins:, begins:] += cost.inverse[0]
    gram[range(len(gram)), range(len(gram))] += BLANK
    return own[0], np.asarray(np.linalg.inv(gram), dtype=np.float64)
