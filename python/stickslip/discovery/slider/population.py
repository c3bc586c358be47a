"""What differs from event to event: the process noise, estimated beside the law and known to every comparison.

Four numbers of each event carry what a declared constant or a listed effect would change: the rise of its stick over
the set-point speed (`rate`), the square of its slip's frequency over k/m (`frequency`), the damping of its slip over
the declared one (`damping`) and the force at its breakaway over the run's mean (`level`). Each has a spread between
events beyond what the noise of the readings explains, and a spread common to neighbours: runs differ in speed, slips
of one size feel the unevenness of the surface alike, and the level wanders along the belt as an Ornstein-Uhlenbeck
process.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.fitted.block_events.cycle import LOG_W2, ZETA, S
from stickslip.fitted.block_events.table import Measured, damping_ratio, natural_rate

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
FLOOR = {"rate": 0.01, "frequency": 0.05, "damping": 0.02}  # spread between groups that is always allowed for
SIZES = 3  # groups of slips by size
FREE = 10.0  # spread of a run's mean level: not known beforehand
TUNING = 4.7  # of Tukey's biweight


@dataclass(frozen=True)
class Block:
    """One number of all events: y (n,), its noise variance, what it is known by, and its groups.

    `run` numbers the runs; `group` the events that share a deviation; `x` is the deflection, `t` the time, `travel` the
    belt's travel, `speed` the set-point, `top` the largest speed of the slip, `dwell` the time at rest before it,
    `fall` the deflection lost in it (0 for sticks) and `load` the deflection at which the spring alone would bear what
    the contact bears at x, the damper of the block carried along included.
    """

    name: str
    y: Floats
    noise: Floats
    run: Ints
    group: Ints
    t: Floats
    travel: Floats
    x: Floats
    speed: Floats
    top: Floats
    dwell: Floats
    fall: Floats
    load: Floats
    spread: Floats
    shared: float = 0.0
    wander: tuple[float, float, float] = (0.0, 1.0, 0.0)

    def __len__(self) -> int:
        return len(self.y)

    def whitened(self, values: Floats) -> Floats:
        """Values (n,) or columns (n, p) times an inverse root of the covariance of y about its mean.

        Groups share a deviation: their part of the root is one of rank one. Levels are correlated along the belt.
        """
        if self.name == "level":
            return _along(self._inverse_roots, values)
        own = 1 / np.sqrt(self.noise + self.spread**2)
        out = (values.T * own).T
        for group in np.unique(self.group):
            at = self.group == group
            size = float(np.linalg.norm(own[at]))
            unit = own[at] / size
            kappa = 1 - 1 / np.sqrt(1 + (self.shared * size) ** 2)
            out[at] -= kappa * np.multiply.outer(unit, unit @ out[at])
        return np.asarray(out)

    def drawn(self, rng: np.random.Generator) -> Floats:
        """y drawn from the process noise alone, (n,)."""
        z = rng.standard_normal(len(self))
        if self.name == "level":
            return _along(self.roots(), z)
        own = np.sqrt(self.noise + self.spread**2)
        shared = rng.standard_normal(int(self.group.max(initial=0)) + 1)
        return np.asarray(own * z + self.shared * shared[self.group])

    @cached_property
    def _inverse_roots(self) -> list[tuple[Ints, Floats]]:
        # every candidate is whitened by them
        return [
            (at, scipy.linalg.solve_triangular(root, np.eye(len(at)), lower=True, check_finite=False))
            for at, root in self.roots(FREE**2)
        ]

    def roots(self, more: float = 0.0) -> list[tuple[Ints, Floats]]:
        """Events of each run, and a root of the covariance of their levels with so much more in common.

        With FREE**2 the mean of a run may be any.
        """
        sigma, length, tau = self.wander
        out: list[tuple[Ints, Floats]] = []
        for run in np.unique(self.run):
            at = np.flatnonzero(self.run == run).astype(np.int64)
            where = self.travel[at]
            C = sigma**2 * np.exp(-np.abs(where[:, None] - where[None, :]) / length) + more
            C[np.diag_indices(len(at))] += self.noise[at] + tau**2 + 1e-12
            out.append((at, np.asarray(np.linalg.cholesky(C))))
        return out


def _along(roots: Sequence[tuple[Ints, Floats]], values: Floats) -> Floats:
    """Roots, run by run, times values."""
    out = np.empty_like(values)
    for at, root in roots:
        out[at] = root @ values[at]
    return out


def blocks(runs: Sequence[Measured]) -> list[Block]:
    """The four numbers of all events, with the process noise estimated.

    Parameters
    ----------
    runs : sequence of Measured
        Those to learn from.
    """
    sources = {name: i for i, name in enumerate(dict.fromkeys(one.run.source for one in runs))}
    made = [_rates(runs, sources), *_slips(runs, sources), _levels(runs)]
    return [estimated(one) for one in made]


def _rates(runs: Sequence[Measured], sources: dict[str, int]) -> Block:
    parts = []
    for i, one in enumerate(runs):
        s = one.sticks
        ok = s.rate > 0.3
        n = int(ok.sum())
        group = np.full(n, sources[one.run.source])
        parts.append(
            (
                np.log(s.rate[ok]),
                (s.std[ok] / s.rate[ok]) ** 2,
                np.full(n, i),
                group,
                s.t[ok],
                one.run.belt_speed * s.t[ok],
                s.x[ok],
                np.full(n, one.run.belt_speed),
                *(np.zeros(n),) * 3,
                s.x[ok],
            )
        )
    return _block("rate", parts)


def _slips(runs: Sequence[Measured], sources: dict[str, int]) -> list[Block]:
    out = []
    for name, column in (("frequency", LOG_W2), ("damping", ZETA)):
        parts = []
        for i, one in enumerate(runs):
            e, n = one.events, len(one.events)
            if not n:
                continue
            rig = one.run.rig
            declared = np.log(natural_rate(rig) ** 2) if name == "frequency" else damping_ratio(rig)
            rank = np.argsort(np.argsort(e.slip))
            group = SIZES * sources[one.run.source] + (SIZES * rank) // n
            top = 0.5 * e.slip * np.exp(0.5 * e.p[:, LOG_W2])
            speed = np.full(n, one.run.belt_speed)
            fall = e.p[:, S] - e.arrest
            y, noise = e.p[:, column] - declared, e.std[:, column] ** 2
            parts.append(
                (
                    y,
                    noise,
                    np.full(n, i),
                    group,
                    e.t,
                    e.travel,
                    e.p[:, S],
                    speed,
                    top,
                    e.dwell,
                    fall,
                    e.p[:, S],
                )
            )
        out.append(_block(name, parts))
    return out


def _levels(runs: Sequence[Measured]) -> Block:
    parts = []
    for i, one in enumerate(runs):
        e, n = one.events, len(one.events)
        if not n:
            continue
        x = e.p[:, S]
        load = x + one.run.rig.damping * one.run.belt_speed / one.run.rig.stiffness
        mean, run = float(load.mean()), np.full(n, i)
        noise = (e.std[:, S] / mean) ** 2
        speed, fall = np.full(n, one.run.belt_speed), x - e.arrest
        none = np.zeros(n)
        parts.append((load / mean - 1, noise, run, run, e.t, e.travel, x, speed, none, e.dwell, fall, load))
    return _block("level", parts)


def _block(name: str, parts: Sequence[tuple[Floats | Ints, ...]]) -> Block:
    columns = [np.concatenate(one) for one in zip(*parts, strict=True)] if parts else [np.zeros(0)] * 12
    y, noise, run, group, t, travel, x, speed, top, dwell, fall, load = columns
    none = np.zeros(len(y))
    return Block(
        name, y, noise, run.astype(int), group.astype(int), t, travel, x, speed, top, dwell, fall, load, none
    )


def estimated(block: Block) -> Block:
    """The block with its process noise estimated afresh; events far out get a wide spread of their own."""
    if not len(block):
        return block
    if block.name == "level":
        return replace(block, wander=_wander(block))
    spread = np.empty(len(block))
    for run in np.unique(block.run):
        at = block.run == run
        off = block.y[at] - np.median(block.y[at])
        scale = 1.4826 * float(np.median(np.abs(off)))
        tau = np.sqrt(max(scale**2 - float(np.median(block.noise[at])), 0.0))
        total = np.sqrt(block.noise[at] + max(tau, 1e-6) ** 2)
        weight = np.clip(1 - (off / (TUNING * total)) ** 2, 1e-3, 1.0) ** 2
        spread[at] = np.sqrt(np.maximum(total**2 / weight - block.noise[at], 1e-12))
    return replace(block, spread=spread, shared=_shared(block, spread))


def _shared(block: Block, spread: Floats) -> float:
    """Spread between groups after DerSimonian and Laird, never below its floor."""
    w = 1 / (block.noise + spread**2)
    groups = np.unique(block.group)
    floor = FLOOR[block.name]
    if len(groups) < 2:
        return floor
    weight = np.array([w[block.group == g].sum() for g in groups])
    mean = np.array([(w * block.y)[block.group == g].sum() for g in groups]) / weight
    common = float(weight @ mean / weight.sum())
    q = float(weight @ (mean - common) ** 2)
    room = float(weight.sum() - (weight @ weight) / weight.sum())
    return float(np.sqrt(max((q - len(groups) + 1) / room, floor**2)))


def wander_cost(block: Block, wander: tuple[float, float, float], y: Floats | None = None) -> float:
    """Minus twice the log likelihood of the levels under a wander (spread, length along the belt, own spread)."""
    values = block.y if y is None else y
    total = 0.0
    for at, root in replace(block, wander=wander).roots(FREE**2):
        z = scipy.linalg.solve_triangular(root, values[at], lower=True, check_finite=False)
        total += float(z @ z) + 2 * float(np.log(np.diag(root)).sum())
    return total


def _wander(block: Block) -> tuple[float, float, float]:
    size = float(np.std(block.y)) + 1e-9
    step = float(np.median(np.diff(np.unique(block.travel)))) if len(block) > 2 else 1.0
    reach = float(np.ptp(block.travel)) or 1.0
    known = block.wander
    start: Floats = np.log(np.array([0.7 * size, 10 * step, 0.7 * size] if known[0] == 0 else known))

    def cost(q: Floats) -> float:
        sigma, length, tau = np.exp(np.clip(q, -25, 10))
        tame = float(np.log(length / (10 * step)) / 3) ** 2
        if length > reach or length < 0.1 * step:
            tame += 1e3 * abs(float(np.log(length / reach)))
        return wander_cost(block, (float(sigma), float(length), float(tau))) + tame

    simplex = np.array([start, *(start + 0.7 * one for one in np.eye(3))])
    few = 120 if known[0] == 0 else 45
    best = scipy.optimize.minimize(
        cost,
        start,
        method="Nelder-Mead",
        options={"maxfev": few, "xatol": 0.02, "fatol": 0.05, "initial_simplex": simplex},
    ).x
    sigma, length, tau = (float(v) for v in np.exp(np.clip(best, -25, 10)))
    return sigma, length, tau


def without(block: Block, columns: Floats, rounds: int = 2) -> tuple[float, Floats]:
    """What columns gain on the levels when the wander is estimated again beside them, and their coefficients.

    A wave that the wander had to imitate is worth more than the first estimate of the wander allows.

    Returns
    -------
    gain, theta
        The fall of minus twice the log likelihood, and (p,).
    """
    before = wander_cost(block, block.wander)
    one, gain = block, 0.0
    theta: Floats = np.zeros(columns.shape[1])
    for _ in range(rounds):
        theta = np.asarray(np.linalg.lstsq(one.whitened(columns), one.whitened(block.y), rcond=None)[0])
        rest = block.y - columns @ theta
        gain = max(gain, before - wander_cost(one, one.wander, rest))
        one = replace(one, y=rest, wander=_wander(replace(one, y=rest)))
        gain = max(gain, before - wander_cost(one, one.wander, rest))
    return gain, theta
