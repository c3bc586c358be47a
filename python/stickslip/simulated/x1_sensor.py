"""What the sensor of x1 sees, and what it makes of that: gain, curvature and drift; forward, back, and their rates.

The one place of these formulas: simulated readings, those of a fit, those of a block slip by slip, and their rates
stand on it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.simulated.states import LAGGED, X1, X2, Y1, Y2

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class X1Sensor:
    """Reading = gain m + curvature m^2 + drift t of what is seen, m: x1, with crosstalk, or lagged."""

    gain: float = 1.0
    curvature: float = 0.0
    drift: float = 0.0

    @classmethod
    def acting(cls, p: Mapping[str, float]) -> X1Sensor:
        """Return the sensor of a model's numbers by their full names."""
        return cls(
            1 + p.get("sensor_gain.e", 0.0), p.get("sensor_nonlinearity.q", 0.0), p.get("sensor_drift.r", 0.0)
        )

    def of(self, m: Floats, t: Floats) -> Floats:
        """Readings of m at times t."""
        return np.asarray(self.gain * m + self.curvature * m**2 + self.drift * t)

    def slope(self, m: Floats | float) -> Floats:
        """Derivative of the readings by m."""
        return np.asarray(self.gain + 2 * self.curvature * m)

    def rate(self, m: Floats, moves: Floats) -> Floats:
        """Rates of the readings of m that moves."""
        return np.asarray(moves * self.slope(m) + self.drift)

    def undone(self, reading: Floats | float, t: Floats | float) -> Floats:
        """What is behind readings, on the branch through 0; at the fold where the reading lies beyond it."""
        return unbent((reading - self.drift * t) / self.gain, self.curvature / self.gain)

    def moves(self, m: Floats, rate: Floats) -> Floats:
        """Rate of m behind that of its reading; where the curvature folds back, that of the edge."""
        slope, least = self.slope(m), 0.01 * self.gain
        return np.asarray((rate - self.drift) / np.where(np.abs(slope) < least, least, slope))


def seen(p: Mapping[str, float], state: Floats) -> Floats:
    """What the sensor sees of states (n, 9), by a model's numbers: x1 with crosstalk, or what lags behind that."""
    return np.asarray(state[:, LAGGED] if "sensor_lag.tau" in p else _crossed(p, state)[0])


def seen_rate(p: Mapping[str, float], state: Floats) -> Floats:
    """The rate of what the sensor sees."""
    x, moves = _crossed(p, state)
    return np.asarray((x - state[:, LAGGED]) / p["sensor_lag.tau"] if "sensor_lag.tau" in p else moves)


def _crossed(p: Mapping[str, float], state: Floats) -> tuple[Floats, Floats]:
    """X1 with crosstalk, and its rate."""
    c = p.get("sensor_crosstalk.c", 0.0)
    return (
        (state[:, X1] + c * state[:, Y1], state[:, X2] + c * state[:, Y2])
        if c
        else (state[:, X1], state[:, X2])
    )


def unbent(reading: Floats | float, q: float) -> Floats:
    """m of m + q m^2 = reading, on the branch through 0; at the fold where the reading lies beyond it."""
    return np.asarray(2 * reading / (1 + np.sqrt(np.maximum(1 + 4 * q * reading, 0.0))))
