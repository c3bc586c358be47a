"""Motion of a driven slider under a recorded drive, or in the position loop of its controller.

Moreau's time stepping: over a substep the smooth forces act explicitly and friction as the impulse, up to its limit,
that brings the velocity nearest to zero. Sticking, release and turns need no event location; the error is of the order
of the substep. Many lanes move at once: arrays (m,).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import DRIVEN, Effect, Tabulated
from stickslip.declared.effect_terms import At
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.errors import InputError

Floats = NDArray[np.float64]

SUBSTEPS = 8


@dataclass
class State:
    """Position, velocity, relative bristle deflection and lagged drive of every lane (m,)."""

    x: Floats
    v: Floats
    z: Floats
    f: Floats


class Slider:
    """A model of a driven slider, ready to be moved.

    Parameters
    ----------
    model
        Its rig is a `DrivenSlider`, its law a `CoulombFriction`.
    dt
        Sampling interval over which the drive is held [s].
    substeps
        Steps within it.

    Raises
    ------
    InputError
        Another rig.
    """

    def __init__(self, model: Model, dt: float, *, substeps: int = SUBSTEPS) -> None:
        rig, law = model.rig, model.friction
        if not isinstance(rig, DrivenSlider):
            raise InputError("only a driven slider is moved by a drive; use stickslip.simulate", key="rig")
        assert isinstance(law, CoulombFriction)  # a model of a driven slider has no other
        self.h, self.dt, self.substeps = dt / substeps, dt, substeps
        self.p = {one.name: dict(one.parameters) for one in model.effects if isinstance(one, Effect)}
        self.curves = [one for one in model.effects if isinstance(one, Tabulated)]
        ranks = {name: i for i, name in enumerate(DRIVEN)}
        own = [(DRIVEN[name].adds, self.p[name]) for name in sorted(self.p, key=ranks.__getitem__)]
        # formulas by what they add to, sorted once: a substep takes as long as a few of them
        self.forces = [(adds.block, p) for adds, p in own if adds.block]
        self.gains = [(adds.drive, p) for adds, p in own if adds.drive]
        self.shares = [(adds.friction, p) for adds, p in own if adds.friction]
        self.peaks = [(adds.peak, p) for adds, p in own if adds.peak]
        self.sided = {name: (s, p) for name, p in self.p.items() if (s := DRIVEN[name].adds.sides)}
        self.mass = rig.mass * (1 + self.p.get("rig_mass", {}).get("e", 0.0))
        # a bristle T = k z + c v brakes by c v as the rig's own damping does
        self.damping = rig.damping + self.p.get("contact_compliance", {}).get("c", 0.0)
        self.kinetic, self.static = law.kinetic_limits, law.static_limits
        self.delay = self.p.get("drive_delay", {}).get("delay", 0.0)

    def start(self, x: Floats, v: Floats, drive: Floats) -> State:
        """The state of lanes that move at `v` under a steady drive."""
        return State(x.copy(), v.copy(), np.sign(v), drive.copy())

    def step(
        self, s: State, t: float | Floats, drive: Callable[[int], Floats], noise: Floats | float = 0.0
    ) -> None:
        """Move every lane on by one sampling interval from time `t`.

        Parameters
        ----------
        s
            Changed in place.
        t
            Time at the beginning; (m,) where lanes differ.
        drive
            Command (m,) in the interval so many intervals after this one; called with 0 or, for a delayed drive,
            with what that asks for.
        noise
            Another force, held over the interval.
        """
        h = self.h
        k = 0.5 * h * self.damping / self.mass  # damping acts on the mean of the velocities before and after
        for i in range(self.substeps):
            at = (i + 0.5) * h
            f = drive(int(np.floor((at - self.delay) / self.dt)) if self.delay else 0)
            x, v, now = s.x + 0.5 * h * s.v, s.v, t + at
            if "drive_lag" in self.p:
                s.f = f + (s.f - f) * np.exp(-h / self.p["drive_lag"]["tau"])
                f = s.f
            smooth = self._gain(x, f, now) * f + self.block(x, v, now) + noise
            low, high = self.limits(x, v, now)
            if "contact_compliance" in self.p:
                self._bristle(s, v)
                v_new = (1 - k) * v + h * (smooth - np.where(s.z > 0, high, low) * s.z) / self.mass
            else:
                free = (1 - k) * v + h * smooth / self.mass
                v_new = free - np.clip(free, -h * low / self.mass, h * high / self.mass)
            v_new = v_new / (1 + k)
            s.x = s.x + 0.5 * h * (v + v_new)
            s.v = v_new

    def _gain(self, x: Floats, f: Floats, t: float | Floats) -> Floats | float:
        gain: Floats | float = 1.0
        if self.gains:
            at = At(t=t, x1=x, drive=f)
            for share, p in self.gains:
                gain = gain + share(p, at)
        return gain

    def block(self, x: Floats, v: Floats, t: float | Floats) -> Floats | float:
        """Force on the slider (m,) of effects that are neither friction nor drive."""
        force: Floats | float = 0.0
        if self.forces:
            at = At(t=t, x1=x, x2=v)
            if self.sided:
                at = replace(at, sides={name: sides.start(p, at) for name, (sides, p) in self.sided.items()})
            for add, p in self.forces:
                force = force + add(p, at)
        for one in self.curves:
            if one.where == "block":
                force = force + one.curve(self._variable(one, x, v, t))
        return force

    def _variable(self, one: Tabulated, x: Floats, v: Floats, t: float | Floats) -> Floats | float:
        return x if one.variable == "x1" else t if one.variable == "t" else v

    def limits(self, x: Floats, v: Floats, t: float | Floats) -> tuple[Floats, Floats]:
        """Magnitudes of friction against either direction; the static ones for a lane at rest."""
        u = np.abs(v)
        rest = v == 0
        low = np.where(rest, self.static[0], self.kinetic[0])
        high = np.where(rest, self.static[1], self.kinetic[1])
        scale: Floats | float = 1.0
        more: Floats | float = 0.0
        if self.shares:
            at = At(t=t, x1=x, x2=v)
            for share, p in self.shares:
                scale = scale + share(p, at)
        for peak, p in self.peaks:
            more = more + peak(p, u)
        for one in self.curves:
            if one.where == "contact":
                scale = scale + one.curve(self._variable(one, x, v, t))
        return np.maximum(low * scale + more, 0.0), np.maximum(high * scale + more, 0.0)

    def _bristle(self, s: State, v: Floats) -> None:
        d = 0.5 * sum(self.kinetic) / self.p["contact_compliance"]["k"]
        sign = np.sign(v)
        s.z = sign + (s.z - sign) * np.exp(-np.abs(v) * self.h / d)


def forecast(
    model: Model, t: Floats, command: Floats, start: NDArray[np.intp], x: Floats, v: Floats, steps: int
) -> Floats:
    """Positions (steps + 1, m) from the samples `start` on, under the recorded drive.

    Parameters
    ----------
    model
        As for `Slider`.
    t, command
        Times and drive (n,) of the record, SI.
    start
        Sample at which each lane begins (m,); lanes must end within the record.
    x, v
        State there (m,).
    steps
        Samples ahead.
    """
    slider = Slider(model, float(np.median(np.diff(t))))
    s = slider.start(x, v, command[np.maximum(start - 1, 0)])
    out = np.empty((steps + 1, len(start)))
    out[0] = x
    for k in range(steps):

        def drive(ahead: int, at: NDArray[np.intp] = start + k) -> Floats:
            return command[np.clip(at + ahead, 0, len(t) - 1)]

        slider.step(s, t[start + k], drive)
        out[k + 1] = s.x
    return out


@dataclass(frozen=True)
class Loop:
    """The position loop of EMPS: v = kp kv (reference - x) - kv dx, force = gain v, |v| <= limit.

    dx is the backward difference of the mean of the last two readings; `quantum` is the step of the encoder (0: none).
    """

    gain: float
    kp: float
    kv: float
    limit: float = 10.0
    quantum: float = 0.0


@dataclass(frozen=True)
class Driven:
    """A simulated loop: readings `x`, true `velocity`, `acceleration` and `command` [V], each (n,) or (n, m)."""

    x: Floats
    velocity: Floats
    acceleration: Floats
    command: Floats


def closed_loop(
    model: Model,
    loop: Loop,
    t: Floats,
    reference: Floats,
    *,
    start: tuple[float, float] = (0.0, 0.0),
    noise: Floats | None = None,
    substeps: int = SUBSTEPS,
) -> Driven:
    """Simulate the slider in its position loop.

    Parameters
    ----------
    model, loop
        What moves and what drives it.
    t, reference
        Times and set-point (n,).
    start
        Position and velocity at first.
    noise
        Process noise [N] (n, m), held over each interval; None: one lane without.

    Raises
    ------
    InputError
        The model is of another rig, or its drive acts before its command.
    """
    n = len(t)
    w = np.zeros((n, 1)) if noise is None else noise
    lanes = w.shape[1]
    dt = float(np.median(np.diff(t)))
    slider = Slider(model, dt, substeps=substeps)
    if slider.delay < 0:
        words = "a loop cannot act before it has read; give a delay of 0 or more"
        raise InputError(words, key="drive_delay.delay", value=slider.delay)
    ones = np.ones(lanes)
    s = slider.start(start[0] * ones, start[1] * ones, 0.0 * ones)
    x, velocity, acceleration, command = (np.empty((n, lanes)) for _ in range(4))
    # what the loop read before it began, had the slider moved on like this
    back = [start[0] - (k * dt) * start[1] for k in (2, 1)]
    before, last = back[0] * ones, back[1] * ones
    for k in range(n):
        read = s.x if loop.quantum == 0 else loop.quantum * np.round(s.x / loop.quantum)
        # the difference of two means of two readings each
        rate = 0.5 * (read - before) / dt
        u = np.clip(loop.kp * loop.kv * (reference[k] - read) - loop.kv * rate, -loop.limit, loop.limit)
        x[k], velocity[k], command[k] = read, s.v, u
        before, last = last, read
        v = s.v

        def drive(ahead: int, at: int = k) -> Floats:
            return np.asarray(loop.gain * command[min(max(at + ahead, 0), at)], dtype=np.float64)

        slider.step(s, t[k], drive, w[k])
        acceleration[k] = (s.v - v) / dt
    one = noise is None
    return Driven(*((a[:, 0] if one else a) for a in (x, velocity, acceleration, command)))
