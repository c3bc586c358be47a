"""Levenberg-Marquardt on the arrow: the windows' own states are eliminated block by block (Schur complement)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.engine import Block, Engine
from stickslip.fitted.relax import followed, relaxed
from stickslip.fitted.window import Window, moved, window_penalties

Floats = NDArray[np.float64]
EDGE = 1e-9  # from a bound, in the fitted coordinate
RESCUES = 2  # steps tried again with the windows' own states brought after them, before they are shortened
QUIET = 1.02  # of the readings: a cost below is not worth another search
KNEE = 1.5  # of the median chi-squared per reading of the windows


@dataclass
class LeastSquaresFit:
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
    worth: Callable[[float], bool] | None = None,
) -> LeastSquaresFit | None:
    """Minimise chi-squared from a start; None if the start cannot be simulated.

    A transition found or lost makes chi-squared jump, and one window that jumps can hold up all others. When the
    iteration stalls above the noise, every window's own states are therefore sought anew, also from the readings
    around its start, up to `rounds` times.

    `tolerance` is the relative fall of the cost (or 0.02 absolutely, or less if it is below 1e-7) at which the
    iteration ends; `give_up(iteration, cost)` ends it early for a rival that is hopeless; `worth(cost)` says whether
    one that has stalled is worth the search.
    """
    point = Iterate.at(engine, vector, list(windows))
    if point is None:
        return None
    done = _descend(engine, point, 0, iterations, tolerance, give_up)
    readings = sum(b.r.size for b in point.blocks)
    for _ in range(rounds):
        if done >= iterations or point.cost < QUIET * readings:
            break
        if (give_up is not None and give_up(done, point.cost)) or not (worth is None or worth(point.cost)):
            break
        before = point.cost
        done = _shaken(engine, point, done, iterations, tolerance, give_up)
        if point.cost > (1 - 1e-3) * before:
            break
    return conclude(engine, point.vector, point.windows, point.blocks, point.cost, done)


def _shaken(
    engine: Engine,
    point: Iterate,
    done: int,
    iterations: int,
    tolerance: float,
    give_up: Callable[[int, float], bool] | None,
) -> int:
    """Out of a minimum that few windows hold up: they are sought anew, then given little say, and follow at last.

    `point` becomes the better of where it was and where this leads; returns the iterations used.
    """
    _relaxed(engine, point)
    other = Iterate(point.vector, list(point.windows), point.blocks, point.cost)
    if not other.soften():
        return _descend(engine, point, done, iterations, tolerance, give_up)
    done = _descend(engine, other, done, iterations, tolerance, give_up)
    _relaxed(engine, other)
    other.harden(engine)
    done = _descend(engine, other, done, iterations, tolerance, give_up)
    if other.cost < point.cost:
        point.vector, point.windows, point.blocks, point.cost = (
            other.vector, other.windows, other.blocks, other.cost
        )  # fmt: skip
    return done


@dataclass
class Iterate:
    """Where an iteration stands.

    `knee` is the chi-squared of each window beyond which it counts by its logarithm; infinite for plain least squares.
    """

    vector: Floats
    windows: list[Window]
    blocks: list[Block]
    cost: float
    damping: float = 1e-3
    knee: Floats | None = None

    @classmethod
    def at(cls, engine: Engine, vector: Floats, windows: list[Window]) -> Iterate | None:
        """A point with its blocks and cost; None where it cannot be simulated."""
        blocks = engine.blocks(vector, windows)
        if blocks is None:
            return None
        cost = sum(float(b.products[-1, -1]) for b in blocks) + float(window_penalties(windows).sum())
        return cls(vector, windows, blocks, cost + engine.penalty(vector))

    def soften(self) -> bool:
        """Let windows that fit far worse than most count by the logarithm; False if there are none."""
        size = np.array([max(int(np.count_nonzero(b.r)), 1) for b in self.blocks], dtype=np.float64)
        cost = np.array([float(b.r @ b.r) for b in self.blocks])
        self.knee = KNEE * max(float(np.median(cost / size)), 1.0) * size
        self.damping = 1e-3
        if not np.any(cost > self.knee):
            self.knee = None
            return False
        self.cost = np.inf  # another measure: the first step is not compared with the last
        return True

    def harden(self, engine: Engine) -> None:
        """Back to plain least squares."""
        self.knee, self.damping = None, 1e-3
        self.cost = engine.cost(self.vector, self.windows)


def _descend(
    engine: Engine,
    point: Iterate,
    done: int,
    iterations: int,
    tolerance: float,
    give_up: Callable[[int, float], bool] | None,
) -> int:
    """Levenberg-Marquardt until it stalls; returns the iterations used."""
    while done < iterations:
        done += 1
        before = point.cost
        step = _improve(engine, point)
        if step is None:
            break
        blocks = engine.blocks(step[0], step[1])
        if blocks is None:
            break
        point.vector, point.windows, point.cost, point.damping = step
        point.blocks = blocks
        if before - point.cost < max(tolerance * point.cost, min(0.02, 1e5 * tolerance)):
            break
        if give_up is not None and give_up(done, point.cost):
            break
    return done


def _relaxed(engine: Engine, point: Iterate) -> bool:
    """Seek each bad window's own states anew at fixed unknowns; True if that lowered the cost."""
    bad = [
        i for i, b in enumerate(point.blocks) if float(b.r @ b.r) > 1.3 * max(int(np.count_nonzero(b.r)), 1)
    ]

    before: list[Window | None] = []
    for i in bad:
        window, last = point.windows[i], point.windows[i - 1] if i else None
        joined = last is not None and last.run == window.run and last.stop == window.start
        before.append(last if joined else None)
    found = relaxed(engine, point.vector, [point.windows[i] for i in bad], before=before)
    windows = list(point.windows)
    for i, window in zip(bad, found, strict=True):
        windows[i] = window
    fresh = Iterate.at(engine, point.vector, windows)
    if fresh is None or fresh.cost >= point.cost:
        return False
    point.windows, point.blocks, point.cost, point.damping = windows, fresh.blocks, fresh.cost, 1e-3
    return True


def conclude(
    engine: Engine, vector: Floats, windows: list[Window], blocks: list[Block], cost: float, done: int
) -> LeastSquaresFit:
    """The fit's summary at a point."""
    normal, _, _ = reduced(engine, blocks, windows, np.diag(engine.precision), np.zeros(len(vector)), 0.0)
    chi2 = float(sum(b.r @ b.r for b in blocks))
    readings = sum(int((engine.data[w.run].weight[w.start : w.stop] > 0).sum()) for w in windows)
    return LeastSquaresFit(engine, vector, windows, blocks, chi2, cost, readings, normal, done)


def _improve(engine: Engine, point: Iterate) -> tuple[Floats, list[Window], float, float] | None:
    vector, windows, blocks, damping = point.vector, point.windows, point.blocks, point.damping
    low, high = engine.low, engine.high
    # far from the noise the misfit is the noise: the priors keep their say against it
    say = max(1.0, float(np.median([float(b.r @ b.r) / max(len(b.r), 1) for b in blocks])))
    precision = say * engine.precision
    pull = precision * (engine.centre - vector)
    share = None if point.knee is None else shares(blocks, point.knee)
    extra = (say - 1.0) * engine.penalty(vector)
    cost = point.cost + extra
    if not np.isfinite(cost):
        cost = total(engine.costs(vector, windows), point.knee) + say * engine.penalty(vector)
    for attempt in range(12):
        A, g, follow = reduced(engine, blocks, windows, np.diag(precision), pull, damping, share)
        try:
            step = within(A, g, low - vector, high - vector)
        except np.linalg.LinAlgError:
            damping *= 10
            continue
        trial = np.clip(vector + limited(step, engine.reach), low, high)
        step = trial - vector
        shifted = [
            moved(w, own - cross @ step[engine.columns[w.run]])
            for w, (own, cross) in zip(windows, follow, strict=True)
        ]
        costs = engine.costs(trial, shifted)
        trial_cost = total(costs, point.knee) + say * engine.penalty(trial)
        if trial_cost >= cost and attempt < RESCUES and np.isfinite(trial_cost):
            shifted, costs = followed(engine, trial, shifted, costs, blocks)
            trial_cost = total(costs, point.knee) + say * engine.penalty(trial)
        if trial_cost < cost:
            return trial, shifted, trial_cost - (say - 1.0) * engine.penalty(trial), max(damping / 10, 1e-7)
        damping = max(damping, 1e-6) * 6
    return None


def within(A: Floats, g: Floats, low: Floats, high: Floats) -> Floats:
    """Solve A step = g with what stands at a bound and would leave it held there."""
    free = np.ones(len(g), dtype=bool)
    step = np.zeros(len(g))
    for _ in range(4):
        step[free] = np.linalg.solve(A[np.ix_(free, free)], g[free])
        held = free & (((step > 0) & (high <= EDGE)) | ((step < 0) & (low >= -EDGE)))
        if not held.any():
            break
        free &= ~held
        step[:] = 0.0
    step[~free] = 0.0
    return step


def shares(blocks: Sequence[Block], knee: Floats) -> Floats:
    """The say of each window: d rho / d chi-squared."""
    cost = np.array([float(b.r @ b.r) for b in blocks])
    return np.asarray(np.minimum(1.0, knee / np.maximum(cost, 1e-300)))


def total(costs: Floats, knee: Floats | None) -> float:
    """Sum over the windows, beyond the knee by the logarithm."""
    if knee is None:
        return float(costs.sum())
    over = costs > knee
    return float(np.where(over, knee * (1 + np.log(np.maximum(costs, 1e-300) / knee)), costs).sum())


def limited(step: Floats, reach: Floats) -> Floats:
    """The step shortened until no coordinate moves beyond its reach."""
    most = float(np.max(np.abs(step) / reach, initial=0.0))
    return step if most <= 1.0 else step / most


def reduced(
    engine: Engine,
    blocks: Sequence[Block],
    windows: Sequence[Window],
    base: Floats,
    pull: Floats,
    damping: float,
    share: Floats | None = None,
) -> tuple[Floats, Floats, list[tuple[Floats, Floats]]]:
    """Normal matrix and right-hand side of the unknowns, and for each window (own step, its cross to unknowns).

    `share` is the say of each window in the unknowns, 1 if not given.
    """
    A, g = base.copy(), pull.copy()
    diagonal = np.zeros(len(pull))
    follow: list[tuple[Floats, Floats]] = [(np.empty(0), np.empty(0))] * len(windows)
    kinds: dict[tuple[int, tuple[int, ...]], list[int]] = {}
    for i, w in enumerate(windows):
        kinds.setdefault((w.run if engine.hypothesis.own else 0, w.free), []).append(i)
    for (run, free), at in kinds.items():
        columns, p = engine.columns[run], len(engine.columns[run])
        products = np.stack([blocks[i].products for i in at])
        say = np.ones(len(at)) if share is None else share[at]
        part, right, X = _eliminated(products, p, [windows[i] for i in at], list(free), say, damping)
        A[np.ix_(columns, columns)] += part
        g[columns] += right
        diagonal[columns] += say @ np.einsum("ijj->ij", products)[:, :p]
        for i, one in zip(at, X, strict=True):
            follow[i] = (one[:, 0], one[:, 1:])
    A[np.diag_indices_from(A)] += damping * (diagonal + np.diag(base))
    return A, g, follow


def _eliminated(
    products: Floats, p: int, windows: Sequence[Window], free: list[int], say: Floats, damping: float
) -> tuple[Floats, Floats, Floats]:
    """What windows with the same free states add to matrix and right-hand side; [own step, cross] (w, q, 1 + p)."""
    q = len(free)
    hold = 1.0 / np.stack([w.spread for w in windows])[:, free] ** 2
    off = np.stack([w.centre - w.state for w in windows])[:, free]
    E, C = products[:, p:-1, :p], products[:, p:-1, p:-1]
    size = np.einsum("ijj->ij", C)
    add = hold + damping * (size + hold)
    scale = np.sqrt(np.maximum(size + add, 1e-300))
    D = (C + add[:, :, None] * np.eye(q)) / (scale[:, :, None] * scale[:, None, :]) + 1e-10 * np.eye(q)
    own = products[:, p:-1, -1] + off * hold
    wanted = np.concatenate([own[:, :, None], E], axis=2) / scale[:, :, None]
    X = np.linalg.solve(D, wanted) / scale[:, :, None]
    heard = (say[:, None, None] * E).reshape(-1, p).T
    taken = heard @ X.reshape(-1, 1 + p)
    part = np.tensordot(say, products[:, :p, :p], 1) - taken[:, 1:]
    return part, say @ products[:, :p, -1] - taken[:, 0], X
