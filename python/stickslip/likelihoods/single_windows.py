"""Windows each alone, the shared numbers held: polished, sought anew, and what one says of its own numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.fit_state import BLANK, Cost, Fit, Windowed, misfits
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.shown_levels import shown_levels

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
HIDDEN = 1.0  # squares over the noise that a usual static friction moves the readings by: they do not show it
SHIFTS = (0.0, 0.0, 0.03, -0.03, -0.08)  # static friction that a lost window is sought anew with
LET_GO = 0.005 * np.array([*range(-12, 0), *range(1, 13)])  # and one that is lost all the same


def polished(fit: Fit, cost: Cost, own: Floats, select: Mask, turns: int) -> Floats:
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
        better = select & (then < now) & stand(blocks, new)
        done = better & (now - then < 0.3)
        own[better], damping[better] = trial[better], np.maximum(damping[better] / 10, 1e-6)
        now = np.where(better, then, now)
        blocks = [n if b else a for a, n, b in zip(blocks, new, better, strict=True)]
        damping[select & ~better] *= 10
        select &= ~done & (damping < 1e6)
        if not select.any():
            break
    return own


def stand(was: Sequence[Floats | None], now: Sequence[Floats | None]) -> Mask:
    """Whether each window still can be simulated, (w,): one that moves far off the readings beats one that cannot."""
    return np.array([a is None or b is not None for a, b in zip(was, now, strict=True)])


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


def rescued(fit: Fit) -> Fit:
    """The fit with its worst windows sought anew from several starts of their own."""
    assert fit.linear is not None
    windows = fit.windows
    cost = Cost(fit, fit.population, fit.noise)
    _, unlike = cost.of(fit.blocks, fit.own)  # one that fits by friction like no other's is lost, too
    per = (misfits(fit) + unlike) / np.maximum(fit.windows.sizes * windows.channels, 1)
    limit = max(1.5 * float(np.median(per)), 1.3)
    lost = per > limit
    if not lost.any():
        return fit
    best, least = fit.own.copy(), np.add(*cost.of(fit.blocks, fit.own))
    fresh = windows.first(fit.at)
    shown = shown_levels(windows, fit.at)
    near, q = _neighbours(windows, lost), windows.begins
    starts = [*SHIFTS, 0.0] if shown is not None else SHIFTS
    for number, shift in enumerate(starts):
        trial = fit.own.copy()
        trial[lost, :q] = fresh[lost, :q]
        if shown is not None and number == len(SHIFTS):
            trial[lost] = shown[lost]
        for i in np.flatnonzero(lost).tolist() if number < len(SHIFTS) else ():
            trial[i, q:] = 0.0 if number == 0 or not near[i] else fit.own[near[i], q:].mean(0)
            trial[i, [q + one for one in windows.statics]] += shift
        trial = polished(fit, cost, trial, lost, 8)
        made = windows.blocks(fit.at, trial, lost, shared=(), local=False)
        found = np.add(*cost.of(made, trial))
        better = lost & (found < least) & stand(fit.blocks, made)
        best[better], least[better] = trial[better], found[better]
    still = lost & (least > limit * np.maximum(windows.sizes * windows.channels, 1))
    return replace(fit, own=_let_go(fit, cost, best, least, still) if still.any() else best)


def _let_go(fit: Fit, cost: Cost, own: Floats, least: Floats, lost: Mask) -> Floats:
    """
    Own numbers with static friction of lost windows sought over all that is usual.

    When a contact lets go decides what follows, and readings that jump there have no slope that says so.
    """
    windows = fit.windows
    statics = windows.begins + np.array(windows.statics, dtype=np.int64)
    if not len(statics):
        return own
    found, nearest = least.copy(), own.copy()
    for shift in LET_GO:
        trial = own.copy()
        trial[np.ix_(lost, statics)] += shift
        blocks = windows.blocks(fit.at, trial, lost, shared=(), local=False)
        made = np.add(*cost.of(blocks, trial))
        better = lost & (made < found) & stand(fit.blocks, blocks)
        nearest[better], found[better] = trial[better], made[better]
    moved = found < least
    if not moved.any():
        return own
    trial = polished(fit, cost, nearest, moved, 8)
    made = np.add(*cost.of(windows.blocks(fit.at, trial, moved, shared=(), local=False), trial))
    return np.where((moved & (made < found))[:, None], trial, nearest)


def lifted(fit: Fit) -> Fit:
    """
    The fit with static friction sought above where it acts, in windows that do not show it.

    A static limit below the friction of the slip that follows lets go with that, whatever it is itself. There it has no
    slope to come back by, and the curve of the slip takes what a larger one does.
    """
    windows = fit.windows
    places = windows.begins + np.array(windows.statics, dtype=np.int64)
    columns = len(windows.numbers) + places
    shown = np.array(
        [np.inf if block is None else float((block[:, :, columns] ** 2).sum()) for block in fit.blocks]
    )
    hidden = shown * windows.policy.static_sd**2 < HIDDEN
    if not hidden.any():
        return fit
    cost = Cost(fit, fit.population, fit.noise)
    trial = fit.own.copy()
    trial[np.ix_(hidden, places)] = windows.policy.static_sd
    trial = polished(fit, cost, trial, hidden, 8)
    least = np.add(*cost.of(fit.blocks, fit.own))
    found = np.add(*cost.of(windows.blocks(fit.at, trial, hidden, shared=(), local=False), trial))
    better = hidden & (found < least)
    return replace(fit, own=np.where(better[:, None], trial, fit.own)) if better.any() else fit


def _neighbours(windows: Windowed, lost: Mask) -> dict[int, list[int]]:
    """The three nearest windows of the same run that are not lost, for each that is."""
    out = {}
    for i in np.flatnonzero(lost):
        same = [j for j in windows.by_run[windows.runs[i]] if not lost[j]]
        out[int(i)] = sorted(same, key=lambda j: abs(j - i))[:3]
    return out


def settled(fit: Fit, turns: int = 2) -> tuple[Floats, Floats, Floats]:
    """Return own numbers once each window has settled alone, chi-squared of each, and its cost with the scatter's."""
    cost = Cost(fit, fit.population, fit.noise)
    own = polished(fit, cost, fit.own, np.ones(len(fit.own), dtype=bool), turns)
    left, held = cost.of(fit.windows.blocks(fit.at, own, shared=(), local=False), own)
    return own, left, left + held


def window_posterior(fit: Fit, policy: Policy) -> tuple[Floats, Floats] | None:
    """
    Return what the readings say of the numbers of one window alone: (own,) and their covariance; None where it fails.

    Parameters
    ----------
    fit : of one window, its population and noise known
    policy : what steers it
    """
    cost = Cost(fit, fit.population, fit.noise)
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
