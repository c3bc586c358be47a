"""A fit with all that is a window's own eliminated once, so that a further column costs one projection."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.mixed import beyond_rounding, inverse_of, within
from stickslip.likelihoods.population import factor
from stickslip.likelihoods.score import Columns

Floats = NDArray[np.float64]
TINY = 1e-9  # share added to a diagonal, against columns that say the same
NOTHING = 1e-12  # and of itself, against those that say nothing: what sticks has no speed of its own


@dataclass(frozen=True)
class NullWindow:
    """
    One window, over its noise, (n, ...) each.

    Parameters
    ----------
    effects : columns of the random effects
    local : columns of the window's own numbers, those of random effects white
    hat : (own, n) turns readings into the window's own numbers
    shared : columns of the shared numbers, less what the window's own explain
    right : what the shared numbers are to explain
    """

    effects: Floats
    local: Floats
    hat: Floats
    shared: Floats
    right: Floats


@dataclass(frozen=True)
class Projected:
    """
    New columns less what a window's own numbers explain, window by window; 0 for one that failed.

    Parameters
    ----------
    columns : (n, k) of each window, None for one that failed
    cross : (windows, k, p) products with the shared numbers
    square : (windows, k, k) products with themselves
    """

    columns: list[Floats | None]
    cross: Floats
    square: Floats


class Null:
    """The null of a score test, its population held; `tight`: its constants stay where they are."""

    def __init__(self, fit: Fit, tight: bool = False) -> None:
        assert fit.linear is not None
        self.fit, p, q = fit, len(fit.at), fit.windows.begins
        self.run = np.array(fit.windows.runs)
        roots = factor(fit.population, fit.windows.places)
        prior = fit.windows.prior
        away, schur = prior.tight(fit.at) if tight else prior.at(fit.at)
        self.pull = schur @ away
        self.rows: list[NullWindow | None] = []
        whole = np.zeros(p)
        for i, block in enumerate(fit.blocks):
            if block is None or fit.linear.weight[i] == 0:
                self.rows.append(None)
                continue
            x = self.over_noise(block, i)
            effects = x[:, p + q : -1]
            local = np.concatenate([x[:, p : p + q], effects @ roots[self.run[i]]], axis=1)
            inner = local.T @ local
            inner[range(q), range(q)] = inner[range(q), range(q)] * (1 + TINY) + NOTHING
            inner[range(q, len(inner)), range(q, len(inner))] += 1.0
            hat = np.linalg.solve(inner, local.T)
            shared = x[:, :p] - local @ (hat @ x[:, :p])
            right = x[:, -1] + effects @ fit.random[i]
            schur = schur + x[:, :p].T @ shared
            whole += (x[:, :p] ** 2).sum(axis=0)
            self.pull = self.pull + shared.T @ right
            self.rows.append(NullWindow(effects, local, hat, shared, right))
        schur[range(p), range(p)] = beyond_rounding(schur, whole) * (1 + TINY)
        bounds = fit.windows.steps(fit.at)
        at_bound = (bounds[0] >= 0) | (bounds[1] <= 0)
        free = ~(within(schur, self.pull, bounds)[1] & at_bound) if at_bound.any() else ~at_bound
        self.inverse = np.zeros_like(schur)  # what a bound holds does not move beside a new number
        self.inverse[np.ix_(free, free)] = inverse_of(schur[np.ix_(free, free)])

    def over_noise(self, block: Floats, window: int) -> Floats:
        """Columns of a window over its noise, (n, k)."""
        assert self.fit.linear is not None
        scaled = (block / np.sqrt(self.fit.noise)[None, :, None]).reshape(-1, block.shape[2])
        return np.asarray(scaled * math.sqrt(self.fit.linear.weight[window]))

    def projected(self, columns: Columns) -> Projected:
        """Return new columns less what the windows' own numbers explain."""
        k = next(c.shape[2] for c in columns if c is not None)
        p = len(self.pull)
        cross, square = np.zeros((len(self.rows), k, p)), np.zeros((len(self.rows), k, k))
        kept: list[Floats | None] = []
        for i, (row, column) in enumerate(zip(self.rows, columns, strict=True)):
            if row is None or column is None:
                kept.append(None)
                continue
            e = self.over_noise(column, i)
            left = _beside(row, e)
            kept.append(left)
            cross[i], square[i] = e.T @ row.shared, e.T @ left
        return Projected(kept, cross, square)

    def along(self, columns: list[Floats | None], rights: list[Floats | None], width: int) -> Floats:
        """Return products of columns with what is to be explained, (windows, k, draws)."""
        k = next(c.shape[1] for c in columns if c is not None)
        out = np.zeros((len(columns), k, width))
        for i, (column, right) in enumerate(zip(columns, rights, strict=True)):
            if column is not None and right is not None:
                out[i] = column.T @ right
        return out

    def gains(
        self, cross: Floats, square: Floats, pull: Floats, shared: Floats, precision: float = 0.0
    ) -> Floats:
        """
        Return the gain of columns for each draw.

        Parameters
        ----------
        cross, square : (k, p), (k, k) products of the columns
        pull, shared : (k, draws), (p, draws) products with what is to be explained
        precision : of a Gaussian prior about 0 of the columns' numbers
        """
        left, off = self._left(cross, square, pull, shared)
        left[range(len(left)), range(len(left))] += precision
        return np.asarray((off * np.linalg.solve(left, off)).sum(axis=0))

    def _left(self, cross: Floats, square: Floats, pull: Floats, shared: Floats) -> tuple[Floats, Floats]:
        """Products of columns with themselves and with draws, the shared numbers eliminated."""
        left = square - cross @ self.inverse @ cross.T
        size = np.abs(np.diag(square))  # in whatever unit the column's number is
        left[range(len(left)), range(len(left))] += np.where(size > 0, TINY * size, NOTHING)
        return left, pull - cross @ (self.inverse @ shared)

    def scored(self, made: Projected) -> tuple[float, Floats]:
        """Return what columns that all windows share gain, and their sizes."""
        pull = self.along(made.columns, self.rights, 1).sum(axis=0)
        left, off = self._left(made.cross.sum(axis=0), made.square.sum(axis=0), pull, self.pull[:, None])
        size = np.linalg.solve(left, off)
        return float((off * size).sum()), np.asarray(size[:, 0], dtype=np.float64)

    @property
    def rights(self) -> list[Floats | None]:
        """What the readings leave, (n, 1) of each window."""
        return [None if row is None else row.right[:, None] for row in self.rows]

    @property
    def left(self) -> Floats:
        """What readings leave beside the windows' own numbers, squares over the noise, (w,); 0 where one failed."""
        return np.array([0.0 if one is None else _beside(one, one.right) @ one.right for one in self.rows])

    def shared_pull(self, rights: list[Floats | None], width: int) -> Floats:
        """Return products of the shared columns with draws, (p, draws)."""
        out = np.zeros((len(self.pull), width))
        for row, right in zip(self.rows, rights, strict=True):
            if row is not None and right is not None:
                out += row.shared.T @ right
        return out


def _beside(row: NullWindow, e: Floats) -> Floats:
    """Return columns or readings of a window, over its noise, less what its own numbers explain of them."""
    return e - row.local @ (row.hat @ e)
