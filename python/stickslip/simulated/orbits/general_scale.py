"""The scales of a rig of any kind: its natural time, and how far friction and what moves it take each state.

By energies, since coordinates may be lengths and angles: what the greatest friction stores in the spring at the first
contact, or the belt's speed in its inertia, is what every coordinate may have.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.bodies_model import law_of
from stickslip.declared.model import Model
from stickslip.errors import InputError
from stickslip.simulated.orbits.general_field import Field, Travel

Floats = NDArray[np.float64]
LOOKS = 64  # instants at which a speed that is a formula is looked at


@dataclass(frozen=True, eq=False)
class StateScale:
    """Scales of (q, v, hidden)."""

    field: Field
    model: Model
    carried: Floats
    free: Floats

    @cached_property
    def _inertia(self) -> Floats:
        """What each contact has to move (m,)."""
        eq = self.field.own.equations
        moved = np.linalg.solve(eq.M, eq.directions.T)
        return np.asarray(1 / np.sum(eq.directions * moved.T, axis=1))

    @cached_property
    def time(self) -> float:
        """1 / natural frequency, by Rayleigh's quotient of what a push at the first held contact moves."""
        eq = self.field.own.equations
        for direction in eq.directions:
            moved = np.linalg.solve(eq.M, direction - self.free @ (self.free.T @ direction))
            square = float(moved @ eq.K @ moved)
            if square > 0:
                return float(np.sqrt((moved @ eq.M @ moved) / square))
        fastest = float(np.abs(np.linalg.eigvals(np.linalg.solve(eq.M, eq.K))).max())
        return float(1 / np.sqrt(fastest)) if fastest > 0 else 1.0

    @cached_property
    def _speeds(self) -> Floats:
        """How fast each contact slides at most, the springs at rest (m,)."""
        own = self.field.own
        n, times = len(own.equations.names), np.linspace(0.0, 40 * self.time, LOOKS)
        if own.belt.constant is not None and own.drive.constant is not None:
            times = times[:1]
        drives = own.drive(times) if own.equations.driven else np.zeros(len(times))
        rows = [
            self.field.sliding(np.concatenate([np.zeros(n), self.carried * drive]), float(t))
            for t, drive in zip(times, drives, strict=True)
        ]
        return np.asarray(np.abs(rows).max(axis=0))

    @cached_property
    def energy(self) -> float:
        """What every coordinate may have."""
        forces = np.array([self._force(j) for j in range(len(self._speeds))])
        each = np.maximum((forces * self.time) ** 2, (self._inertia * self._speeds) ** 2) / self._inertia
        return float(each.max()) or 1.0

    def _force(self, j: int) -> float:
        """The greatest static friction of a contact; of a law without stick that of steady sliding."""
        own = self.field.own
        if j >= own.of_rig:  # dry friction that an effect adds
            return float(max(own.laws[j].numbers.values()))
        law = law_of(self.model.friction, own.equations.contacts[j])
        v = float(self._speeds[j])
        try:
            if own.laws[j].compliant and v > 0:
                sizes = [float(np.abs(law.magnitude(s * v))) for s in (-1, 1)]
            else:
                sizes = [abs(one) for one in law.static_limits]
        except InputError:  # its states settle nowhere
            return 0.0
        return max((one for one in sizes if np.isfinite(one)), default=0.0)

    @property
    def speed(self) -> float:
        """How fast the first contact slides at most, the springs at rest."""
        return float(self._speeds[0])

    @property
    def length(self) -> float:
        """What the first contact may move by."""
        return float(np.sqrt(self.energy / self._inertia[0]) * self.time)

    @cached_property
    def size(self) -> Floats:
        """Scales (d,): of a hidden state its start in steady sliding, or what the rates there take it to."""
        own = self.field.own
        eq, n = own.equations, len(own.equations.names)
        speeds = np.sqrt(self.energy / np.diag(eq.M))
        usual = float(np.sqrt(self.energy / self._inertia[0]))
        out = np.concatenate([speeds * self.time, speeds, np.full(len(own.hidden), usual)])
        if not own.hidden:
            return out
        wanted = np.where(self._speeds > 0, self._speeds, usual)
        v = np.linalg.pinv(eq.directions) @ (wanted - self.field.sliding(np.zeros(2 * n), 0.0))
        core = np.concatenate([np.zeros(n), v])
        z = own.start(core[list(own.order)], {}, 0.0)
        modes = np.where(self.field.sliding(z, 0.0) < 0, -1, 1).tolist()
        with np.errstate(all="ignore"):
            rates = self.field.rate(z, modes, Travel())[2 * n :]
            slopes = np.diag(self.field.jacobian(z, modes, Travel()))[2 * n :]
            reached = np.maximum(np.abs(z[2 * n :]), np.abs(rates / slopes))
        good = np.isfinite(reached) & (reached > 0)
        out[2 * n :][good] = reached[good]
        return out
