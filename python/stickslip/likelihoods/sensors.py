"""What a rig on a belt records: the protocol of its sensors, and what they read."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.readings import Chain, Slopes

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """
    What sensors read: windows one after the other.

    Parameters
    ----------
    t : (n,) times
    state : (n, 9) states
    slopes : of the states kept, (n, k) by state
    names : of the k columns; "" for a window's own number
    offset : (w + 1,) where each window begins
    """

    t: Floats
    state: Floats
    slopes: Slopes
    names: tuple[str, ...]
    offset: NDArray[np.int64]


class Sensors(Protocol):
    """
    The sensors of one kind of rig.

    Parameters
    ----------
    begins : states that a window begins with, numbers of its own; the block moves with the belt
    gains : names of the channels' gains, in the order of the channels
    places : names of the channels, as effects and curves have them
    """

    @property
    def begins(self) -> tuple[int, ...]:
        """States."""
        ...

    @property
    def gains(self) -> tuple[str, ...]:
        """Names."""
        ...

    @property
    def places(self) -> tuple[str, ...]:
        """Names."""
        ...

    def on(self, constants: Mapping[str, float], /) -> Self:
        """Return the sensors of a run whose rig has some constants of its own."""
        ...

    def scale(self, values: Mapping[str, float], /) -> float:
        """Return what the first channel reads of 1 of x1 in a stick."""
        ...

    def levels(self, readings: Floats, forward: bool, stiffness: float, /) -> tuple[float, float] | None:
        """Return static and kinetic friction that an event's readings (n, channels) show; None where they do not."""

    def kept(self, known: Collection[str], channels: int, /) -> list[int]:
        """Return the states whose slopes are read under a model with the `known` numbers."""

    def read(
        self, samples: Samples, values: Mapping[str, float], belt_speed: float | Floats, channels: int
    ) -> Chain:
        """Return the readings and their slopes, gains apart."""
