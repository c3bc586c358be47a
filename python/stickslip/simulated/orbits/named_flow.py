"""The flow of a named rig under its own laws: one contact, on a belt that moves evenly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Effect, Tabulated
from stickslip.declared.model import Model
from stickslip.errors import InputError, StickslipError
from stickslip.simulated.lowering import READ_ALONE, hidden_states
from stickslip.simulated.orbits.flow import BEYOND, Arc, Contact, Floats, Flow, Linear, Mode, mode_of
from stickslip.simulated.orbits.period import common_multiple
from stickslip.simulated.simulate import simulate
from stickslip.simulated.states import HIDDEN
from stickslip.simulated.trajectory import Trajectory

LOOK_ON = 0.01  # of a natural time unit: how far beyond the end its rate of change is read off
NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(9) / 8)  # where, on [0, 1]


@dataclass(frozen=True)
class NamedFlow(Flow):
    """The section is x2 = 0 going down, where x1 is greatest."""

    @property
    def speed(self) -> float:
        """The belt's speed, a number here."""
        assert isinstance(self.belt_speed, float)
        return self.belt_speed

    @cached_property
    def plain(self) -> Model:
        """The model without its reading effects."""
        moving = [e for e in self.model.effects if e.name not in READ_ALONE]
        return self.model.with_effects(moving)

    @cached_property
    def hidden(self) -> tuple[str, ...]:
        """Hidden states that take part in the motion."""
        return hidden_states(self.plain)

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
        length = max(max(self.model.friction.static_limits) / stiffness, abs(self.speed) * time) or 1.0
        sizes = {"x1": length, "y1": length, "z": length, "dwell": time}  # the others are speeds
        return np.array([sizes.get(name, length / time) for name in self.states])

    @cached_property
    def forcing_period(self) -> float | None:
        """Period of what moves the rig from outside; None for an autonomous model."""
        return forcing_period(self.plain, self.speed)

    @property
    def loading_time(self) -> float:
        """How long the belt takes to load the spring from limit to limit."""
        return float(2 * self.size[0] / abs(self.speed))

    @cached_property
    def section(self) -> tuple[Floats, float]:
        """Row and level of x2 = 0."""
        return np.eye(len(self.states))[1], 0.0

    @cached_property
    def height(self) -> Floats:
        """Row of x1."""
        return np.asarray(np.eye(len(self.states))[0])

    @property
    def moves(self) -> bool:
        """Does the belt move, or something the rig?"""
        return self.speed != 0 or self.forcing_period is not None

    def initial(self, z: Floats) -> Floats:
        """Full initial state for `simulate`: visible states, then all hidden ones."""
        d = len(self.model.rig.state_names)
        full = np.zeros(d + len(HIDDEN))
        full[:d] = z[:d]
        for name, value in zip(self.hidden, z[d:], strict=True):
            full[d + HIDDEN.index(name)] = value
        return full

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
        return Arc(
            states[0], states[at], jacobian[1, :, :d], at_end, from_start, rate, run, span, run.mode[[at]]
        )

    def wiped_out(self, modes: NDArray[np.int8]) -> int:
        """How many directions a motion that sticks forgets: the block's speed, the memory of it, the time stuck."""
        return int((modes == 0).any()) * (1 + int("w" in self.hidden) + int("dwell" in self.hidden))

    def held(self, contact: Contact) -> Floats:
        """The block's speed, if it sticks."""
        row = np.eye(len(self.states))[1:2]
        return row if contact == "stick" else row[:0]

    def contact(self, modes: NDArray[np.int8]) -> Contact:
        """How a run goes on from the mode (1,)."""
        return mode_of(int(modes[0]))

    def strobed(self, contact: Contact) -> list[Contact]:
        """Of a rig moved from outside the instant at which it is looked at leaves a stick, or comes into one."""
        other: Mode = "auto" if contact == "stick" else "stick"
        return [] if self.forcing_period is None else [other]

    def in_steady_sliding(self, guess: Floats) -> Floats:
        """Return a guess with the block at rest."""
        if self.speed == 0:
            raise InputError("steady sliding needs a moving belt", key="belt_speed", value=0.0)
        z = guess.copy()
        z[1 : len(self.model.rig.state_names) : 2] = 0.0
        return z

    def linear(self, z: Floats) -> Linear:
        """Return the flow over a short time, the belt sliding under the block; its eigenvalues give the motion's."""
        span = 0.25 * self.natural_time
        arc = self.arc(z, span, contact="slip-" if self.speed > 0 else "slip+")
        kept = ~self.idle(arc.monodromy)
        values = np.log(np.linalg.eigvals(arc.monodromy[np.ix_(kept, kept)]).astype(np.complex128)) / span
        closing = arc.monodromy - np.eye(len(z))
        return Linear(arc.end - arc.start, closing, np.asarray(values, dtype=np.complex128))

    def scales(self, states: Floats) -> tuple[Floats, Floats]:
        """The model's own scale, as large as the cycle is in it; that scale."""
        visible = len(self.model.rig.state_names)
        moves = np.ptp(states[:, :visible], axis=0) / self.size[:visible]
        return self.size * float(moves.max()), self.size


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
        assert isinstance(one, Effect)  # formulas are of the other flow
        repeats = one.kind.behaves.period
        period = repeats(one.parameters, belt_speed) if repeats else None
        if period is not None:
            found[one.name] = period
    return common_multiple(found)
