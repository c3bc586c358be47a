"""What the past of a run tells a model of a block on a belt: states in the middles of sticks, hidden ones carried on.

A stick says where the block is; from its middle to that of the next the model runs by itself. The run is taken as it
was recorded: the belt's own direction, and the run's own time, which forces, drifts and seams go by.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.effect import FormulaEffect
from stickslip.declared.model import Model
from stickslip.errors import ModelWarning, StickslipError
from stickslip.fitted.block_events.levels import carried, number_of
from stickslip.fitted.block_events.sensor import BlockChannel
from stickslip.measured import sticks as segments
from stickslip.measured.cutting import local_state
from stickslip.simulated.lowering import hidden_states
from stickslip.simulated.simulate import simulate
from stickslip.simulated.states import HIDDEN
from stickslip.simulated.trajectory import Trajectory

Floats = NDArray[np.float64]
RTOL, ATOL = 1e-9, 1e-4  # of the noise


@dataclass(frozen=True)
class BlockStart:
    """A state of the model at a sample; `contact` as `simulate` takes it."""

    at: int
    x: float
    v: float
    hidden: dict[str, float]
    contact: str

    def moved(self, model: Model, x: float) -> BlockStart:
        """The start at another deflection, what hangs on it moved along."""
        by, hidden = x - self.x, dict(self.hidden)
        hidden["m"] += by
        hidden["z"] -= by * _softness(model)
        return BlockStart(self.at, x, self.v, hidden, self.contact)


@dataclass(frozen=True)
class Leg:
    """The model from one start to the sample `stop`: chi-squared of the readings on the way, and how it went."""

    start: BlockStart
    stop: int
    misfit: float
    released: float  # deflection at which the model lets go on the way; NaN where it does not
    end: Trajectory


@dataclass(frozen=True)
class Past:
    """Readings m (n,) of a run without what its sensor adds but the lag, NaN where missing; sticks by `track`."""

    t: Floats
    m: Floats
    noise: float
    speed: float
    track: segments.Track
    chain: BlockChannel

    def simulated(self, model: Model, start: BlockStart, t: Floats) -> Trajectory:
        """The model at times t, the first of which is the start's or later.

        Raises
        ------
        StickslipError
            The run stops before the last of them.
        """
        owned = hidden_states(model)
        names = tuple(name for name in owned if name == "m") if _by_formula(model) else HIDDEN
        out = simulate(
            model,
            belt_speed=self.speed,
            initial=(start.x, start.v, *(start.hidden[name] if name in owned else 0.0 for name in names)),
            t_start=float(self.t[start.at]),
            t_end=float(t[-1]),
            t_eval=t,
            rtol=RTOL,
            atol=ATOL * self.noise,
            contact=start.contact,  # type: ignore[arg-type]
        )
        if len(out.t) != len(t):
            raise StickslipError("the model's run stopped before the horizon")
        return out

    def lagged(self, out: Trajectory) -> Floats:
        """What the sensor would make of a run before its gain: m of `BlockChannel`."""
        return out.hidden["m"] if self.chain.lag else out.state[:, 0]

    def leg(self, model: Model, start: BlockStart, stop: int) -> Leg | None:
        """The model from a start to a sample; None where it cannot be simulated so far."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ModelWarning)  # the forecast itself says it
                out = self.simulated(model, start, self.t[start.at : stop + 1])
        except StickslipError:
            return None
        r = (self.m[start.at : stop + 1] - self.lagged(out)) / self.noise
        moves = out.transitions
        slips = np.flatnonzero((moves.before == 0) & (moves.t > self.t[start.at]))
        released = float(moves.state[slips[0], 0]) if len(slips) else np.nan
        return Leg(start, stop, float(np.nansum(r**2)), released, out)

    def resting(self, model: Model, at: int, stick: segments.Segment, before: Leg | None) -> BlockStart:
        """The state in the middle of a stick: its height from the readings, what is hidden from the leg before."""
        x = float(np.nanmean(self.m[at : stick.stop] - self.speed * (self.t[at : stick.stop] - self.t[at])))
        x += self.chain.lag * self.speed
        start = self._entered(before, at) or self.settled(model, at, x, stick)
        start = start.moved(model, x)
        for _ in range(2):  # a belt that ripples or droops does not carry the block at one speed
            leg = self.leg(model, start, stick.stop - 1)
            if leg is None:
                break
            stuck = (leg.end.mode == 0) | (start.contact == "auto")
            off = (self.m[at : stick.stop] - self.lagged(leg.end))[stuck]
            if np.isfinite(off).any():
                start = start.moved(model, start.x + float(np.nanmean(off)))
        return start

    def _entered(self, before: Leg | None, at: int) -> BlockStart | None:
        """The state that the leg before ends in, where it sticks as the block does."""
        if before is None or before.stop != at:
            return None
        soft, end = before.start.contact == "auto", before.end
        if not soft and end.mode[-1] != 0:
            return None
        hidden = dict.fromkeys(HIDDEN, 0.0) | {name: float(values[-1]) for name, values in end.hidden.items()}
        contact = "auto" if soft else "stick"
        return BlockStart(at, float(end.state[-1, 0]), float(end.state[-1, 1]), hidden, contact)

    def settled(self, model: Model, at: int, x: float, stick: segments.Segment) -> BlockStart:
        """A stick of which nothing else is known: it began at its first sample, and belt and bristles have settled."""
        force = float(carried(model, np.array([x]), self.speed)[0])
        bristle = number_of(model, "contact_compliance", "k")
        hidden = dict.fromkeys(HIDDEN, 0.0) | {
            "z": -force / bristle if bristle else 0.0,
            "b": -number_of(model, "belt_load_droop", "k") * force,
            "m": self.chain.settled(x, self.speed),
            "dwell": float(self.t[at] - self.t[stick.start]),
        }
        return BlockStart(at, x, self.speed, hidden, "auto" if bristle else "stick")

    def sliding(self, model: Model, at: int) -> BlockStart:
        """A state away from any stick, by a parabola through the readings around it."""
        m, v = local_state(self.t, self.m, at, self.track.width)
        x = m + self.chain.lag * v
        rest = self.settled(model, at, x, segments.Segment(at, at, 0))
        return BlockStart(at, x, v, rest.hidden | {"m": m, "w": v - self.speed}, "auto")

    def fitted(self, model: Model, start: BlockStart, stop: int) -> Leg | None:
        """The leg to sample `stop` from the start at which the readings on the way are met best."""
        sizes = self._free(model, start)
        readings = self.m[start.at : stop + 1]
        good = np.isfinite(readings)
        if good.sum() <= len(sizes):
            return self.leg(model, start, stop)

        def residual(p: Floats) -> Floats:
            leg = self.leg(model, _shifted(start, sizes, p), stop)
            if leg is None:
                return np.full(int(good.sum()), 1e6)
            return np.asarray(((readings - self.lagged(leg.end)) / self.noise)[good])

        def slopes(p: Floats) -> Floats:  # steps well above what the tolerance of a simulation leaves
            r, h = residual(p), 0.1
            return np.column_stack([(residual(p + h * one) - r) / h for one in np.eye(len(p))])

        best = scipy.optimize.least_squares(residual, np.zeros(len(sizes)), jac=slopes, max_nfev=12).x
        legs = [self.leg(model, one, stop) for one in (_shifted(start, sizes, best), start)]
        return min((one for one in legs if one is not None), key=lambda one: one.misfit, default=None)

    def _free(self, model: Model, start: BlockStart) -> dict[str, float]:
        """What of a start the readings are left to tell, and how far each is moved to see it."""
        sizes = {"x": self.noise}
        if start.contact == "auto":
            sizes["v"] = self.noise * float(np.sqrt(model.parameters["stiffness"] / model.parameters["mass"]))
        if "z" in hidden_states(model):
            sizes["z"] = self.noise * _softness(model)
        if self.chain.lag:
            sizes["m"] = self.noise
        return sizes


def _shifted(start: BlockStart, sizes: dict[str, float], p: Floats) -> BlockStart:
    by = {name: size * float(step) for (name, size), step in zip(sizes.items(), p, strict=True)}
    hidden = {name: value + by.get(name, 0.0) for name, value in start.hidden.items()}
    return BlockStart(start.at, start.x + by["x"], start.v + by.get("v", 0.0), hidden, start.contact)


def _softness(model: Model) -> float:
    """By how much bristles bend where the spring is drawn by 1; 0 without them."""
    bristle = number_of(model, "contact_compliance", "k")
    return model.parameters["stiffness"] / bristle if bristle else 0.0


def _by_formula(model: Model) -> bool:
    """Whether an effect by a formula acts, whose core keeps fewer hidden states."""
    return any(isinstance(one, FormulaEffect) for one in model.effects)
