"""Candidates weighed: the fall of -2 log likelihood when a candidate joins, all others refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.check_model import idle
from stickslip.declared.effect import CONSTANTS
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.discovery.slider.candidates import Candidate
from stickslip.discovery.slider.population import Block, without

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class White:
    """The blocks, and their y whitened, one under the other."""

    blocks: tuple[Block, ...]
    y: Floats

    @property
    def events(self) -> int:
        """How many numbers there are in all."""
        return len(self.y)


@dataclass(frozen=True)
class Weighed:
    """A candidate with others, fitted jointly: theta (p,) of the new one first, its covariance, what it gains."""

    candidate: Candidate
    theta: Floats
    covariance: Floats
    gain: float

    @property
    def score(self) -> float:
        """The gain less what as many idle parameters would gain, on the scale of one parameter."""
        return self.gain - PRICE * (self.candidate.parameters - 1)


PRICE = 2.0
WORTH = -4.0  # score from which a second look is taken
IN_SPAN = 1e-5  # share of a column that must be its own


def whitened(blocks: Sequence[Block]) -> White:
    """Whiten all blocks once."""
    parts = [one.whitened(one.y) for one in blocks if len(one)]
    return White(tuple(blocks), np.concatenate(parts) if parts else np.zeros(0))


def design(white: White, candidate: Candidate) -> Floats:
    """Whitened columns of a candidate over all blocks, (N, p)."""
    parts = []
    for block in white.blocks:
        columns = candidate.columns.get(block.name)
        if columns is None or not len(block):
            parts.append(np.zeros((len(block), candidate.count)))
        else:
            parts.append(block.whitened(columns))
    return np.concatenate(parts)


def weigh(
    white: White, candidate: Candidate, accepted: Floats | None = None, y: Floats | None = None
) -> Weighed | None:
    """Fit a candidate beside the accepted columns (N, q); None where its sign is ruled out or it says nothing."""
    own = design(white, candidate)
    values = white.y if y is None else y
    if accepted is not None and accepted.shape[1]:
        q, _ = np.linalg.qr(accepted)
        left, rest = own - q @ (q.T @ own), values - q @ (q.T @ values)
    else:
        left, rest = own, values
    size = np.linalg.norm(own, axis=0)
    if not np.all(size > 0):
        keep = size > 0
        if not keep.any():
            return None
    else:
        keep = np.ones(len(size), dtype=bool)
    unit = left[:, keep] / size[keep]
    A = unit.T @ unit
    if np.linalg.eigvalsh(A)[0] < IN_SPAN:
        return None
    if candidate.slope is not None:
        return _self_consistent(candidate, left[:, 0], rest)
    inverse = np.linalg.inv(A)
    theta = np.zeros(candidate.count)
    theta[keep] = (inverse @ (unit.T @ rest)) / size[keep]
    covariance = np.zeros((candidate.count, candidate.count))
    covariance[np.ix_(keep, keep)] = inverse / np.outer(size[keep], size[keep])
    if candidate.sign and theta[0] * candidate.sign <= 0:
        return None
    gain = float(rest @ rest - np.sum((rest - left @ theta) ** 2))
    return Weighed(candidate, theta, covariance, gain)


def _self_consistent(candidate: Candidate, column: Floats, rest: Floats) -> Weighed | None:
    """A column that depends on the level: the determinant of d(level without it)/d(level) joins the likelihood."""
    assert candidate.slope is not None
    b, c = float(column @ rest), float(column @ column)
    most = 0.95 / float(candidate.slope.max())
    theta = np.linspace(0, most, 200)[1:]
    turned = np.log(1 - theta[:, None] * candidate.slope).sum(axis=1)
    gain = 2 * b * theta - c * theta**2 + 2 * turned
    at = int(np.argmax(gain))
    if gain[at] <= 0:
        return None
    found = np.array([theta[at]])
    bent = c + float(np.sum((candidate.slope / (1 - theta[at] * candidate.slope)) ** 2))
    return Weighed(candidate, found, np.array([[1 / bent]]), float(gain[at]))


def ranked(white: White, tried: Sequence[Candidate], taken: Sequence[Candidate] = ()) -> list[Weighed]:
    """Every name at its best beside what is taken, best first; those of the level with the wander estimated again."""
    accepted = columns_of(white, taken)
    names = {one.name for one in taken}
    able = (one for one in tried if one.name not in names and not idle(CoulombFriction(), {*names, one.name}))
    found = (weigh(white, one, accepted) for one in able)
    best = best_of([one for one in found if one is not None])
    return best_of([beside_wander(white, one, taken) for one in best])


def columns_of(white: White, taken: Sequence[Candidate]) -> Floats:
    """Whitened columns of several candidates, (N, q)."""
    parts = [design(white, one) for one in taken]
    return np.column_stack(parts) if parts else np.zeros((white.events, 0))


def beside_wander(white: White, one: Weighed, taken: Sequence[Candidate]) -> Weighed:
    """A candidate of the levels with the wander estimated again beside it; any other as it is."""
    if set(one.candidate.columns) != {"level"}:
        return one
    if one.candidate.slope is not None or one.score < WORTH:
        return one
    level = next(block for block in white.blocks if block.name == "level")
    there = [c.columns["level"] for c in taken if "level" in c.columns]
    own = one.candidate.columns["level"]
    gain, theta = without(level, np.column_stack([own, *there]))
    if there:
        gain -= without(level, np.column_stack(there))[0]
    return replace(one, gain=max(gain, one.gain), theta=theta[: own.shape[1]])


def best_of(weighed: Sequence[Weighed]) -> list[Weighed]:
    """The best of each name, best first; of equals a declared constant first."""
    best: dict[str, Weighed] = {}
    for one in weighed:
        if one.candidate.name not in best or one.score > best[one.candidate.name].score:
            best[one.candidate.name] = one
    return sorted(best.values(), key=lambda one: (-round(one.score, 6), one.candidate.name not in CONSTANTS))
