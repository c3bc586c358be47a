"""A periodic motion: its state on the section, its multipliers, its transitions."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stickslip.arguments import whole_number
from stickslip.declared.model import Model
from stickslip.objects import Drawn, one_line
from stickslip.simulated.orbits.flow import BeltSpeed, Complexes, Contact, Floats, Flow, sticks_at
from stickslip.simulated.orbits.flow_of import flow_of
from stickslip.simulated.trajectory import Trajectory, Transitions


@dataclass(frozen=True, eq=False, repr=False)
class LimitCycle(Drawn):
    """A periodic motion, stable or not.

    Attributes
    ----------
    period
        Its period.
    state : (d,)
        State on the section: x2 = 0 going down (x1 greatest), or at t = 0 of what moves the rig. After a period a
        drive has carried the coordinates along, and what no spring holds has moved on.
    states
        Names of the states; hidden ones of effects after the visible ones.
    transitions
        Those of one period, t counted from the section.
    kinks : (j,)
        Times at which a branch saturates or an effect switches.
    monodromy : (d, d)
        d state one period later / d state.
    multipliers : (d - 1,) complex
        Floquet multipliers of the return map, greatest modulus first; (d,) for a rig moved from outside. The
        multiplier 1 along an autonomous cycle is not among them. A stick phase makes one exactly 0, contacts that stick
        at the same time one each. A hidden state without influence on this cycle, as the time at rest where nothing
        sticks, has none; nor has a translation of what no spring holds.
    residual
        Greatest difference between the state and that one period later, in the model's own scale (see `limit_cycle`).
    iterations
        Newton steps taken.
    turns
        Crossings of the section, or periods of what moves the rig, in one period.
    belt_speed, drive_speed, model
        What it is a cycle of.
    contact
        Mode at the section; of several contacts, of each.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> cycle = ss.limit_cycle(model, belt_speed=0.1)
    >>> print(abs(cycle.multipliers).round(4))  # the last is the direction that a stick wipes out
    [0.9382 0.9382 0.    ]
    >>> print(cycle.transitions)
        3.602517  slip - -> stick
        9.611569  stick  -> slip -
    """

    period: float
    state: Floats
    states: tuple[str, ...]
    transitions: Transitions
    kinks: Floats
    monodromy: Floats
    multipliers: Complexes
    residual: float
    iterations: int
    turns: int
    belt_speed: BeltSpeed
    model: Model = field(repr=False)
    contact: Contact = "auto"
    drive_speed: BeltSpeed = None

    def __repr__(self) -> str:
        state = ", ".join(f"{name} = {x:.6g}" for name, x in zip(self.states, self.state, strict=True))
        sort = "stable" if self.stable else "neutral" if self.neutral else "unstable"
        sort += ", sticks" if self.sticks else ""
        return one_line(f"<LimitCycle: period {self.period:.9g}, {sort}; {state}>")

    @property
    def stable(self) -> bool:
        """Does the motion return to it after a small disturbance?"""
        return bool(np.all(np.abs(self.multipliers) < 1)) and not self.neutral

    @property
    def neutral(self) -> bool:
        """Does a small disturbance neither grow nor die out, to first order?

        The greatest multiplier has modulus 1, as near as it is known: a double one is off by the root of the error.
        """
        greatest = float(np.abs(self.multipliers).max(initial=0.0))
        return abs(greatest - 1) <= float(np.sqrt(Flow.tolerance))

    @property
    def sticks(self) -> bool:
        """Has it a stick phase?"""
        return sticks_at(self.contact) or bool(np.any(self.transitions.after == 0))

    @property
    def initial(self) -> Floats:
        """State on the section as `simulate` takes it.

        Of a named rig with all hidden states, also those that the model has not, as 0.
        """
        return self.flow.initial(self.state)

    @property
    def flow(self) -> Flow:
        """The motion of its model."""
        return flow_of(self.model, self.belt_speed, self.drive_speed)

    def trajectory(self, samples: int = 400) -> Trajectory:
        """Simulate one period at `samples` even times, both ends included."""
        samples = whole_number("samples", samples, least=2, most=10**7)
        return self.flow.run(self.state, even(self.period, samples), contact=self.contact)


def even(span: float, samples: int) -> Floats:
    """Return even times from 0 to `span`, both included (samples,)."""
    return np.linspace(0.0, span, samples, dtype=np.float64)
