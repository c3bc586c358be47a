"""What a fit asks of windows, of whatever rig: the windows of events of some runs under a model."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.fitted.window import WindowSpan
from stickslip.likelihoods.motion import WindowMotion
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.shared import Declared, Prior, SharedNumber

Floats = NDArray[np.float64]


class Read(Protocol):
    """A run's readings over their noise, (n, channels)."""

    @property
    def readings(self) -> Floats:
        """The array."""


RunT = TypeVar("RunT", bound=Read)
PlaceT = TypeVar("PlaceT", bound=WindowSpan)


class EventWindows(ABC, Generic[RunT, PlaceT]):
    """
    Windows, each with friction and a belt speed of its own.

    Parameters
    ----------
    model : the model; its numbers not in `numbers` are exact
    data : the runs
    stretches : where the windows are
    numbers : what all windows, or those of a run, share
    declared : what is known of the constants among them
    policy : what steers the windows

    A window's own numbers, `own` of them, are the `begins` that say where its motion begins, then its `effects`:
    random effects, with a place in each run's `places` where they have any. `kinetic` are those of kinetic friction
    at the first contact, `kinetics` at each, `statics` those of static limits, `belt` that of the belt's mean speed.
    """

    begins: int
    effects: int
    own: int
    kinetic: slice
    statics: tuple[int, ...]
    kinetics: tuple[list[int], ...]
    belt: int | None = None
    places: list[Floats]

    def __init__(
        self,
        model: Model,
        data: Sequence[RunT],
        stretches: Sequence[PlaceT],
        numbers: Sequence[SharedNumber],
        declared: Declared,
        policy: Policy,
    ) -> None:
        self.model, self.policy = model, policy
        self.data, self.stretches, self.numbers = list(data), list(stretches), tuple(numbers)
        self.prior = Prior(numbers, declared, policy.tail)
        self.channels = data[0].readings.shape[1]
        self.fixed = dict(model.parameters)
        self.by_run = [
            np.array([i for i, w in enumerate(stretches) if w.run == r], dtype=np.int64)
            for r in range(len(data))
        ]
        self.sizes = np.array([w.stop - w.start for w in stretches])

    @property
    def start(self) -> Floats:
        """Coordinates of the shared numbers where a fit starts, (p,)."""
        return np.array([n.start for n in self.numbers])

    def bounded(self, at: Floats) -> Floats:
        """Return coordinates of the shared numbers within their bounds, (p,)."""
        low, high = self.steps(np.zeros(len(self.numbers)))
        return np.clip(at, low, high)

    def steps(self, at: Floats) -> tuple[Floats, Floats]:
        """Return the least and the largest step of the shared numbers within their bounds, (p,) each."""
        low, high = (np.array([getattr(n, k) for n in self.numbers]) for k in ("low", "high"))
        return low - at, high - at

    @property
    def runs(self) -> list[int]:
        """Run of each window."""
        return [w.run for w in self.stretches]

    @abstractmethod
    def scatter(self) -> Any:
        """Return what differs from window to window, where an estimate of it starts."""

    @abstractmethod
    def first(self, at: Floats | None = None) -> Floats:
        """
        Return the windows' own numbers as the readings show them around their starts, (w, own).

        Parameters
        ----------
        at : (p,) coordinates of the shared numbers, for what is not read there; as declared by default
        """

    @abstractmethod
    def values(self, at: Floats, run: int) -> dict[str, float]:
        """Return all numbers of a run by name."""

    @abstractmethod
    def blocks(
        self,
        at: Floats,
        own: Floats,
        select: NDArray[np.bool_] | None = None,
        shared: Sequence[int] | None = None,
        local: bool = True,
    ) -> list[Floats | None]:
        """
        Return [J, S, K, r] of each window over the noise, (readings, channels, columns + 1); None where it fails.

        Parameters
        ----------
        at : (p,) coordinates of the shared numbers
        own : (w, own) the windows' own numbers
        select : windows asked for; all by default
        shared : which shared numbers have columns; all by default
        local : whether the windows' own numbers have columns
        """

    def columns(self, at: Floats, own: Floats, shared: Sequence[int]) -> list[Floats | None]:
        """
        Return derivatives of each window's readings over the noise, (readings, channels, columns); None where it fails.

        Parameters
        ----------
        at, own : as of `blocks`
        shared : which shared numbers have columns
        """
        made = self.blocks(at, own, shared=shared, local=False)
        return [None if one is None else one[:, :, :-1] for one in made]

    @abstractmethod
    def motions(self, at: Floats, own: Floats) -> list[WindowMotion | None]:
        """Return each window as simulated; None where it fails."""


def own_in(own: Floats, was: EventWindows[Any, Any], now: EventWindows[Any, Any]) -> Floats:
    """Return windows' own numbers as another hypothesis has them: states that it begins with beyond others are 0."""
    if was.begins == now.begins:
        return own
    out = np.zeros((len(own), now.own))
    kept = min(was.begins, now.begins)
    out[:, :kept], out[:, now.begins :] = own[:, :kept], own[:, was.begins :]
    return out
