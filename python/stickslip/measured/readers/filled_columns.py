"""Columns filled chunk by chunk, neighbours averaged where a file has too many rows to be held."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HELD = 24_000_000  # numbers of a file that are held, of all columns: a recording takes 40 bytes for each of them, 1 GB
FEW = 8  # neighbours that numpy adds in their order


def neighbours(rows: int, columns: int) -> int:
    """Return how many rows are averaged so that the columns of a file can be held; 1: each is kept."""
    return max(1, -(-rows * columns // HELD))


class FilledColumns:
    """Columns that are filled from the rows of a file.

    Parameters
    ----------
    names
        Of the columns.
    count
        Rows of the file.
    k
        Neighbours that are averaged; the last ones, fewer than k, are left out.

    Attributes
    ----------
    rows
        Rows that came.
    """

    def __init__(self, names: Sequence[str], count: int, k: int = 1) -> None:
        self.names, self.k, self.rows = names, k, 0
        self._columns = [np.empty(count // k) for _ in names]
        self._rest = [np.empty(0) for _ in names]
        self._last = [np.nan] * len(names)
        self._turns = [[-1, -1] for _ in names]

    @property
    def values(self) -> dict[str, Floats]:
        """The columns, (n,) each, by name."""
        return dict(zip(self.names, self._columns, strict=True))

    @property
    def turns(self) -> dict[str, tuple[int, int]]:
        """By column, the first row not above the one before, and the first not below it; -1: none, or not averaged."""
        return {name: (up, down) for name, (up, down) in zip(self.names, self._turns, strict=True)}

    def add(self, columns: Sequence[Floats]) -> None:
        """Take the next rows, (n,) of each column."""
        count = columns[0].size
        if self.k == 1:
            for column, more in zip(self._columns, columns, strict=True):
                room = column[self.rows : self.rows + count]
                room[:] = more[: room.size]
        else:
            self._see_turns(columns)
            self._average(columns)
        self.rows += count

    def _average(self, columns: Sequence[Floats]) -> None:
        """Add the means of whole groups, and keep what is left for the next rows."""
        at = (self.rows - self._rest[0].size) // self.k
        for i, more in enumerate(columns):
            values = np.concatenate([self._rest[i], more]) if self._rest[i].size else more
            whole = values.size // self.k * self.k
            means = _means(values[:whole], self.k)
            room = self._columns[i][at : at + means.size]
            room[:] = means[: room.size]
            self._rest[i] = values[whole:].copy()

    def _see_turns(self, columns: Sequence[Floats]) -> None:
        """Note where a column first fails to rise, and to fall: means do not show it."""
        for i, column in enumerate(columns):
            if min(self._turns[i]) >= 0:
                continue
            step = np.diff(column, prepend=self._last[i])
            for side, wrong in enumerate((step <= 0, step >= 0)):
                if self._turns[i][side] < 0 and wrong.any():
                    self._turns[i][side] = self.rows + int(np.argmax(wrong))
            self._last[i] = float(column[-1])


def _means(values: Floats, k: int) -> Floats:
    """The means of k neighbours, (n/k,); numpy takes those of a few slowly, one by one."""
    if k >= FEW:
        return np.asarray(values.reshape(-1, k).mean(axis=1))
    total = values[::k].copy()
    for i in range(1, k):
        total += values[i::k]
    return total / k
