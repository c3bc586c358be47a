"""Windows of a block on a belt: its displacement is read, or the force of its spring.

A force is read as the displacement that the declared spring would have: force over declared stiffness.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.data import Data
from stickslip.fitted.readings import Chain, read
from stickslip.likelihoods.sensors import Samples
from stickslip.simulated.states import LAGGED, X1

Floats = NDArray[np.float64]
DROWNED = 15.0  # standard deviations: what noise spans between peaks of its own; the least of slips was 35


@dataclass(frozen=True)
class BlockSensors:
    """
    The one sensor of a block on a belt.

    Parameters
    ----------
    gains : name of its gain: `gain.x1`, or `gain.spring_force`
    spring : declared stiffness by which a force is read; None for a displacement
    """

    gains: tuple[str, ...]
    spring: float | None
    begins: tuple[int, ...] = (X1,)
    places: tuple[str, ...] = ("x1 channel",)

    def on(self, constants: Mapping[str, float]) -> Self:
        """Return the sensors of a run with a spring of its own, by which its force is read."""
        own = constants.get("stiffness")
        return self if self.spring is None or own is None else replace(self, spring=own)

    def scale(self, values: Mapping[str, float]) -> float:
        """Return the gain, of a force times the true stiffness over the declared one."""
        gain = 1.0 + values.get(self.gains[0], 0.0)
        return gain if self.spring is None else gain * values["stiffness"] / self.spring

    def levels(self, readings: Floats, forward: bool, stiffness: float) -> tuple[float, float] | None:
        """Return static and kinetic friction by the two ends of a slip, whose middle is where the block would rest."""
        x = readings[:, 0] if forward else -readings[:, 0]
        top, low = largest_drop(x)
        bottom = float(x[low])
        return stiffness * top, 0.5 * stiffness * (top + bottom)

    def kept(self, known: Collection[str], _channels: int) -> list[int]:
        """Return the state whose slopes are read."""
        return [LAGGED if "sensor_lag.tau" in known else X1]

    def read(
        self, samples: Samples, values: Mapping[str, float], belt_speed: float | Floats, channels: int
    ) -> Chain:
        """Return the readings and their slopes; of a force the true spring's, a cubic part apart."""
        s = samples
        chain = read(s.t, s.state, s.slopes, s.names, values, belt_speed, channels, (), s.offset)
        if self.spring is None:
            return chain
        as_sprung = chain.values.copy()
        stiff = values["stiffness"] / self.spring
        chain.values *= stiff
        chain.slopes *= stiff
        if "stiffness" in s.names:
            chain.slopes[:, :, s.names.index("stiffness")] += as_sprung / self.spring
        return chain


def largest_drop(x: Floats) -> tuple[float, int]:
    """Return from where readings (n,) fall farthest, and at which they are lowest: a stick may end higher than it."""
    high = np.maximum.accumulate(x)
    low = int(np.argmax(high - x))
    return float(high[low]), low


def drowned(run: Data) -> bool:
    """Return whether what passes for slips are peaks of the velocity's noise, as a very slow run has them."""
    spans = [float(np.ptp(run.readings[a:b, 0])) for a, b in itertools.pairwise(run.slips)]
    return bool(spans) and float(np.median(spans)) < DROWNED * float(run.noise[0])
