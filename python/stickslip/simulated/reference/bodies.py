"""Rigs of any number of coordinates and contacts in plain Python: M q'' + C q' + K q = force - D' T + drive.

Between switchings every contact keeps its mode and every abs, sign, min and max its side, so the field is analytic.
In stick the forces of all stuck contacts follow from one small linear system, D_s M^-1 D_s' T_s = D_s M^-1 F - V'. A
stuck contact lets go where T leaves [-L_minus, L_plus]. With its kinetic force put in the others are asked again:
whichever is beyond its own limit then lets go too, the largest excess first, equal ones together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.declared.formula.tree import Apply, Tree, switches
from stickslip.declared.formula.value import Value, side_of, surface, value
from stickslip.declared.model import Model
from stickslip.declared.places import seen
from stickslip.simulated.general import General, general
from stickslip.simulated.reference.equations import Guard
from stickslip.simulated.reference.integrate import OdeStep, RunStatus, advance, leg

Floats = NDArray[np.float64]
Key = tuple[str, int]  # what ends: "rest", "slip-", "slip+" or "piece", and of which contact or piece

REST = 1e-12  # |v| below this is rest
EQUAL = 1e-9  # excesses that differ by less, relatively, are equal
PILE_UP = 50  # switchings at one instant


@dataclass(frozen=True)
class Modes:
    """What is frozen between switchings.

    Attributes
    ----------
    modes : sign of v, 0 for stick, by contact.
    since : time of the last arrival in stick, by contact.
    pieces : side of every abs, sign, min and max, by place among `Bodies.pieces`.
    belt, drive : pieces of the prescribed speeds.
    """

    modes: tuple[int, ...]
    since: tuple[float, ...]
    pieces: tuple[int, ...] = ()
    belt: int = 0
    drive: int = 0

    @property
    def contact(self) -> tuple[int, ...]:
        """The modes."""
        return self.modes


@dataclass(frozen=True)
class Change:
    """A contact that changed its mode."""

    t: float
    z: Floats
    contact: int
    before: int
    after: int


class Bodies:
    """The field and the switching functions of a rig; z is (q, v, states of the laws, displacement of the drive)."""

    def __init__(self, own: General) -> None:
        eq = own.equations
        self.own, self.eq, self.n, self.m = own, eq, len(eq.names), len(eq.contacts)
        self.inverse = np.linalg.inv(eq.M)
        self.D = eq.directions
        self.d = 2 * self.n + len(own.hidden)
        self.pushes, self.in_laws = own.effects.pushes, sum(len(law.states) for law in own.laws)
        # trees with sides: those of either branch of every contact, in stick too
        self.pieces: list[tuple[int, int, Apply]] = []
        for j, law in enumerate(own.laws):
            for s in (-1, 1):
                for tree in law.branch(s).trees():
                    self.pieces += [(j, s, one) for one in switches(tree) if (j, s, one) not in self.pieces]
        for e, push in enumerate(self.pushes):  # numbered behind the contacts
            trees = (push.force, *(one.rate for one in push.states))
            self.pieces += [(self.m + e, 1, one) for tree in trees for one in switches(tree)]
        self.pieces = list(dict.fromkeys(self.pieces))

    # -- the field, modes frozen -------------------------------------------------------------------------------

    def belt(self, t: Value, j: int, side: Modes) -> tuple[Value, Value]:
        """Speed and acceleration of what contact j rubs on."""
        if self.eq.contacts[j].against == "ground":
            return 0.0, 0.0
        return self.own.belt.at(t, side.belt)

    def sliding(self, t: Value, z: Value, j: int, side: Modes) -> Value:
        """v of contact j."""
        return self.D[j] @ z[self.n : 2 * self.n] - self.belt(t, j, side)[0]

    def reads(self, t: Value, z: Value, j: int, side: Modes, s: int) -> dict[str, Value]:
        """Return what the formulas of contact j read on the branch s; in stick u and v are 0."""
        rig = self._rig(t, z)
        if j >= self.m:
            at = 2 * self.n + self.in_laws + sum(len(one.states) for one in self.pushes[: j - self.m])
            own = {one.name: z[at + k] for k, one in enumerate(self.pushes[j - self.m].states)}
            return {**rig, **self.own.effects.numbers, **own}
        law = self.own.laws[j]
        v = self.sliding(t, z, j, side) if side.modes[j] else 0.0 * z[0]
        of: dict[str, Value] = {**rig, **law.numbers, "t": t, "v": v, "u": s * v, "dwell": t - side.since[j]}
        at = 2 * self.n + sum(len(one.states) for one in self.own.laws[:j])
        return of | {one.name: z[at + k] for k, one in enumerate(law.states)}

    def asked(self, tree: Tree, t: Value, z: Value, j: int, side: Modes, s: int) -> Value:
        """Value of a tree of contact j on its branch s, sides frozen."""
        return value(tree, self.reads(t, z, j, side, s), self._sides(j, s, side))

    def _rig(self, t: Value, z: Value) -> dict[str, Value]:
        belt = self.own.belt.constant  # of another speed the place is not kept
        return seen(z, self.n, t, np.nan if belt is None else belt * t, z[-1] if self.eq.driven else 0.0)

    def _sides(self, j: int, s: int, side: Modes) -> dict[Apply, int]:
        known = zip(self.pieces, side.pieces, strict=True)
        return {one: frozen for (k, branch, one), frozen in known if (k, branch) == (j, s)}

    def free(self, t: Value, z: Value, side: Modes) -> Value:
        """Force on the coordinates without friction."""
        eq, n = self.eq, self.n
        force = eq.force - eq.C @ z[n : 2 * n] - eq.K @ z[:n]
        if eq.driven:
            force = (
                force + eq.drive_stiffness * z[-1] + eq.drive_damping * self.own.drive.at(t, side.drive)[0]
            )
        for e, push in enumerate(self.pushes):
            force = force + push.direction * self.asked(push.force, t, z, self.m + e, side, 1)
        return force

    def friction(self, t: Value, z: Value, side: Modes) -> list[Value]:
        """T of every contact; in stick what keeps it there."""
        T: list[Value] = [0.0] * self.m
        force = self.free(t, z, side)
        for j, s in enumerate(side.modes):
            branch = self.own.laws[j].branch(s)
            if branch.force is not None:
                T[j] = self.asked(branch.force, t, z, j, side, s)
            elif s and branch.kinetic is not None:
                T[j] = s * self.asked(branch.kinetic, t, z, j, side, s)
            force = force - self.D[j] * T[j]
        stuck = [j for j, s in enumerate(side.modes) if s == 0]
        if stuck:
            D = self.D[stuck]
            right = D @ (self.inverse @ force) - np.array([self.belt(t, j, side)[1] for j in stuck])
            for j, size in zip(stuck, np.linalg.solve(D @ self.inverse @ D.T, right), strict=True):
                T[j] = size
        return T

    def field(self, t: Value, z: Value, side: Modes) -> Value:
        """dz/dt with every mode frozen."""
        n, T = self.n, self.friction(t, z, side)
        force = self.free(t, z, side) - self.D.T @ np.array(T)
        rates = []
        for j, branch in enumerate(s or -1 for s in side.modes):
            rates += [self.asked(one, t, z, j, side, branch) for one in self.own.laws[j].branch(branch).rates]
        for e, push in enumerate(self.pushes):
            rates += [self.asked(one.rate, t, z, self.m + e, side, 1) for one in push.states]
        drive = [self.own.drive.at(t, side.drive)[0]] if self.eq.driven else []
        return np.array([*z[n : 2 * n], *(self.inverse @ force), *rates, *drive])

    # -- the switching functions, and what follows a switching -------------------------------------------------

    def guards(self, side: Modes) -> dict[Key, Guard]:
        """Return what can end the modes: functions of t and z that are negative while they last."""
        out: dict[Key, Guard] = {}
        for j, s in enumerate(side.modes):
            if s:
                out["rest", j] = lambda t, z, j=j, s=s: -s * self.sliding(t, z, j, side)  # type: ignore[misc]
            else:
                out["slip-", j] = lambda t, z, j=j: (
                    -self.friction(t, z, side)[j] - self.limit(-1, t, z, j, side)
                )  # type: ignore[misc]
                out["slip+", j] = lambda t, z, j=j: (
                    self.friction(t, z, side)[j] - self.limit(1, t, z, j, side)
                )  # type: ignore[misc]
        for k, (j, s, one) in enumerate(self.pieces):
            if j >= self.m or s == side.modes[j] or (side.modes[j] == 0 and s == -1):
                out["piece", k] = self._surface(side, k, j, s, one)
        return {name: self._over(guard) for name, guard in out.items()}

    def _surface(self, side: Modes, k: int, j: int, s: int, one: Apply) -> Guard:
        sides = self._sides(j, s, side)
        return lambda t, z: -side.pieces[k] * surface(one, self.reads(t, z, j, side, s), sides)

    def _over(self, guard: Guard) -> Guard:
        """Let a switching function look at many instants at once, one after the other."""

        def look(t: Value, z: Value) -> Value:
            if np.ndim(t) == 0:
                return guard(t, z)
            return np.array([guard(one, z[:, i]) for i, one in enumerate(t)])

        return look

    def rate(self, guard: Guard, t: Value, z: Value, side: Modes) -> Value:
        """Rate of a switching function along the flow, by a complex step."""
        if np.ndim(t):
            return np.array([self.rate(guard, one, z[:, i], side) for i, one in enumerate(t)])
        h = 1e-30
        return np.imag(guard(t + 1j * h, z + 1j * h * self.field(t, z, side))) / h

    def limit(self, direction: int, t: Value, z: Value, j: int, side: Modes) -> Value:
        """Static limit of contact j against slip with the sign `direction`; infinite for a mode frozen in slip."""
        static = self.own.laws[j].branch(direction).static
        assert static is not None  # a compliant law never sticks
        return self.asked(static, t, z, j, side, direction)

    def switch(self, name: Key, t: float, z: Value, side: Modes) -> tuple[Value, Modes]:
        """State and modes after a switching."""
        what, k = name
        if what == "piece":
            pieces = list(side.pieces)
            pieces[k] = -pieces[k]
            return z, replace(side, pieces=tuple(pieces))
        z = self._at_rest(t, z, k, side)
        if what == "rest":
            if self.own.laws[k].compliant:
                return z, self._with(side, t, {k: -side.modes[k]})
            return z, self.settle(t, z, self._with(side, t, {k: 0}))
        return z, self.settle(t, z, self._with(side, t, {k: 1 if what == "slip+" else -1}))

    def _at_rest(self, t: float, z: Value, j: int, side: Modes) -> Value:
        """Take the rounding of a landing off: v of contact j is 0."""
        z = z.copy()
        d = self.D[j]
        z[self.n : 2 * self.n] -= d * self.sliding(t, z, j, side) / (d @ d)
        return z

    def _with(self, side: Modes, t: float, changed: Mapping[int, int]) -> Modes:
        modes = tuple(changed.get(j, s) for j, s in enumerate(side.modes))
        since = tuple(t if j in changed else one for j, one in enumerate(side.since))
        return replace(side, modes=modes, since=since)

    def settle(self, t: float, z: Value, side: Modes) -> Modes:
        """Let go what is beyond its limit: the largest excess first, equal ones together, and ask again."""
        for _ in range(self.m + 1):
            T = self.friction(t, z, side)
            beyond: dict[int, tuple[float, int]] = {}
            for j, s in enumerate(side.modes):
                if s:
                    continue
                for direction in (-1, 1):
                    size = float(self.limit(direction, t, z, j, side))
                    excess = direction * float(T[j]) - size
                    if excess > EQUAL * REST + 1e-13 * max(size, abs(float(T[j]))):
                        beyond[j] = (excess / max(size, 1e-300), direction)
            if not beyond:
                break
            most = max(excess for excess, _ in beyond.values())
            side = self._with(side, t, {j: s for j, (e, s) in beyond.items() if e >= most * (1 - EQUAL)})
        return self._sided(t, z, side)

    def _sided(self, t: float, z: Value, side: Modes) -> Modes:
        """Set the sides of every abs, sign, min and max by the state."""
        pieces: list[int] = []
        for j, s, one in self.pieces:
            known = {
                node: pieces[i]
                for i, (k, b, node) in enumerate(self.pieces[: len(pieces)])
                if (k, b) == (j, s)
            }
            pieces.append(side_of(one, self.reads(t, z, j, side, s), known))
        return replace(side, pieces=tuple(pieces))

    def start(self, t: float, z: Value, side: Modes | None = None) -> tuple[Value, Modes]:
        """State and modes at a start, or where a prescribed speed begins another piece: then sticks that hold last."""
        belt, drive = self.own.belt.piece(t), self.own.drive.piece(t)
        old = side or Modes((1,) * self.m, (t,) * self.m)
        side = replace(old, modes=(1,) * self.m, pieces=(1,) * len(self.pieces), belt=belt, drive=drive)
        modes, since = [], []
        for j in range(self.m):
            v = float(self.sliding(t, z, j, side))
            still = abs(v) <= REST * max(1.0, float(abs(self.belt(t, j, side)[0])))
            if still:
                z = self._at_rest(t, z, j, side)
            modes.append(0 if still else int(np.sign(v)))
            since.append(old.since[j] if still and old.modes[j] == 0 else t)
        side = replace(side, modes=tuple(modes), since=tuple(since))
        for j, law in enumerate(self.own.laws):  # a compliant one goes the way it is pushed
            if law.compliant and side.modes[j] == 0:
                ahead = self._sided(t, z, self._with(side, t, {j: 1}))
                push = self.D[j] @ self.field(t, z, ahead)[self.n : 2 * self.n] - self.belt(t, j, side)[1]
                side = self._with(side, t, {j: 1 if push >= 0 else -1})
        return z, self.settle(t, z, self._sided(t, z, side))


@dataclass(frozen=True)
class BodiesRun:
    """A run of a general rig.

    Attributes
    ----------
    t, state, hidden, mode : (n,), (n, d), (n, h), (n, m) arrays
        Times, states in the order of the rig's `state_names`, states of the laws, modes of the contacts.
    changes : list of Change
        Every contact that changed its mode.
    status : RunStatus
    """

    t: Floats
    state: Floats
    hidden: Floats
    mode: NDArray[np.int64]
    changes: list[Change]
    status: RunStatus
    steps: list[OdeStep] = field(repr=False)


def simulate(
    model: Model,
    *,
    initial: Sequence[float],
    t_end: float,
    belt_speed: object = None,
    drive_speed: object = None,
    hidden: Mapping[str, float] | None = None,
    t_eval: ArrayLike | None = None,
    tol: float = 1e-12,
    max_step: float = 0.1,
    max_transitions: int = 100_000,
) -> BodiesRun:
    """Integrate a model of any rig from t = 0 with every switching located.

    Parameters
    ----------
    model, initial, t_end, belt_speed, drive_speed, hidden
        As for `stickslip.simulate`.
    t_eval : (n,) array, optional
        Times of the output; the integrator's own steps otherwise.
    tol, max_step, max_transitions
        As for `stickslip.reference.simulate`.
    """
    own = general(model, belt_speed, drive_speed)
    system = Bodies(own)
    z = own.start(np.asarray(initial, float), dict(hidden or {}), 0.0)
    z = np.append(z, 0.0) if own.equations.driven else z
    t, (z, side) = 0.0, system.start(0.0, z)
    steps, changes, recent, message = list[OdeStep](), list[Change](), list[float](), ""
    breaks = sorted({b for one in (own.belt, own.drive) for b in one.begins[1:] if 0 < b < t_end} | {t_end})
    while t < t_end and not message:
        before, modes = len(steps), side.modes
        found = _next(system, side, t, z, [b for b in breaks if b > t], tol, max_step, steps)
        if isinstance(found, str):
            message = found
            break
        t, z, side = found
        pairs = enumerate(zip(modes, side.modes, strict=True))
        changes += [Change(t, z[: system.d], j, a, b) for j, (a, b) in pairs if a != b]
        recent = [*recent, t] if len(steps) == before else [t]
        if len(recent) > PILE_UP:
            message = f"switchings pile up at t = {t!r}"
        elif len(changes) >= max_transitions:
            message = f"gave up at t = {t!r} after {max_transitions} switchings"
    return _collect(system, [*steps, OdeStep(t, z, t, side, lambda _: z)], changes, message, t_eval)


def _next(
    system: Bodies,
    side: Modes,
    t: float,
    z: Floats,
    breaks: list[float],
    tol: float,
    max_step: float,
    steps: list[OdeStep],
) -> tuple[float, Floats, Modes] | str:
    """Integrate to the next switching, or to the first of the breaks; what follows it, or why it failed."""
    hit: Any = leg(system, side, t, z, breaks[0], tol, max_step, steps)
    if isinstance(hit, str):
        return hit
    if hit is None:
        t, z = breaks[0], steps[-1].dense(breaks[0])
        return (t, *system.start(t, z, side)) if len(breaks) > 1 else (t, z, side)
    name, t, z = hit
    return (t, *system.switch(name, t, z, side))


def _collect(
    system: Bodies, steps: list[OdeStep], changes: list[Change], message: str, t_eval: ArrayLike | None
) -> BodiesRun:
    begins = np.array([one.t for one in steps])
    times = begins if t_eval is None else np.asarray(t_eval, float)
    rows = []
    for x in times:
        step = steps[max(0, int(np.searchsorted(begins, x, side="right")) - 1)]
        rows.append((advance(system, step.side, step.t, step.z, float(x)), step.side.contact))
    z = np.array([one for one, _ in rows])
    mode = np.array([modes for _, modes in rows], np.int64).reshape(len(times), system.m)
    visible = z[:, list(system.own.order)]
    status = RunStatus(not message, message or "reached t_end")
    return BodiesRun(times, visible, z[:, 2 * system.n : system.d], mode, changes, status, steps)
