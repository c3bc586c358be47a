"""Forecasts of a block on a belt: the state and the level of friction from the past alone, then the model's own run."""

from __future__ import annotations

from dataclasses import InitVar, dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effects import Effect
from stickslip.declared.friction import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.errors import StickslipError
from stickslip.fitted.block_events.cycle import S
from stickslip.fitted.block_events.levels import carried, held_at
from stickslip.fitted.block_events.sensor import Reading, reading_of
from stickslip.fitted.block_events.table import Measured
from stickslip.simulated.lowering import HIDDEN
from stickslip.simulated.simulate import simulate

Floats = NDArray[np.float64]
RECENT = 3  # events whose mean level is carried on
HELD = 0.1  # s, or a third of a natural period: the end of a stick that its height is taken from
PHASES = 48


@dataclass(frozen=True)
class Prediction:
    """Readings x, deflections and velocities, modes and belt's-frame speeds at times t, (n,)."""

    t: Floats
    reading: Floats
    state: Floats
    mode: NDArray[np.int8]


@dataclass
class Forecaster:
    """Forecasts one run with one model; x rises in its sticks, as in `Run`."""

    model: Model
    measured: Measured
    reading: InitVar[Reading | None] = None  # of the measured run's channel; the model's own if none is given

    def __post_init__(self, reading: Reading | None) -> None:
        run = self.measured.run
        rig = (
            replace(run.rig, damping=self.model.rig.damping)
            if isinstance(self.model.rig, BlockOnBelt)
            else run.rig
        )
        self.model = replace(self.model, rig=rig, friction=seen(self.model.friction, run.sign))
        self.chain = reading or reading_of(self.model, run.force_channel)

    def state(self, stop: int) -> tuple[float, float, float]:
        """Deflection, velocity and (lagged) deflection as read, at sample `stop`, from the readings before it."""
        run = self.measured.run
        t0 = float(run.t[stop - 1])
        stick = next((s for s in reversed(run.track.sticks) if s.start < stop), None)
        if stick is not None and stop <= stick.stop:
            first = max(stick.start, int(np.searchsorted(run.t, t0 - HELD)))
            at = np.arange(min(first, stop - 4), stop)
            at = at[np.isfinite(run.x[at])]
            early = self.chain.steady(run.x[at], run.belt_speed, run.t[at])
            x = float(np.median(early + run.belt_speed * (t0 - run.t[at])))
            return x, run.belt_speed, self.chain.settled(x, run.belt_speed)
        at = np.arange(max(0, stop - 16), stop)
        at = at[np.isfinite(run.x[at])]
        x, v, m = self._slipping(run.x[at], run.t[at], t0)
        return x, min(v, run.belt_speed), m

    def _slipping(self, read: Floats, t: Floats, t0: float) -> tuple[float, float, float]:
        """State at t0 from the last readings of a slip: a parabola of what the lag leaves, m; x is m + tau m'."""
        m = np.polynomial.Polynomial.fit(t - t0, self.chain.undone(read, t), 2).convert()
        lag = self.chain.lag
        return float((m + lag * m.deriv())(0.0)), float((m.deriv() + lag * m.deriv(2))(0.0)), float(m(0.0))

    def level(self, before: float) -> float:
        """The friction of the last events before a time over the law's: no law predicts how runs differ.

        A lag rounds the tops off, and where they are fitted the release looks late: 2 % too high a level for a lag of
        a twelfth of the natural period.
        """
        e = self.measured.events
        past = np.flatnonzero(e.t < before)[-RECENT:]
        if not len(past):
            return 1.0
        top = self.chain.steady(e.p[past, S], self.measured.run.belt_speed, e.t[past])
        force = carried(self.model, top, self.measured.run.belt_speed)
        return float(np.mean(force) / self.model.friction.static_limits[0])

    def forecast(self, stop: int, future: Floats) -> Prediction:
        """Readings at `future` times from samples before `stop`."""
        run = self.measured.run
        t0 = float(run.t[stop - 1])
        x, v, m = self.state(stop)
        factor = self.level(t0)
        law = seen(self.model.friction, 1.0, factor)
        now = replace(self.model, friction=law).with_effects(self._without_slow())
        if v == run.belt_speed:  # a stick cannot begin above its limit
            x = min(x, held_at(self.model, 0.9999 * law.static_limits[0], run.belt_speed))
        t = future - t0
        out = simulate(
            now,
            belt_speed=run.belt_speed,
            initial=(x, v, *(m if name == "m" else 0.0 for name in HIDDEN)) if self.chain.lag else (x, v),
            t_end=float(t[-1]),
            t_eval=t,
            rtol=1e-7,
            atol=1e-10,
        )
        if len(out.t) != len(future):
            raise StickslipError("the model's run stopped before the horizon")
        reading = self.chain.read(out.state[:, 0], out.hidden.get("m"), future)
        return Prediction(future, reading, np.asarray(out.state), np.asarray(out.mode, dtype=np.int8))

    def _without_slow(self) -> list[Effect]:
        """What varies over many events is in the level of the last ones already."""
        slow = ("belt_seam", "harmonic_forcing", "friction_drift")
        return [one for one in self.model.effects if isinstance(one, Effect) and one.name not in slow]


def seen(law: FrictionLaw, sign: float, factor: float = 1.0) -> FrictionLaw:
    """The law times a factor, as the block feels it when the belt's direction is turned to be positive."""
    values = {one.name: getattr(law, one.name) for one in fields(law)}
    if sign < 0:
        own = {n: values.get(f"{n}_plus") for n in values if f"{n}_plus" in values}
        turned = {n: values[n] if v is None else v for n, v in own.items()}
        values |= turned | {f"{n}_plus": values[n] for n, v in own.items() if v is not None}
    sized = {n: v if v is None or n.startswith("decay") else v * factor for n, v in values.items()}
    return type(law)(**sized)


def instants(measured: Measured, cycle: float, most: int) -> list[int]:
    """Samples to forecast from: the middles of sticks, after the first few events and before the last cycle."""
    run, e = measured.run, measured.events
    if len(e) < RECENT + 1:
        return []
    first, last = float(e.t[RECENT - 1]), float(run.t[-1]) - cycle
    middles = [(s.start + s.stop) // 2 for s in run.track.sticks if s.stop - s.start >= 12]
    kept = [i for i in middles if first < run.t[i] < last]
    if len(kept) > most:
        kept = [kept[i] for i in np.unique(np.linspace(0, len(kept) - 1, most).astype(int))]
    return kept


def cycle_of(measured: Measured) -> float:
    """Mean time from event to event."""
    e = measured.events
    gaps = np.diff(e.t)
    return float(np.median(gaps)) if len(gaps) else float(measured.run.t[-1])
