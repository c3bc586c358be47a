"""The rates of a rig of any kind in given modes, from the trees that the core's tapes are made of.

They are smooth there, so a complex step gives their derivatives to rounding.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.formula.tree import Tree
from stickslip.declared.formula.value import Value, value
from stickslip.declared.places import seen
from stickslip.simulated.general import General

Floats = NDArray[np.float64]
STEP = 1e-40  # of the complex step: there is no difference to be lost


@dataclass(frozen=True)
class Travel:
    """Time, and how far the belt and the drive have come."""

    t: float = 0.0
    belt: float = 0.0
    drive: float = 0.0


@dataclass(frozen=True, eq=False)
class Field:
    """M q'' + C q' + K q = force - D' T + drive; states are (q, v, hidden)."""

    own: General

    def sliding(self, z: Value, t: float) -> Value:
        """Speeds v (m,) of the contacts."""
        eq = self.own.equations
        n = len(eq.names)
        belt = float(self.own.belt(t)) if eq.on_belt else 0.0
        on_belt = np.array([one.against == "belt" for one in eq.contacts])
        return eq.directions @ z[n : 2 * n] - belt * on_belt

    def rate(self, z: Value, modes: Sequence[int], place: Travel) -> Value:
        """Return d z / d t (d,): a contact of mode 0 is held, one of another slips that way."""
        own, eq = self.own, self.own.equations
        n, t = len(eq.names), place.t
        rig = seen(z, n, t, place.belt, place.drive)
        hidden, v = iter(z[2 * n :]), self.sliding(z, t)
        force = eq.force - eq.C @ z[n : 2 * n] - eq.K @ z[:n]
        if eq.driven:
            force = force + eq.drive_stiffness * place.drive + eq.drive_damping * float(own.drive(t))
        rates = list[Value]()
        for j, law in enumerate(own.laws):
            s, of = modes[j], {**rig, **law.numbers, "u": modes[j] * v[j], "v": v[j], "dwell": 0.0}
            of |= {one.name: next(hidden) for one in law.states}
            branch = law.branch(s or -1)
            if branch.force is not None:
                force = force - eq.directions[j] * value(branch.force, of)
            elif s and branch.kinetic is not None:
                force = force - eq.directions[j] * s * value(branch.kinetic, of)
            rates += [value(one, of) for one in branch.rates]
        for push in own.effects.pushes:
            of = {**rig, **own.effects.numbers, **{one.name: next(hidden) for one in push.states}}
            force = force + push.direction * value(push.force, of)
            rates += [value(one.rate, of) for one in push.states]
        return np.array([*z[n : 2 * n], *self._held(np.linalg.solve(eq.M, force), modes, t), *rates])

    def _held(self, acceleration: Value, modes: Sequence[int], t: float) -> Value:
        """Add what holds the stuck contacts: D_s q'' = V'."""
        eq = self.own.equations
        stuck = [j for j, s in enumerate(modes) if s == 0]
        if not stuck:
            return acceleration
        D, reach = eq.directions[stuck], np.linalg.solve(eq.M, eq.directions[stuck].T)
        change = float(self.own.belt.at(t, self.own.belt.piece(t))[1]) if eq.on_belt else 0.0
        wanted = np.array([change * (eq.contacts[j].against == "belt") for j in stuck])
        return acceleration - reach @ np.linalg.solve(D @ reach, D @ acceleration - wanted)

    def jacobian(self, z: Floats, modes: Sequence[int], place: Travel) -> Floats:
        """Return d rate / d z (d, d)."""
        shifts = z.astype(np.complex128)[:, None] + 1j * STEP * np.eye(len(z))
        columns = [np.imag(self.rate(column, modes, place)) / STEP for column in shifts.T]
        return np.array(columns, dtype=np.float64).T

    def trees(self) -> dict[str, list[tuple[Tree, Mapping[str, float]]]]:
        """Every tree that moves the rig, and its numbers, by the name of what it belongs to."""
        own = self.own
        out: dict[str, list[tuple[Tree, Mapping[str, float]]]] = {}
        for contact, law in zip(own.equations.contacts, own.laws, strict=True):
            both = (*law.minus.trees(), *law.plus.trees())
            out.setdefault(contact.law or contact.name, []).extend((one, law.numbers) for one in both)
        pushed = [(one, own.effects.numbers) for push in own.effects.pushes for one in _of_push(push)]
        if pushed:
            out["effects"] = pushed
        return out


def _of_push(push: object) -> list[Tree]:
    return [push.force, *(one.rate for one in push.states)]  # type: ignore[attr-defined]
