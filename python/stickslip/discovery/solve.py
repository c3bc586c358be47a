"""Levenberg-Marquardt on the arrow: the windows' own states are eliminated block by block (Schur complement)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.engine import Block, Engine, Window, moved, window_penalty

Floats = NDArray[np.float64]


@dataclass
class Fit:
    """A hypothesis at its best: vector, windows, chi-squared (without priors), readings used, normal matrix.

    `normal` (p, p) is the Schur-reduced information of the unknowns, priors included.
    """

    engine: Engine
    vector: Floats
    windows: list[Window]
    blocks: list[Block]
    chi2: float
    cost: float
    readings: int
    normal: Floats
    iterations: int

    @property
    def per_reading(self) -> float:
        """chi-squared per degree of freedom."""
        return self.chi2 / max(self.readings - self.dof, 1)

    @property
    def dof(self) -> int:
        """Numbers estimated: unknowns and free states."""
        return len(self.vector) + sum(len(w.free) for w in self.windows)

    @property
    def covariance(self) -> Floats:
        """Gauss-Newton covariance of the vector."""
        return np.asarray(np.linalg.pinv(self.normal, hermitian=True))


def fit(
    engine: Engine,
    vector: Floats,
    windows: Sequence[Window],
    *,
    iterations: int = 30,
    tolerance: float = 1e-4,
    rounds: int = 3,
    give_up: Callable[[int, float], bool] | None = None,
) -> Fit | None:
    """Minimise chi-squared from a start; None if the start cannot be simulated.

    A transition found or lost makes chi-squared jump, and one window that jumps can hold up all others. When the
    iteration stalls above the noise, every window's own states are therefore sought anew, also from the readings
    around its start, up to `rounds` times.

    `tolerance` is the relative fall of the cost (or 0.02 absolutely, far below what noise can tell) at which the
    iteration ends; `give_up(iteration, cost)` ends it early for a rival that is hopeless.
    """
    point = Point.at(engine, vector, list(windows))
    if point is None:
        return None
    done = 0
    for turn in range(rounds + 1):
        done = _descend(engine, point, done, iterations, tolerance, give_up)
        readings = sum(b.r.size for b in point.blocks)
        if turn == rounds or done >= iterations or point.cost < 1.02 * readings:
            break
        if give_up is not None and give_up(done, point.cost):
            break
        before = point.cost
        if not _relaxed(engine, point) or point.cost > (1 - 1e-3) * before:
            break
    return conclude(engine, point.vector, point.windows, point.blocks, point.cost, done)


@dataclass
class Point:
    """Where an iteration stands."""

    vector: Floats
    windows: list[Window]
    blocks: list[Block]
    cost: float
    damping: float = 1e-3

    @classmethod
    def at(cls, engine: Engine, vector: Floats, windows: list[Window]) -> Point | None:
        """A point with its blocks and cost; None where it cannot be simulated."""
        blocks = engine.blocks(vector, windows)
        if blocks is None:
            return None
        cost = engine.cost(vector, windows)
        return cls(vector, windows, blocks, cost) if np.isfinite(cost) else None


def _descend(
    engine: Engine,
    point: Point,
    done: int,
    iterations: int,
    tolerance: float,
    give_up: Callable[[int, float], bool] | None,
) -> int:
    """Levenberg-Marquardt until it stalls; returns the iterations used."""
    while done < iterations:
        done += 1
        before = point.cost
        step = _improve(engine, point.vector, point.windows, point.blocks, point.cost, point.damping)
        if step is None:
            break
        blocks = engine.blocks(step[0], step[1])
        if blocks is None:
            break
        point.vector, point.windows, point.cost, point.damping = step
        point.blocks = blocks
        if before - point.cost < max(tolerance * point.cost, 0.02):
            break
        if give_up is not None and give_up(done, point.cost):
            break
    return done


def _relaxed(engine: Engine, point: Point) -> bool:
    """Seek each bad window's own states anew at fixed unknowns; True if that lowered the cost."""
    bad = [
        i for i, b in enumerate(point.blocks) if float(b.r @ b.r) > 1.3 * max(int(np.count_nonzero(b.r)), 1)
    ]
    found = list(engine.pool.map(lambda i: relax(engine, point.vector, point.windows[i]), bad))
    windows = list(point.windows)
    for i, window in zip(bad, found, strict=True):
        windows[i] = window
    fresh = Point.at(engine, point.vector, windows)
    if fresh is None or fresh.cost >= point.cost:
        return False
    point.windows, point.blocks, point.cost, point.damping = windows, fresh.blocks, fresh.cost, 1e-3
    return True


def relax(engine: Engine, vector: Floats, window: Window, steps: int = 8) -> Window:
    """The window with its own states at their best for fixed unknowns, from its present and its measured start."""
    run = engine.data[window.run]
    state = window.state.copy()
    measured = run.local_state(window.start)
    for k in window.free:
        if k < 4:
            state[k] = measured[k]
    best, least = window, np.inf
    for start in (window, replace(window, state=state)):
        found, cost = _local(engine, vector, start, steps)
        if cost < least:
            best, least = found, cost
    return best


def _local(engine: Engine, vector: Floats, window: Window, steps: int) -> tuple[Window, float]:
    damping, free = 1e-3, list(window.free)
    r = engine.residual(vector, window)
    cost = np.inf if r is None else float(r @ r) + window_penalty(window)
    for _ in range(steps):
        block = engine.linearise(vector, window, own_only=True)
        if block is None:
            break
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


def conclude(
    engine: Engine, vector: Floats, windows: list[Window], blocks: list[Block], cost: float, done: int
) -> Fit:
    """The fit's summary at a point."""
    normal, _, _ = reduced(engine, blocks, windows, np.diag(engine.precision), np.zeros(len(vector)), 0.0)
    chi2 = float(sum(b.r @ b.r for b in blocks))
    readings = sum(int((engine.data[w.run].weight[w.start : w.stop] > 0).sum()) for w in windows)
    return Fit(engine, vector, windows, blocks, chi2, cost, readings, normal, done)


def _improve(
    engine: Engine,
    vector: Floats,
    windows: list[Window],
    blocks: list[Block],
    cost: float,
    damping: float,
) -> tuple[Floats, list[Window], float, float] | None:
    precision, low, high = engine.precision, engine.low, engine.high
    pull = precision * (engine.centre - vector)
    for _ in range(12):
        A, g, follow = reduced(engine, blocks, windows, np.diag(precision), pull, damping)
        try:
            step = np.asarray(np.linalg.solve(A, g), dtype=np.float64)
        except np.linalg.LinAlgError:
            damping *= 10
            continue
        trial = np.clip(vector + limited(step), low, high)
        step = trial - vector
        shifted = [
            moved(w, own - cross @ step[engine.columns[w.run]])
            for w, (own, cross) in zip(windows, follow, strict=True)
        ]
        costs = engine.costs(trial, shifted)
        trial_cost = float(costs.sum()) + engine.penalty(trial)
        if trial_cost < cost:
            return trial, shifted, trial_cost, max(damping / 10, 1e-7)
        damping = max(damping, 1e-6) * 6
    return None


def limited(step: Floats, most: float = 1.5) -> Floats:
    """No coordinate moves by more than `most` at once."""
    largest = float(np.max(np.abs(step), initial=0.0))
    return step if largest <= most else step * (most / largest)


def reduced(
    engine: Engine,
    blocks: Sequence[Block],
    windows: Sequence[Window],
    base: Floats,
    pull: Floats,
    damping: float,
) -> tuple[Floats, Floats, list[tuple[Floats, Floats]]]:
    """Normal matrix and right-hand side of the unknowns, and for each window (own step, its cross to unknowns)."""
    A, g = base.copy(), pull.copy()
    diagonal = np.zeros(len(pull))
    follow = []
    for b, w in zip(blocks, windows, strict=True):
        columns, free, p = engine.columns[w.run], list(w.free), b.J.shape[1]
        JJ, E, C = b.products[:p, :p], b.products[p:-1, :p], b.products[p:-1, p:-1]
        hold = 1.0 / w.spread[free] ** 2
        C = C + np.diag(hold + damping * (np.diag(C) + hold))
        own = b.products[p:-1, -1] + (w.centre[free] - w.state[free]) * hold
        size = np.sqrt(np.maximum(np.diag(C), 1e-300))
        D = C / np.outer(size, size) + 1e-10 * np.eye(len(free))
        X = np.linalg.solve(D, np.column_stack([own, E]) / size[:, None]) / size[:, None]
        A[np.ix_(columns, columns)] += JJ - E.T @ X[:, 1:]
        g[columns] += b.products[:p, -1] - E.T @ X[:, 0]
        diagonal[columns] += np.diag(JJ)
        follow.append((X[:, 0], X[:, 1:]))
    A[np.diag_indices_from(A)] += damping * (diagonal + np.diag(base))
    return A, g, follow
