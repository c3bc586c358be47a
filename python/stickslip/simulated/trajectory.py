"""What `simulate` returns: a trajectory, its transitions, how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, did_you_mean
from stickslip.objects import Drawn, Sampled, one_line
from stickslip.simulated.named_readings import acted_on

Floats = NDArray[np.float64]
Modes = NDArray[np.int8]
CONTACTS = {"auto": 2, "stick": 0, "slip-": -1, "slip+": 1}  # modes to start in, as the core has them


class Status(Enum):
    """How a run ended; the value is the sentence for the user.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> run = ss.simulate(model, belt_speed=0.1, t_end=5)
    >>> run.status is ss.Status.finished
    True
    >>> print(run.status)
    reached the end time
    """

    finished = "reached the end time"
    chatter = (
        "stopped: transitions accumulate without time passing (chatter); the law or start is ill-posed there"
    )
    not_finite = "stopped: the state is no longer finite; an effect or law grows without bound"
    step_too_small = "stopped: the step fell below the resolution of time; the solution has a singularity"
    too_many_transitions = "stopped: too many transitions (in Python max_transitions allows more)"
    too_many_steps = (
        "stopped: too many steps; the run is long, or the equations too stiff (in Python: max_steps)"
    )
    interrupted = "stopped by the user"

    def __str__(self) -> str:
        return self.value

    @property
    def ok(self) -> bool:
        """Did the run reach its end time?"""
        return self is Status.finished


MODE_NAMES = {0: "stick", -1: "slip -", 1: "slip +"}


@dataclass(frozen=True, eq=False, repr=False)
class Transitions(Drawn):
    """Changes of the contact mode, in time order; printed, one a line.

    Attributes
    ----------
    t : (k,)
        Times.
    state : (k, d)
        States at them.
    before, after : (k,) int8
        Modes in {-1, 0, 1}: the sign of v_w, 0 for stick. Of a rig of bodies or matrices (k, m), of every contact.
    sensitivity : (k, p)
        d time / d parameter.
    state_sensitivity : (k, d, p)
        d state / d parameter, at the (moving) times.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)  # kg, N/m
    >>> model = ss.Model(rig, friction=ss.CoulombFriction(static=2.0, kinetic=1.2))  # N
    >>> found = ss.simulate(model, belt_speed=0.01, t_end=1).transitions
    >>> print(found)
        0.004179  slip - -> stick
        0.402086  stick  -> slip -
        0.513773  slip - -> stick
        0.833773  stick  -> slip -
        0.945460  slip - -> stick
    >>> print(f"breakaway at {found.t[found.before == 0][0]:.4f} s")
    breakaway at 0.4021 s
    """

    t: Floats
    state: Floats
    before: Modes
    after: Modes
    sensitivity: Floats
    state_sensitivity: Floats

    def __len__(self) -> int:
        return len(self.t)

    def __str__(self) -> str:
        if self.before.ndim == 2:
            rows_of_all = zip(self.t, self.before, self.after, strict=True)
            return "\n".join(f"{t:12.6f}  {_modes(a)} -> {_modes(b)}" for t, a, b in rows_of_all)
        rows = zip(self.t, self.before, self.after, strict=True)
        return "\n".join(f"{t:12.6f}  {MODE_NAMES[a]:<6} -> {MODE_NAMES[b]}" for t, a, b in rows)

    def __repr__(self) -> str:
        span = f", t = {self.t[0]:.6g} to {self.t[-1]:.6g}" if len(self) else ""
        return one_line(f"<Transitions: {len(self)}{span}>")


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Sampled):
    """What `simulate` returns; `run.x1` is the column x1 of `state`, and so for every state and hidden state.

    Attributes
    ----------
    t : (n,)
        Times, in the rig's unit: `t_eval`, or the ends of the integrator's own steps.
    state : (n, d)
        States in the order of `rig.state_names`.
    mode : (n,) int8
        The mode in {-1, 0, 1} that holds from that time on. Of a rig of bodies or matrices (n, m), of every contact.
    hidden : mapping of str to (n,)
        Hidden states of effects: memory w, bristle z, belt b, lagged reading m, dwell; or of laws.
    transitions : Transitions
        Changes of the contact mode.
    kinks : (j,)
        Times at which a branch saturates or an effect switches, the mode staying.
    sensitivity : (n, d, p)
        d state / d parameter at fixed time, parameters in the order asked for.
    hidden_sensitivity : mapping of str to (n, p)
        The same of hidden states.
    status : Status
        How it ended.
    steps : int
        Number of integration steps.
    sensitivity_names, state_names
        What the columns of `sensitivity` and `state` are.
    hidden_names
        Hidden states that an effect or a law of the model has; of the others nothing hangs.
    contact_names
        Contacts of a rig of bodies or matrices, the columns of `mode`; empty for a named rig.
    readings : mapping of str to (n,)
        What its sensor reads: x1, and y1 where there is one, of a named rig; of a rig of bodies or matrices each
        channel that an effect acts on.
    travelled : mapping of str to (n,)
        How far the belt ("belt_speed") and the drive ("drive_speed") of a rig of bodies or matrices have come.
    travelled_sensitivity : mapping of str to (n, p)
        The same, differentiated.
    sensed : mapping of str to (n,)
        Of a rig of bodies or matrices, by channel: accelerations `a_NAME`, forces in links `F_link_1`, friction at
        contacts `T_NAME`. At a jump, the value after it.
    sensed_sensitivity : mapping of str to (n, p)
        The derivatives of these.
    model, belt_speed
        What was simulated.
    rested : (m,)
        For how long each contact has stuck at the last sample, of what is simulated as a rig of bodies or matrices;
        empty for a named rig, of which `hidden` has it as dwell.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)  # kg, N/m
    >>> model = ss.Model(rig, friction=ss.CoulombFriction(static=2.0, kinetic=1.2))  # N
    >>> run = ss.simulate(model, belt_speed=0.01, t_end=1)
    >>> print(f"{1e3 * run.x1.max():.3f} mm; {run.status.value}")
    4.000 mm; reached the end time
    >>> frame = run.to_dataframe()
    >>> [*frame.columns]
    ['t', 'x1', 'x2', 'mode']
    """

    t: Floats
    state: Floats
    mode: Modes
    hidden: dict[str, Floats]
    transitions: Transitions
    kinks: Floats
    sensitivity: Floats
    hidden_sensitivity: dict[str, Floats]
    status: Status
    steps: int
    sensitivity_names: tuple[str, ...]
    state_names: tuple[str, ...]
    hidden_names: tuple[str, ...]
    contact_names: tuple[str, ...] = ()
    readings: dict[str, Floats] = field(default_factory=dict)
    travelled: dict[str, Floats] = field(default_factory=dict)
    travelled_sensitivity: dict[str, Floats] = field(default_factory=dict)
    sensed: dict[str, Floats] = field(default_factory=dict, repr=False)
    sensed_sensitivity: dict[str, Floats] = field(default_factory=dict, repr=False)
    model: Model | None = None
    belt_speed: float | Speed | None = None
    rested: Floats = field(default_factory=lambda: np.zeros(0))

    def __getattr__(self, name: str) -> Floats:
        """A state, a mode or a hidden state by its name, (n,)."""
        own = self.__dict__
        if not name.startswith("_") and "state_names" in own:  # it has none while it is unpickled
            if name in self.state_names:
                return self.state[:, self.state_names.index(name)]
            if name in self.hidden_names:
                return self.hidden[name]
            if name in self.modes:
                return np.asarray(self.modes[name])
            if name in own.get("sensed", ()):  # not there in what an older version pickled
                return np.asarray(own["sensed"][name])
        names = [*own.get("state_names", ()), *own.get("hidden_names", ())]
        said = f"; its states are {', '.join(names)}" if names else ""
        raise AttributeError(f"a Trajectory has no '{name}'{said}", name=name, obj=self)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.state_names, *self.hidden_names, *self.modes, *self.sensed]

    @property
    def acceleration(self) -> Floats:
        """Accelerations of the coordinates of a rig of bodies or matrices, (n, coordinates); at a jump, after it.

        Raises
        ------
        InputError
            A named rig: its accelerations are not kept.
        """
        names = [name.removeprefix("v_") for name in self.state_names[len(self.state_names) // 2 :]]
        return np.column_stack([self._sensed(f"a_{name}", "acceleration") for name in names])

    def contact_force(self, name: str = "") -> Floats:
        """Return friction at a contact of a rig of bodies or matrices, (n,): T, positive against a positive slip speed.

        In stick it is what holds the contact; at a jump the value after it. On a body that turns it is a torque, but
        for a contact with a lever arm.

        Parameters
        ----------
        name
            Of the contact; the only one if absent.

        Raises
        ------
        InputError
            No such contact, or a named rig.
        """
        one = name or (self.contact_names[0] if len(self.contact_names) == 1 else "")
        return self._sensed(f"T_{one}", "contact_force")

    def link_force(self, name: str) -> Floats:
        """Return the force in a link of a rig of bodies, (n,): stiffness times deflection and damping times its rate.

        Effects that act in the link are in it. It is positive where it pulls the first end back.

        Parameters
        ----------
        name
            "link_1" for the first.

        Raises
        ------
        InputError
            No such link, or a rig without links.
        """
        return self._sensed(f"F_{name}", "link_force")

    def _sensed(self, channel: str, asked: str) -> Floats:
        if channel in self.sensed:
            return self.sensed[channel]
        if not self.sensed:
            raise InputError("is kept of a rig of bodies or matrices; of a named rig states are", key=asked)
        known = [name for name in self.sensed if name[:2] == channel[:2]]
        if not known:
            raise InputError("a rig by its matrices has no links", key=asked)
        hint = did_you_mean(channel[2:], [name[2:] for name in known])
        raise InputError(f"no such place; {hint}", key=asked, value=channel[2:])

    @property
    def modes(self) -> dict[str, Modes]:
        """Modes by the names of their columns: "mode" of a named rig, "mode_<contact>" of others."""
        if not self.contact_names:
            return {"mode": self.mode}
        return {f"mode_{name}": self.mode[:, i] for i, name in enumerate(self.contact_names)}

    @property
    def read_otherwise(self) -> dict[str, Floats]:
        """The readings that effects make other than the state of that name, (n,) each."""
        if self.model is None:
            return {}
        names = acted_on(self.model)
        return {name: one for name, one in self.readings.items() if self.contact_names or name in names}

    def __repr__(self) -> str:
        n, span = len(self.t), f", t = {self.t[0]:.6g} to {self.t[-1]:.6g}" if len(self.t) else ""
        kept = f", {len(self.sensitivity_names)} sensitivities" if self.sensitivity_names else ""
        return one_line(
            f"<Trajectory: {n} samples of {self.state.shape[1]} states{span}; {len(self.transitions)} transitions"
            f"{kept}; {self.status}>"
        )


def _modes(modes: Modes) -> str:
    return " | ".join(f"{MODE_NAMES[int(one)]:<6}" for one in modes)
