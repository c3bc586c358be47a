"""The channel of a block on a belt: from its motion to the reading, and back."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated
from stickslip.declared.model import Model
from stickslip.errors import InputError
from stickslip.fitted.formula_reading import FormulaReading, formulas_of
from stickslip.simulated.states import COUNT, X1, X2
from stickslip.simulated.x1_sensor import X1Sensor

Floats = NDArray[np.float64]
TURNS = 40  # of undoing curves: each leaves their slope's share of what the last left


@dataclass(frozen=True)
class BlockChannel:
    """What the channel makes of the deflection x: what `bend` makes of m, x or x lagged, and curves added.

    What formulas make of x is x and what they add, in the place of a curve.
    """

    bend: X1Sensor = field(default_factory=X1Sensor)
    lag: float = 0.0
    curves: tuple[Tabulated | FormulaReading, ...] = ()

    @property
    def gain(self) -> float:
        """Reading by deflection, where that is small."""
        return self.bend.gain

    def read(self, x: Floats, m: Floats | None, t: Floats) -> Floats:
        """Readings of a motion, (n,); `m` where there is a lag."""
        return self.bend.of(x if m is None or not self.lag else m, t) + self._added(x, t)

    def settled(self, x: float, v: float) -> float:
        """m of a motion that has been steady for long."""
        return x - self.lag * v

    def steady(self, reading: Floats, v: float, t: Floats) -> Floats:
        """Deflections behind readings without curves taken in motion at a steady v."""
        return self.bend.undone(reading, t) + self.lag * v

    def behind(self, reading: Floats, rate: Floats, t: Floats) -> tuple[Floats, Floats]:
        """(Lagged) deflections m and their rates behind readings and theirs; the deflection is m + lag m'."""
        m = self.bend.undone(reading, t)
        moves = self.bend.moves(m, rate)
        for _ in range(TURNS if self.curves else 0):
            x = m + self.lag * moves
            m = self.bend.undone(reading - self._added(x, t), t)
            moves = self.bend.moves(m, rate - self._added_rate(x, moves, t))
        return m, moves

    def motion(self, t: Floats, reading: Floats, noise: float) -> tuple[Floats, float]:
        """The (lagged) deflections (n,) behind readings (n,), NaN where those are missing, and their noise."""
        good = np.isfinite(reading)
        filled = np.interp(t, t[good], reading[good])
        m, _ = self.behind(filled, np.gradient(filled, t), t)
        return np.where(good, m, np.nan), noise / abs(self.gain)

    def _added(self, x: Floats, t: Floats) -> Floats:
        """What curves add, (n,)."""
        out = np.zeros(len(x))
        for one in self.curves:
            out += (
                formula_adds(one, x, t)
                if isinstance(one, FormulaReading)
                else one.curve(x if one.variable == "x1" else t)
            )
        return out

    def _added_rate(self, x: Floats, v: Floats, t: Floats) -> Floats:
        """The rate of that, (n,)."""
        out, along = np.zeros(len(x)), {"x1": (x, v), "t": (t, 1.0)}
        for one in self.curves:
            if isinstance(one, FormulaReading):
                state = _state(x, v)
                out += one.rate(v, one.at(x, t, state, {}), state) - v
                continue
            at, moves = along[one.variable]
            out += one.curve(at, 1) * np.asarray(moves)
        return out


def reading_of(model: Model, force_channel: bool) -> BlockChannel:
    """The chain from deflection to reading: a force is recorded by the true spring, and read by the declared one.

    Raises
    ------
    InputError
        A curve in x2: the velocity behind the readings is not known without undoing it.
    """
    p = model.parameters
    sensor, lag = X1Sensor.acting(p), p.get("sensor_lag.tau", 0.0)
    if force_channel:
        sensor = replace(sensor, gain=sensor.gain * (1 + p.get("rig_stiffness.e", 0.0)))
    curves = tuple(one for one in model.effects if isinstance(one, Tabulated) and one.of_reading)
    formulas = formulas_of(model)
    if any(one.variable == "x2" for one in curves) or any(X2 in one.states for one in formulas):
        words = "a curve of the reading in x2 cannot be undone where x1 alone is recorded; one in x1 or t can"
        raise InputError(words, key="learned_x1_x2")
    return BlockChannel(sensor, lag, (*curves, *formulas))


def formula_adds(one: FormulaReading, x: Floats, t: Floats) -> Floats:
    """Return what a formula adds to deflections (n,) at times t."""
    return one.read(one.at(x, np.broadcast_to(t, x.shape), _state(x, np.zeros_like(x)), {}), x.shape) - x


def _state(x: Floats, v: Floats) -> Floats:
    out = np.zeros((len(x), COUNT))
    out[:, X1], out[:, X2] = x, v
    return out
