"""The flow of a rig of bodies or matrices, or of a named one under a formula or on a belt that is one.

States are as in `simulate`, but seen from the drive: a coordinate that the drive carries along is less by what it
carries it. At the start of a run the two are the same, and where the drive stands still always.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.formula.tree import names
from stickslip.declared.model import Model
from stickslip.declared.places import distance
from stickslip.errors import InputError, StickslipError
from stickslip.simulated.bodies_lowering import LoweredBodies, lower_bodies
from stickslip.simulated.general import General, general
from stickslip.simulated.orbits.flow import BEYOND, Arc, Contact, Flags, Floats, Flow, Linear, Mode, mode_of
from stickslip.simulated.orbits.general_field import Field, Travel
from stickslip.simulated.orbits.general_frame import Frame, forcing_period, frame_of
from stickslip.simulated.orbits.general_scale import StateScale
from stickslip.simulated.simulate import MOST_STEPS, MOST_TRANSITIONS
from stickslip.simulated.simulate_bodies import contact_modes, run_bodies
from stickslip.simulated.trajectory import Trajectory

WAY = distance("belt_speed").name
BESIDE = 1e-6  # relative step of a number in a central difference of where what sticks is set at the start


@dataclass(frozen=True)
class GeneralFlow(Flow):
    """The section is where the deflection at the first contact is greatest, seen from the drive."""

    def __post_init__(self) -> None:
        """Refuse what no motion of can repeat, whatever the state."""
        _ = self.frame

    @cached_property
    def plain(self) -> Model:
        """The model without its reading effects."""
        whole = general(self.model, self.belt_speed, self.drive_speed)
        moving = [
            one
            for one, place in zip(self.model.effects, whole.effects.all, strict=True)
            if place.channel is None
        ]
        return self.model.with_effects(moving)

    @cached_property
    def own(self) -> General:
        """The equations."""
        return general(self.plain, self.belt_speed, self.drive_speed)

    @cached_property
    def lowered(self) -> LoweredBodies:
        """The same, as the core takes it."""
        return lower_bodies(self.own, self.plain)

    @cached_property
    def field(self) -> Field:
        """Its rates."""
        return Field(self.own)

    @cached_property
    def frame(self) -> Frame:
        """What the drive carries along, and what moves freely."""
        return frame_of(self.field)

    @cached_property
    def scale(self) -> StateScale:
        """Natural time, lengths and speeds."""
        return StateScale(self.field, self.plain, self.frame.carried, self.frame.free)

    @property
    def hidden(self) -> tuple[str, ...]:
        """States of laws and effects."""
        return self.own.hidden

    @cached_property
    def places(self) -> list[int]:
        """Place of each state among (q, v, hidden)."""
        n = len(self.own.order)
        return [*self.own.order, *range(n, n + len(self.hidden))]

    def _row(self, core: Floats) -> Floats:
        return core[self.places]

    def _core(self, z: Floats) -> Floats:
        core = np.empty(len(z))
        core[self.places] = z
        return core

    @property
    def natural_time(self) -> float:
        """1 / natural frequency of what the first contact moves."""
        return self.scale.time

    @cached_property
    def size(self) -> Floats:
        """Scale of each state (d,)."""
        return self._row(self.scale.size)

    @cached_property
    def forcing_period(self) -> float | None:
        """Period common to everything that depends on time."""
        return forcing_period(self.own, self.field, self.frame.carried)

    @property
    def loading_time(self) -> float:
        """How long the belt or the drive takes to load the spring from limit to limit."""
        return 2 * self.scale.length / self.scale.speed if self.scale.speed else np.inf

    @cached_property
    def section(self) -> tuple[Floats, float]:
        """Row and level of the rate of `height`."""
        n, row = len(self.own.equations.names), self.frame.row
        return self._row(self._filled(np.append(np.zeros(n), row))), float(
            row @ self.frame.carried * self._drive(0.0)
        )

    @cached_property
    def height(self) -> Floats:
        """Row of the deflection at the first contact that a spring holds."""
        return self._row(self._filled(self.frame.row))

    @cached_property
    def free(self) -> Floats:
        """Directions of translation along which nothing changes."""
        columns = [self._row(self._filled(one)) for one in self.frame.free.T]
        return np.column_stack([np.zeros((len(self.states), 0)), *columns])

    def _filled(self, head: Floats) -> Floats:
        return np.append(head, np.zeros(len(self.states) - len(head)))

    def _drive(self, t: float) -> float:
        return float(self.own.drive(t)) if self.own.equations.driven else 0.0

    # -- states ------------------------------------------------------------------------------------------------

    def start(self) -> Floats:
        """Moving with the drive, springs slack; hidden states as laws and effects start."""
        n = len(self.own.equations.names)
        core = np.concatenate([np.zeros(n), self.frame.carried * self._drive(0.0)])
        return self.completed(core[list(self.own.order)])

    def completed(self, visible: Floats) -> Floats:
        """State of visible states: hidden ones as laws and effects start."""
        return self._row(self.own.start(visible, {}, 0.0))

    def initial(self, z: Floats) -> Floats:
        """The state: `simulate` takes it as it is."""
        return z

    def held(self, contact: Contact) -> Floats:
        """Rows of the speeds of what sticks at the start."""
        n = len(self.own.equations.names)
        rows = [
            self._row(self._filled(np.append(np.zeros(n), self.own.equations.directions[j])))
            for j, mode in enumerate(contact_modes(self.own, contact))
            if mode == 0
        ]
        return np.array(rows).reshape(-1, len(self.states))

    # -- runs --------------------------------------------------------------------------------------------------

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
        self._check_start(contact, start)
        low, eq = self.lowered, self.own.equations
        used = [one for one, moves in ((self.own.belt, eq.on_belt), (self.own.drive, eq.driven)) if moves]
        way = [start * (one.constant or 0.0) for one in used]  # that of a formula begins anew
        core = self._core(z) + self._filled(self.frame.carried) * (way[-1] if eq.driven else 0.0)
        values = low.started(core)
        at = low.layout["initial"] + len(core)
        values[at : at + len(way)] = way
        run = run_bodies(
            low,
            values,
            contact_modes(self.own, contact),
            tuple(seeds),
            low.seeds(seeds, core, frozenset(self.hidden)),
            self.belt_speed,
            t_start=start,
            t_end=float(times[-1]) + BEYOND * self.natural_time,
            t_eval=np.asarray(times, dtype=np.float64),
            rtol=self.tolerance,
            atol=self.tolerance * min(1.0, float(self.size.min())),  # of a large rig rtol decides
            locator=_core.Locator.henon,
            max_transitions=MOST_TRANSITIONS,
            max_steps=MOST_STEPS,
        )
        if not run.status.ok:
            raise StickslipError(f"the motion ends before its time: {run.status.value}")
        return run

    def _check_start(self, contact: Contact, start: float) -> None:
        """Refuse a start for which the state is not enough: how long a stick has lasted, how far a belt has run."""
        reads = {
            key: {name for tree, _ in trees for name in names(tree)}
            for key, trees in self.field.trees().items()
        }
        modes = contact_modes(self.own, contact)
        for one, mode in zip(self.own.equations.contacts, modes, strict=True):
            if mode == 0 and "dwell" in reads[one.law or one.name]:
                words = f"contact '{one.name}' sticks where the motion is cut, and its law reads how long it has stuck"
                raise InputError(words, key="friction")
        if start and self.own.belt.constant is None and any(WAY in read for read in reads.values()):
            words = "a formula reads how far the belt has come, and its speed is a formula too; give it as a number"
            raise InputError(words, key="belt_speed")

    def full(self, run: Trajectory) -> Floats:
        """States (n, d) of a run, hidden ones included, seen from the drive."""
        states = np.column_stack([run.state, *(run.hidden[name] for name in self.hidden)])
        if self.own.equations.driven:
            states -= np.outer(run.travelled["drive_speed"], self._row(self._filled(self.frame.carried)))
        return states

    def jacobian(self, run: Trajectory) -> Floats:
        """Sensitivities (n, d, p) of a run, hidden states included, seen from the drive."""
        rows = [run.hidden_sensitivity[name][:, None] for name in self.hidden]
        out = np.concatenate([run.sensitivity, *rows], axis=1)
        if self.own.equations.driven:
            carried = self._row(self._filled(self.frame.carried))
            out = out - run.travelled_sensitivity["drive_speed"][:, None, :] * carried[None, :, None]
        return out

    def arc(self, z: Floats, span: float, *, parameter: str | None = None, contact: Contact = "auto") -> Arc:
        """Follow the motion for `span` from `z`, with the derivatives of where it arrives."""
        seeds = (*self.seeds(), *(() if parameter is None else (parameter,)))
        run = self.run(z, [0.0, span], seeds=seeds, contact=contact)
        states, jacobian, d = self.full(run), self.jacobian(run), len(self.states)
        from_start, at_end = jacobian[..., d] if parameter is not None else np.zeros((2, d))
        if parameter is not None:
            at_end = at_end - self._carried_moves(parameter, run)
        modes = np.atleast_1d(run.mode[1])
        rate = self.rate(states[1], modes, span, run)
        return Arc(states[0], states[1], jacobian[1, :, :d], at_end, from_start, rate, run, span, modes)

    def _carried_moves(self, name: str, run: Trajectory) -> Floats:
        """What is carried along is another share of the drive's way where a stiffness changes."""
        if not self.own.equations.driven or name not in self.plain.parameters:
            return np.zeros(len(self.states))
        size = self.value_of(name)
        step = BESIDE * (abs(size) or 1.0)
        ends = [self.moved(name, size + one * step).frame.carried for one in (-1, 1)]
        moved = self._row(self._filled((ends[1] - ends[0]) / (2 * step)))
        return moved * float(run.travelled["drive_speed"][-1])

    def rate(self, z: Floats, modes: NDArray[np.int8], t: float, run: Trajectory) -> Floats:
        """Return d state / d t, seen from the drive."""
        core = self._core(z)
        n = len(self.own.equations.names)
        way = {key: float(one[-1]) for key, one in run.travelled.items()}
        place = Travel(t, way.get("belt_speed", 0.0), way.get("drive_speed", 0.0))
        absolute = core + self._filled(self.frame.carried) * place.drive
        rate = self.field.rate(absolute, modes.tolist(), place)
        rate[:n] -= self.frame.carried * self._drive(t)
        return self._row(rate)

    # -- modes -------------------------------------------------------------------------------------------------

    def wiped_out(self, modes: NDArray[np.int8]) -> int:
        """A direction for every contact that sticks at the same time."""
        return int((modes == 0).sum(axis=1).max())

    def contact(self, modes: NDArray[np.int8]) -> Contact:
        """How a run goes on from the modes."""
        each = tuple(mode_of(int(one)) for one in np.atleast_1d(modes))
        return each[0] if len(each) == 1 else each

    def strobed(self, contact: Contact) -> list[Contact]:
        """One contact leaves a stick, or comes into one."""
        each = list((contact,) * len(self.own.laws) if isinstance(contact, str) else contact)
        if self.forcing_period is None and len(each) == 1:
            return []
        out = list[Contact]()
        for j, law in enumerate(self.own.laws):
            if not law.compliant:
                other: Mode = "auto" if each[j] == "stick" else "stick"
                turned = (*each[:j], other, *each[j + 1 :])
                out.append(turned[0] if len(turned) == 1 else turned)
        return out

    # -- steady sliding ----------------------------------------------------------------------------------------

    def in_steady_sliding(self, guess: Floats) -> Floats:
        """Return a guess with the speeds of the drive."""
        n, core = len(self.own.equations.names), self._core(guess)
        free = self.frame.free @ np.linalg.pinv(self.frame.free)
        core[n : 2 * n] = self.frame.carried * self._drive(0.0) + free @ core[n : 2 * n]
        v = self.field.sliding(core, 0.0)
        speeds = float(np.abs(core[n : 2 * n]).max(initial=0.0)) + self.scale.speed
        for one, contact in zip(v, self.own.equations.contacts, strict=True):
            if abs(one) <= 1e-12 * speeds:
                why = "at the guess; give the speeds it has" if free.any() else "in steady motion"
                raise InputError(f"contact '{contact.name}' does not slide {why}", key="steady sliding")
        return self._row(core)

    def linear(self, z: Floats) -> Linear:
        """Return the rates and their derivatives; what moves freely is left out."""
        core = self._core(z)
        modes = np.sign(self.field.sliding(core, 0.0)).astype(int).tolist()
        n = len(self.own.equations.names)
        gap = self.field.rate(core, modes, Travel())
        gap[:n] -= self.frame.carried * self._drive(0.0)
        closing = self.field.jacobian(core, modes, Travel())[np.ix_(self.places, self.places)]
        without = self.quotient
        columns = self.basis(self.idle_rates(closing))
        values = np.linalg.eigvals(columns.T @ closing @ columns).astype(np.complex128)
        return Linear(without @ self._row(gap), without @ closing, values)

    def idle_rates(self, closing: Floats) -> Flags:
        """Which states have no influence on the rates of others: hidden ones."""
        others = closing - np.diag(np.diag(closing))
        return np.asarray((others == 0).all(axis=0) & (np.arange(len(closing)) >= len(self.own.order)))

    def scales(self, states: Floats) -> tuple[Floats, Floats]:
        """How far each state moves on the cycle, for both."""
        size = np.maximum(np.ptp(states, axis=0), 1e-6 * self.size)
        return size, size
