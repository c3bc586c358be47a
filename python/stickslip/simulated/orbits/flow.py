"""The flow of a model and its derivatives, as cycles, continuation and Lyapunov exponents need them.

One set of methods asks for it; `named_flow` and `general_flow` give it, `flow_of` chooses.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import vector
from stickslip.declared.model import Model
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError
from stickslip.simulated.trajectory import Trajectory

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Complexes = NDArray[np.complex128]
Mode = Literal["auto", "stick", "slip-", "slip+"]
Contact = Mode | tuple[Mode, ...]  # of the only contact, or of each
Signature = tuple[tuple[int | tuple[int, ...], int | tuple[int, ...]], ...]
BeltSpeed = float | Speed | None
SPEEDS = ("belt_speed", "drive_speed")  # parameters that are no numbers of the model

BEYOND = 1e-6  # of a natural time unit: runs end so much later than their last sample, which may be an event


def sticks_at(contact: Contact) -> bool:
    """Does a contact stick there?"""
    return "stick" in ((contact,) if isinstance(contact, str) else contact)


def mode_of(sign: int) -> Mode:
    """Name a mode of the core."""
    return "stick" if sign == 0 else "slip-" if sign < 0 else "slip+"


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
    modes : (contacts,) at the end.
    """

    start: Floats
    end: Floats
    monodromy: Floats
    by_parameter: Floats
    start_by_parameter: Floats
    rate: Floats
    run: Trajectory
    span: float
    modes: NDArray[np.int8]

    @property
    def signature(self) -> Signature:
        """Contact modes (before, after) of its transitions; of a rig of bodies or matrices those of every contact."""
        tr, inside = self.run.transitions, self.within
        pairs = zip(tr.before[inside].tolist(), tr.after[inside].tolist(), strict=True)
        if tr.before.ndim == 1:
            return tuple(pairs)
        return tuple((tuple(a), tuple(b)) for a, b in pairs)

    @property
    def within(self) -> Flags:
        """Which of the run's transitions lie on the arc: it is computed a little beyond."""
        return np.asarray(self.run.transitions.t <= self.span)


@dataclass(frozen=True)
class Linear:
    """The motion about a state near steady sliding: Newton's equation for it, and the eigenvalues there.

    `gap` (d,) vanishes at the equilibrium, `closing` (d, d) is its derivative.
    """

    gap: Floats
    closing: Floats
    eigenvalues: Complexes


@dataclass(frozen=True)
class Flow(ABC):
    """A model and what moves it, seen as a map of states; the effects that only touch readings are left out.

    `tolerance` is relative to the state and, where that is below 1, to the model's own scale, `size`.
    """

    model: Model
    belt_speed: BeltSpeed
    drive_speed: BeltSpeed = None
    tolerance: float = 1e-13

    # -- what each kind of rig says ------------------------------------------------------------------------------

    @property
    @abstractmethod
    def plain(self) -> Model:
        """The model without its reading effects."""

    @property
    @abstractmethod
    def hidden(self) -> tuple[str, ...]:
        """Hidden states that take part in the motion."""

    @property
    @abstractmethod
    def natural_time(self) -> float:
        """1 / natural frequency."""

    @property
    @abstractmethod
    def size(self) -> Floats:
        """Scale of each state (d,)."""

    @property
    @abstractmethod
    def forcing_period(self) -> float | None:
        """Period of what moves the rig from outside; None for an autonomous model."""

    @property
    @abstractmethod
    def loading_time(self) -> float:
        """How long the belt or the drive takes to load the spring from limit to limit."""

    @property
    @abstractmethod
    def section(self) -> tuple[Floats, float]:
        """Row (d,) and level of the section, row . state = level, crossed downwards where a cycle is cut."""

    @property
    @abstractmethod
    def height(self) -> Floats:
        """Row (d,) of what is greatest on the section."""

    @property
    def free(self) -> Floats:
        """Directions (d, f) of translation along which nothing changes: of coordinates that no spring holds."""
        return np.zeros((len(self.states), 0))

    @abstractmethod
    def initial(self, z: Floats) -> Floats:
        """Full initial state for `simulate`."""

    @abstractmethod
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

    @abstractmethod
    def full(self, run: Trajectory) -> Floats:
        """States (n, d) of a run, hidden ones included."""

    @abstractmethod
    def jacobian(self, run: Trajectory) -> Floats:
        """Sensitivities (n, d, p) of a run, hidden states included."""

    @abstractmethod
    def arc(self, z: Floats, span: float, *, parameter: str | None = None, contact: Contact = "auto") -> Arc:
        """Follow the motion for `span` from `z`, with the derivatives of where it arrives."""

    @abstractmethod
    def wiped_out(self, modes: NDArray[np.int8]) -> int:
        """How many directions a motion through these modes (k, contacts) forgets."""

    @abstractmethod
    def held(self, contact: Contact) -> Floats:
        """Rows (k, d) of the speeds of what sticks at the start."""

    @abstractmethod
    def contact(self, modes: NDArray[np.int8]) -> Contact:
        """How a run goes on from the modes (contacts,)."""

    @abstractmethod
    def strobed(self, contact: Contact) -> list[Contact]:
        """Return what the modes at the start may turn into along a branch, the cycle staying what it is."""

    @abstractmethod
    def in_steady_sliding(self, guess: Floats) -> Floats:
        """Return a guess (d,) with the speeds of steady sliding; an error where there is none."""

    @abstractmethod
    def linear(self, z: Floats) -> Linear:
        """Return the motion about a state near steady sliding."""

    @abstractmethod
    def scales(self, states: Floats) -> tuple[Floats, Floats]:
        """Units (d,) of a branch's states, and of the residual of its equations, from states (n, d) of a cycle."""

    # -- what follows --------------------------------------------------------------------------------------------

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: visible, then hidden."""
        return (*self.model.rig.state_names, *self.hidden)

    @cached_property
    def quotient(self) -> Floats:
        """Projection (d, d) that leaves out the translations along `free`."""
        return np.eye(len(self.states)) - self.free @ np.linalg.pinv(self.free)

    @property
    def moves(self) -> bool:
        """Can the motion last? A block on a belt that stands still comes to rest."""
        return True

    def apart(self, start: Floats, end: Floats) -> float:
        """How far states are from each other, in the model's own scale."""
        return float(np.abs(self.quotient @ (end - start) / self.size).max())

    def on_section(self, z: Floats) -> Floats:
        """Move a state onto the section."""
        row, level = self.section
        return z - row * (row @ z - level) / (row @ row)

    def seen(self, states: Floats) -> tuple[Floats, Floats]:
        """What is greatest on the section, and its rate, of states (n, d)."""
        row, level = self.section
        return states @ self.height, states @ row - level

    def moved(self, name: str, value: float) -> Self:
        """Return the flow with one parameter changed."""
        speeds: Mapping[str, BeltSpeed] = {"belt_speed": self.belt_speed, "drive_speed": self.drive_speed}
        if name in speeds:
            given = {**speeds, name: value}
            return type(self)(self.model, given["belt_speed"], given["drive_speed"], self.tolerance)
        model = self.model.replace({name: value})
        return type(self)(model, self.belt_speed, self.drive_speed, self.tolerance)

    def value_of(self, name: str) -> float:
        """Return the value of a parameter."""
        if name not in SPEEDS:
            return self.model.parameters[name]
        given = self.belt_speed if name == "belt_speed" else self.drive_speed
        if isinstance(given, Speed):
            raise InputError("is a formula of t; a parameter is a number", key=name, value=given.text)
        if given is None:
            raise InputError("missing; give the speed", key=name)
        return given

    def start(self) -> Floats:
        """State (d,) to start from where none is given."""
        return np.zeros(len(self.states))

    def completed(self, visible: Floats) -> Floats:
        """State (d,) of visible states alone."""
        return np.append(visible, np.zeros(len(self.hidden)))

    def state(self, given: ArrayLike | None, key: str) -> Floats:
        """Check a state (d,) given by the user under the name `key`; hidden states may be left out."""
        d, visible = len(self.states), len(self.model.rig.state_names)
        if given is None:
            return self.start()
        z = vector(key, given, f"{visible} numbers ({', '.join(self.states)})")
        if z.size not in (d, visible) or not np.isfinite(z).all():
            raise InputError(f"must be {visible} finite numbers ({', '.join(self.states)})", key=key)
        return z if z.size == d else self.completed(z)

    def idle(self, monodromy: Floats) -> Flags:
        """Which states (d,) have no influence: hidden ones that are not forgotten, yet nothing else depends on them.

        The time at rest is one where nothing sticks. The derivatives are exact, and so are these zeros.
        """
        own = np.diag(monodromy)
        alone = (monodromy - np.diag(own) == 0).all(axis=0) & (own != 0)
        return np.asarray(alone & (np.arange(len(own)) >= len(self.model.rig.state_names)))

    def basis(self, idle: Flags, *rows: Floats) -> Floats:
        """Columns (d, r) at right angles to translations, idle states and some rows (d,)."""
        d = len(idle)
        left_out = np.column_stack([np.eye(d)[:, idle], self.free, *rows])
        single = (left_out != 0).sum(axis=0) == 1
        if single.all():  # the states themselves
            return np.eye(d)[:, ~(left_out != 0).any(axis=1)]
        u, s, _ = np.linalg.svd(left_out)
        return np.asarray(u[:, int((s > 1e-12 * s[0]).sum()) :])

    def seeds(self) -> tuple[str, ...]:
        """Names that ask for the derivatives by the initial state."""
        return tuple(f"initial.{name}" for name in self.states)


def modes_through(run: Trajectory, end: float) -> NDArray[np.int8]:
    """Modes (k, contacts) of a run at its first sample and after each transition up to a time."""
    first = np.atleast_1d(run.mode[0])
    after = run.transitions.after[run.transitions.t <= end]
    return np.vstack([first[None], after.reshape(len(after), len(first))])
