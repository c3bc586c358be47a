"""The flow of a model and its derivatives, as cycles, continuation and Lyapunov exponents need them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import must_be, vector
from stickslip.declared.bodies_model import check_closed_form
from stickslip.declared.effect import Effect, Tabulated
from stickslip.declared.model import Model
from stickslip.declared.rig import on_belt
from stickslip.errors import InputError, StickslipError
from stickslip.simulated.lowering import READ_ALONE, hidden_states
from stickslip.simulated.simulate import simulate
from stickslip.simulated.states import HIDDEN
from stickslip.simulated.trajectory import Trajectory

Floats = NDArray[np.float64]
Contact = Literal["auto", "stick", "slip-", "slip+"]

BEYOND = 1e-6  # of a natural time unit: runs end so much later than their last sample, which may be an event
LOOK_ON = 0.01  # of a natural time unit: how far beyond the end its rate of change is read off
NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(9) / 8)  # where, on [0, 1]


@dataclass(frozen=True)
class Arc:
    """A stretch of motion, differentiated.

    Attributes
    ----------
    start, end : (d,) states, hidden ones included; the start as the core took it (set on the belt in stick).
    monodromy : (d, d) d end / d start.
    by_parameter, start_by_parameter : (d,) d end / d parameter, d start / d parameter; zeros without one.
    rate : (d,) d end / d span.
    run : the trajectory from start to end.
    """

    start: Floats
    end: Floats
    monodromy: Floats
    by_parameter: Floats
    start_by_parameter: Floats
    rate: Floats
    run: Trajectory
    span: float

    @property
    def signature(self) -> tuple[tuple[int, int], ...]:
        """Contact modes (before, after) of its transitions."""
        tr, inside = self.run.transitions, self.within
        return tuple(zip(tr.before[inside].tolist(), tr.after[inside].tolist(), strict=True))

    @property
    def within(self) -> NDArray[np.bool_]:
        """Which of the run's transitions lie on the arc: it is computed a little beyond."""
        return np.asarray(self.run.transitions.t <= self.span)


@dataclass(frozen=True)
class Flow:
    """A model on its belt, seen as a map of states; the effects that only touch readings are left out.

    `tolerance` is relative to the state and, where that is below 1, to the model's own scale, `size`.
    """

    model: Model
    belt_speed: float
    tolerance: float = 1e-13

    def __post_init__(self) -> None:
        must_be("model", self.model, Model, "Model(rig, friction=law) or load_model(file) give one")
        check_closed_form(self.model.rig, self.model.friction, self.model.effects)
        on_belt(self.model.rig)

    @cached_property
    def plain(self) -> Model:
        """The model without its reading effects."""
        moving = [e for e in self.model.effects if e.name not in READ_ALONE]
        return self.model.with_effects(moving)

    @cached_property
    def hidden(self) -> tuple[str, ...]:
        """Hidden states that take part in the motion."""
        return hidden_states(self.plain)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: visible, then hidden."""
        return (*self.model.rig.state_names, *self.hidden)

    @cached_property
    def natural_time(self) -> float:
        """1 / natural frequency of the block."""
        p = self.model.parameters
        return float(np.sqrt(p["mass"] / p["stiffness"])) if "mass" in p else 1.0

    @cached_property
    def size(self) -> Floats:
        """Scale of each state (d,): what the greatest friction deflects the spring, or the belt goes in that time.

        A rig of nanometres in SI moves by less than any absolute tolerance that suits one of unit size.
        """
        p, time = self.model.parameters, self.natural_time
        stiffness = p["stiffness"] if "stiffness" in p else p["alpha1"]
        length = max(max(self.model.friction.static_limits) / stiffness, abs(self.belt_speed) * time) or 1.0
        sizes = {"x1": length, "y1": length, "z": length, "dwell": time}  # the others are speeds
        return np.array([sizes.get(name, length / time) for name in self.states])

    @cached_property
    def forcing_period(self) -> float | None:
        """Period of what moves the rig from outside; None for an autonomous model."""
        return forcing_period(self.plain, self.belt_speed)

    def moved(self, name: str, value: float) -> Self:
        """Return the flow with one parameter changed."""
        if name == "belt_speed":
            return type(self)(self.model, value, self.tolerance)
        return type(self)(self.model.replace({name: value}), self.belt_speed, self.tolerance)

    def initial(self, z: Floats) -> Floats:
        """Full initial state for `simulate`: visible states, then all hidden ones."""
        d = len(self.model.rig.state_names)
        full = np.zeros(d + len(HIDDEN))
        full[:d] = z[:d]
        for name, value in zip(self.hidden, z[d:], strict=True):
            full[d + HIDDEN.index(name)] = value
        return full

    def state(self, given: ArrayLike | None, key: str) -> Floats:
        """Check a state (d,) given by the user under the name `key`; hidden states may be left out, as zero."""
        d, visible = len(self.states), len(self.model.rig.state_names)
        if given is None:
            return np.zeros(d)
        z = vector(key, given, f"{visible} numbers ({', '.join(self.states)})")
        if z.size not in (d, visible) or not np.isfinite(z).all():
            raise InputError(f"must be {visible} finite numbers ({', '.join(self.states)})", key=key)
        return np.append(z, np.zeros(d - z.size))

    def run(
        self,
        z: Floats,
        times: Sequence[float] | Floats,
        *,
        seeds: Sequence[str] = (),
        contact: Contact = "auto",
        start: float = 0.0,
    ) -> Trajectory:
        """Simulate from `z` at `start`, sampled at `times`; one that does not arrive is an error."""
        run = simulate(
            self.plain,
            belt_speed=self.belt_speed,
            initial=self.initial(z),
            t_start=start,
            t_end=float(times[-1]) + BEYOND * self.natural_time,
            t_eval=times,
            rtol=self.tolerance,
            atol=self.tolerance * min(1.0, float(self.size[:2].min())),  # of a large rig rtol decides
            sensitivity=seeds,
            contact=contact,
        )
        if not run.status.ok:
            raise StickslipError(f"the motion ends before its time: {run.status.value}")
        return run

    def full(self, run: Trajectory) -> Floats:
        """States (n, d) of a run, hidden ones included."""
        return np.column_stack([run.state, *(run.hidden[name] for name in self.hidden)])

    def jacobian(self, run: Trajectory) -> Floats:
        """Sensitivities (n, d, p) of a run, hidden states included."""
        rows = [run.hidden_sensitivity[name][:, None] for name in self.hidden]
        return np.concatenate([run.sensitivity, *rows], axis=1)

    def idle(self, monodromy: Floats) -> NDArray[np.bool_]:
        """Which states (d,) have no influence: hidden ones that are not forgotten, yet nothing else depends on them.

        The time at rest is one where nothing sticks. The derivatives are exact, and so are these zeros.
        """
        own = np.diag(monodromy)
        alone = (monodromy - np.diag(own) == 0).all(axis=0) & (own != 0)
        return np.asarray(alone & (np.arange(len(own)) >= len(self.model.rig.state_names)))

    def seeds(self) -> tuple[str, ...]:
        """Names that ask for the derivatives by the initial state."""
        return tuple(f"initial.{name}" for name in self.states)

    def arc(self, z: Floats, span: float, *, parameter: str | None = None, contact: Contact = "auto") -> Arc:
        """Follow the motion for `span` from `z`, with the derivatives of where it arrives."""
        seeds = (*self.seeds(), *(() if parameter is None else (parameter,)))
        look, way = LOOK_ON * self.natural_time, 1.0  # the rate is read off beyond the end
        while True:
            beside = span + way * look * NODES
            times = np.append(0.0, beside if way > 0 else beside[::-1])
            run = self.run(z, times, seeds=seeds, contact=contact)
            clear = way * (np.concatenate([run.transitions.t, run.kinks]) - span)
            nearest = float(clear[(clear > 0) & (clear <= look)].min(initial=2 * look))
            if nearest > look:
                break
            if nearest > 0.01 * look:
                look = 0.9 * nearest
            elif way > 0:  # an event at the very end: read it off before the end
                look, way = LOOK_ON * self.natural_time, -1.0
            else:
                break
        at, d = (1 if way > 0 else -1), len(self.states)
        states, jacobian = self.full(run), self.jacobian(run)[[0, at]]
        fit = np.polynomial.chebyshev.chebfit(2 * NODES - 1, states[1:] if way > 0 else states[:0:-1], 7)
        slope = np.polynomial.chebyshev.chebval(-1.0, np.polynomial.chebyshev.chebder(fit))
        rate = np.asarray(slope * 2 * way / look, dtype=np.float64)
        visible = len(self.model.rig.state_names)
        rate[0:visible:2] = states[at, 1:visible:2]  # exact: after a long stick all hangs on it
        from_start, at_end = jacobian[..., d] if parameter is not None else np.zeros((2, d))
        return Arc(states[0], states[at], jacobian[1, :, :d], at_end, from_start, rate, run, span)


def wiped_out(flow: Flow, sticks: bool) -> int:
    """How many directions a motion that sticks forgets: the block's speed, the memory of it, the time stuck."""
    return int(sticks) * (1 + int("w" in flow.hidden) + int("dwell" in flow.hidden))


def forcing_period(model: Model, belt_speed: float) -> float | None:
    """Period common to everything in the model that depends on time; None if nothing does.

    Raises
    ------
    InputError
        Something depends on time without a period, or the periods have no common multiple.
    """
    found: dict[str, float] = {}
    for one in model.effects:
        if isinstance(one, Tabulated):
            if one.variable == "t" and not one.of_reading:
                if one.period is None:
                    raise InputError("changes with time without a period; no motion repeats", key=one.name)
                found[one.name] = one.period
            continue
        assert isinstance(one, Effect)  # formulas were refused before
        repeats = one.kind.behaves.period
        period = repeats(one.parameters, belt_speed) if repeats else None
        if period is not None:
            found[one.name] = period
    common: float | None = None
    for name, period in found.items():
        common = period if common is None else _common_multiple(common, period, name)
    return common


def _common_multiple(first: float, second: float, name: str) -> float:
    for i in range(1, 33):
        j = round(i * first / second)
        if j > 0 and abs(i * first - j * second) < 1e-9 * i * first:
            return i * first
    raise InputError(
        f"its period {second:g} and the period {first:g} of the rest have no small common multiple; "
        "the motion is quasi-periodic, not a cycle",
        key=name,
    )
