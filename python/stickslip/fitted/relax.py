"""Windows' own states at fixed unknowns: sought anew, and brought after a step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.engine import Block, Engine
from stickslip.fitted.window import Window, by_free, with_state
from stickslip.fitted.windows import slipping

Floats = NDArray[np.float64]


def relaxed(
    engine: Engine,
    vector: Floats,
    windows: Sequence[Window],
    steps: int = 8,
    before: Sequence[Window | None] | None = None,
) -> list[Window]:
    """The windows with their own states at their best for fixed unknowns.

    They are sought from where they are, from the readings around each window's start, from where the window `before`
    it ends, and in slip where they start in stick, until one of these leaves no more than the noise.
    """
    best, least = list(windows), np.full(len(windows), np.inf)
    used = [np.count_nonzero(engine.data[w.run].weight[w.start : w.stop]) for w in windows]
    enough = 1.1 * np.maximum(used, 1)
    for start in (_as_it_is, _as_measured, _as_ended, _as_slipping):
        at = np.flatnonzero(least >= enough).tolist()
        begun = start(engine, vector, [(windows[i], before[i] if before else None) for i in at])
        ready = [(i, w) for i, w in zip(at, begun, strict=True) if w is not None]
        found, costs = sought(engine, vector, [w for _, w in ready], steps)
        for (i, _), window, cost in zip(ready, found, costs.tolist(), strict=True):
            if cost < least[i]:
                best[i], least[i] = window, cost
    return best


Pair = tuple[Window, Window | None]  # a window and the one before it


def _as_it_is(_engine: Engine, _vector: Floats, pairs: Sequence[Pair]) -> list[Window | None]:
    return [window for window, _ in pairs]


def _as_measured(engine: Engine, _vector: Floats, pairs: Sequence[Pair]) -> list[Window | None]:
    return [_with_free(w, engine.data[w.run].local_state(w.start), 4) for w, _ in pairs]


def _as_ended(engine: Engine, vector: Floats, pairs: Sequence[Pair]) -> list[Window | None]:
    ended = iter(engine.ends(vector, [before for _, before in pairs if before is not None]))
    states = [None if before is None else next(ended) for _, before in pairs]
    return [
        None if state is None else _with_free(w, state, len(state))
        for (w, _), state in zip(pairs, states, strict=True)
    ]


def _as_slipping(engine: Engine, _vector: Floats, pairs: Sequence[Pair]) -> list[Window | None]:
    return [slipping(w, engine.data[w.run]) for w, _ in pairs]


def _with_free(window: Window, values: Floats, below: int) -> Window:
    """The window with those of its free states that come before `below` from `values`."""
    state = window.state.copy()
    for k in window.free:
        if k < below:
            state[k] = values[k]
    return with_state(window, state)


def sought(
    engine: Engine, vector: Floats, windows: Sequence[Window], steps: int
) -> tuple[list[Window], Floats]:
    """The windows with their own states improved by a few Levenberg-Marquardt steps, and their costs (w,)."""
    out, costs = list(windows), np.full(len(windows), np.inf)
    for free, at in by_free(windows).items():
        states, costs[at] = _sought(engine, vector, [windows[i] for i in at], list(free), steps)
        for i, state in zip(at, states, strict=True):
            out[i] = with_state(windows[i], state)
    return out, costs


def _sought(
    engine: Engine, vector: Floats, windows: Sequence[Window], free: list[int], steps: int
) -> tuple[Floats, Floats]:
    """States (w, 9) and costs (w,) of windows with the same free states, all in step."""
    q = len(free)
    states = np.stack([w.state for w in windows])
    centre = np.stack([w.centre for w in windows])[:, free]
    hold = 1.0 / np.stack([w.spread for w in windows])[:, free] ** 2
    damping, costs = np.full(len(windows), 1e-3), np.full(len(windows), np.inf)
    going = np.arange(len(windows))
    for _ in range(steps):
        blocks = engine.linearised(vector, [windows[i] for i in going.tolist()], states[going], own_only=True)
        going = going[[b is not None for b in blocks]]
        if not going.size:
            break
        products = np.stack([b.products for b in blocks if b is not None])
        off = centre[going] - states[going][:, free]
        C = products[:, :q, :q] + hold[going][:, :, None] * np.eye(q)
        g = products[:, :q, q] + off * hold[going]
        size = np.einsum("ijj->ij", C)
        costs[going] = products[:, q, q] + np.sum(off**2 * hold[going], axis=1)
        before = costs[going]
        left = np.arange(len(going))
        for _ in range(6):
            at = going[left]
            add = damping[at, None] * size[left] + 1e-9 * size[left].sum(axis=1, keepdims=True) + 1e-300
            trial = states[at]
            step = np.linalg.solve(C[left] + add[:, :, None] * np.eye(q), g[left, :, None])
            trial[:, free] += step[:, :, 0]
            some = [windows[i] for i in at.tolist()]
            new = np.sum((centre[at] - trial[:, free]) ** 2 * hold[at], axis=1)
            new += engine.chi2(vector, some, trial)
            better = new < costs[at]
            won = at[better]
            states[won], costs[won] = trial[better], new[better]
            damping[won] = np.maximum(damping[won] / 10, 1e-8)
            damping[at[~better]] *= 8
            left = left[~better]
            if not left.size:
                break
        now = costs[going]
        going = going[before - now >= np.maximum(1e-3 * now, 0.1)]
        if not going.size:
            break
    return states, costs


def followed(
    engine: Engine, vector: Floats, windows: list[Window], costs: Floats, blocks: Sequence[Block]
) -> tuple[list[Window], Floats]:
    """Windows that a step made worse, their own states brought after it; with the costs of all."""
    before = np.array([float(b.r @ b.r) for b in blocks])
    worse = np.flatnonzero(costs > 1.02 * before + 1.0).tolist()
    found, least = sought(engine, vector, [windows[i] for i in worse], 3)
    windows, costs = list(windows), costs.copy()
    for i, window, cost in zip(worse, found, least.tolist(), strict=True):
        if cost < costs[i]:
            windows[i], costs[i] = window, cost
    return windows, costs


__all__ = ["followed", "relaxed", "sought"]
