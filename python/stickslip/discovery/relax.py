"""Windows' own states at fixed unknowns: sought anew, brought after a step, and with each run's phase turned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.engine import Block, Engine, Window, moved, window_penalty

Floats = NDArray[np.float64]
OFF = 1.15  # chi-squared per reading of a run from which its phases are sought anew
PHASES = 10  # of a turn


def relax(
    engine: Engine, vector: Floats, window: Window, steps: int = 8, before: Window | None = None
) -> Window:
    """The window with its own states at their best for fixed unknowns.

    They are sought from where they are, from the readings around the window's start, and from where the window
    `before` it ends.
    """
    run = engine.data[window.run]
    measured = window.state.copy()
    local = run.local_state(window.start)
    for k in window.free:
        if k < 4:
            measured[k] = local[k]
    starts = [window, replace(window, state=measured)]
    if before is not None:
        ended = engine.end(vector, before)
        if ended is not None:
            state = window.state.copy()
            state[list(window.free)] = ended[list(window.free)]
            starts.append(replace(window, state=state))
    best, least = window, np.inf
    for start in starts:
        found, cost = seek(engine, vector, start, steps)
        if cost < least:
            best, least = found, cost
        if least < 1.1 * max(int(np.count_nonzero(run.weight[window.start : window.stop])), 1):
            break
    return best


def seek(engine: Engine, vector: Floats, window: Window, steps: int) -> tuple[Window, float]:
    """The window with its own states improved by a few Levenberg-Marquardt steps, and its cost."""
    damping, free, cost = 1e-3, list(window.free), np.inf
    for _ in range(steps):
        block = engine.linearise(vector, window, own_only=True)
        if block is None:
            break
        cost = float(block.r @ block.r) + window_penalty(window)
        C = block.K.T @ block.K + np.diag(1.0 / window.spread[free] ** 2)
        g = block.K.T @ block.r + (window.centre[free] - window.state[free]) / window.spread[free] ** 2
        before = cost
        for _ in range(6):
            D = C + np.diag(damping * np.diag(C) + 1e-9 * np.trace(C))
            trial = moved(window, np.asarray(np.linalg.solve(D, g), dtype=np.float64))
            r = engine.residual(vector, trial)
            new = np.inf if r is None else float(r @ r) + window_penalty(trial)
            if new < cost:
                window, cost, damping = trial, new, max(damping / 10, 1e-8)
                break
            damping *= 8
        if before - cost < max(1e-3 * cost, 0.1):
            break
    return window, cost


def followed(
    engine: Engine, vector: Floats, windows: list[Window], costs: Floats, blocks: Sequence[Block]
) -> tuple[list[Window], Floats]:
    """Windows that a step made worse, their own states brought after it; with the costs of all."""
    before = np.array([float(b.r @ b.r) for b in blocks])
    worse = np.flatnonzero(costs > 1.02 * before + 1.0).tolist()
    found = list(engine.pool.map(lambda i: seek(engine, vector, windows[i], 3), worse))
    windows, costs = list(windows), costs.copy()
    for i, (window, cost) in zip(worse, found, strict=True):
        if cost < costs[i]:
            windows[i], costs[i] = window, cost
    return windows, costs


def rephased(engine: Engine, vector: Floats, windows: Sequence[Window]) -> tuple[Floats, list[Window]]:
    """Vector and windows with the best of many phases of each run that is left above the noise."""
    own, count = len(engine.hypothesis.own), len(engine.data)
    vector, windows = vector.copy(), list(windows)
    for column in range(len(vector) - own * count, len(vector)):
        run = (column - (len(vector) - own * count)) // own
        at = [i for i, w in enumerate(windows) if w.run == run]
        least = float(engine.costs(vector, [windows[i] for i in at]).sum())
        if least < OFF * sum(2 * (windows[i].stop - windows[i].start) for i in at):
            continue
        start = vector
        for k in range(1, PHASES):
            turned = start.copy()
            turned[column] += 2 * np.pi * k / PHASES
            found = list(engine.pool.map(partial(relax, engine, turned, steps=5), [windows[i] for i in at]))
            cost = float(engine.costs(turned, found).sum())
            if cost < least:
                least, vector = cost, turned
                for i, w in zip(at, found, strict=True):
                    windows[i] = w
    return vector, windows


__all__ = ["followed", "relax", "rephased", "seek"]
