"""Windows of the rig of (2.1): both displacements are read, the belt's speed where it is recorded."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.readings import Chain, read, states_read
from stickslip.likelihoods.sensors import Samples
from stickslip.simulated.states import X1, Y1, Y2

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RigSensors:
    """The sensors of x1 and y1, and of the belt where it is recorded."""

    begins: tuple[int, ...] = (X1, Y1, Y2)
    gains: tuple[str, ...] = ("gain.x1", "gain.y1")
    places: tuple[str, ...] = ("x1 channel", "y1 channel")

    def on(self, _constants: Mapping[str, float]) -> Self:
        """Return the same: no run has constants of its own."""
        return self

    def scale(self, values: Mapping[str, float]) -> float:
        """Return the gain of x1."""
        return 1.0 + values.get(self.gains[0], 0.0)

    def levels(self, _readings: Floats, _forward: bool, _stiffness: float) -> tuple[float, float] | None:
        """Return None: the force of the leg is in them."""
        return None

    def kept(self, known: Collection[str], channels: int) -> list[int]:
        """Return the states whose slopes are read."""
        return states_read(known, channels)

    def read(
        self, samples: Samples, values: Mapping[str, float], belt_speed: float | Floats, channels: int
    ) -> Chain:
        """Return the readings and their slopes."""
        return read(
            samples.t, samples.state, samples.slopes, samples.names, values, belt_speed, channels, (), samples.offset
        )  # fmt: skip
