"""A window: a stretch of a run that one simulation meets, and the initial states that it is simulated from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stickslip.simulated import states

Floats = NDArray[np.float64]
STATES, BELT, LAGGED, DWELL = states.COUNT, states.BELT, states.LAGGED, states.DWELL
AUTO, STICK = 2, 0
SLIPPING = 3  # AUTO for the core, and sure not to start in stick


class WindowSpan(Protocol):
    """Where a window is: samples start <= i < stop of a run."""

    @property
    def run(self) -> int:
        """Number of the run."""

    @property
    def start(self) -> int:
        """First sample."""

    @property
    def stop(self) -> int:
        """The sample behind the last."""


@dataclass(frozen=True)
class Window:
    """Samples start <= i < stop of a run, met by one simulation.

    `state` (9,) is its initial state, hidden states included; `free` the entries estimated; `spread` (9,) the
    weak Gaussian that holds free hidden states about `centre`; `contact` the mode it starts in.
    """

    run: int
    start: int
    stop: int
    state: Floats
    free: tuple[int, ...]
    centre: Floats
    spread: Floats
    contact: int = AUTO


def by_free(windows: Sequence[Window]) -> dict[tuple[int, ...], list[int]]:
    """Indices of the windows that have the same free states."""
    kinds: dict[tuple[int, ...], list[int]] = {}
    for i, w in enumerate(windows):
        kinds.setdefault(w.free, []).append(i)
    return kinds


def window_penalties(windows: Sequence[Window]) -> Floats:
    """Prior of each window's own free states, (w,); what is not free has an infinite spread."""
    if not windows:
        return np.empty(0)
    state, centre, spread = (
        np.stack([getattr(w, key) for w in windows]) for key in ("state", "centre", "spread")
    )
    return np.asarray(np.sum(((state - centre) / spread) ** 2, axis=1))


def moved(window: Window, step: Floats) -> Window:
    """The window with its free states shifted."""
    state = window.state.copy()
    state[list(window.free)] += step
    return with_state(window, state)


def with_state(window: Window, state: Floats) -> Window:
    """The window with another state; `dataclasses.replace` takes ten times as long, and a fit does it so often."""
    out = object.__new__(Window)
    out.__dict__.update(window.__dict__, state=state)
    return out
