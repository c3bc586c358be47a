"""From a model of any rig to what the core of such rigs computes with: tapes, a row of numbers, rows of seeds.

The only place that knows that core's operations and the places of its numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.effect import Effect, FormulaEffect
from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.tree import Apply, Name, Number, Tree, names
from stickslip.declared.formula.value import value
from stickslip.declared.law_form import VARIABLES, BranchForm
from stickslip.declared.model import Model
from stickslip.declared.places import coordinate, distance, prescribed, velocity
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import Equations, GeneralRig
from stickslip.declared.rigs.named import equations_of
from stickslip.declared.rigs.parts import Contact
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, unknown
from stickslip.simulated.general import General
from stickslip.simulated.named_places import corrected, stiffened
from stickslip.simulated.placed_effects import NO_EFFECTS, Push

Floats = NDArray[np.float64]
OPERATIONS: Mapping[str, int] = {name: i for i, name in enumerate(_core.OPERATIONS)}
NOMINAL = (
    1e-3  # relative step of a rig's number in a central difference: what it moves is at most a square of it
)


MODERATE = 64  # the largest power that the core takes as whole


class _Parameters:
    """The numbers of formulas: by name, and constants by value."""

    def __init__(self) -> None:
        self.values: list[float] = []
        self.places: dict[str, int] = {}
        self.constants: dict[float, int] = {}

    def named(self, name: str, size: float) -> int:
        if name not in self.places:
            self.places[name] = len(self.values)
            self.values.append(size)
        return self.places[name]

    def constant(self, size: float) -> int:
        if size not in self.constants:
            self.constants[size] = len(self.values)
            self.values.append(size)
        return self.constants[size]


@dataclass
class _Tape:
    """Rows of a tape; a tree that occurs again is the row it was."""

    parameters: _Parameters
    numbers: Mapping[str, int]
    states: Mapping[str, int] = field(default_factory=dict)
    of_rig: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    rows: list[tuple[int, int, int]] = field(default_factory=list)
    known: dict[Tree, int] = field(default_factory=dict)

    def add(self, tree: Tree) -> int:
        """Return the row of a tree."""
        if tree not in self.known:
            row = self._row(tree)
            self.known[tree] = len(self.rows)
            self.rows.append(row)
        return self.known[tree]

    def _row(self, tree: Tree) -> tuple[int, int, int]:
        if isinstance(tree, Number):
            return OPERATIONS["parameter"], self.parameters.constant(tree.value), 0
        if isinstance(tree, Name):
            if tree.name in self.states:
                return OPERATIONS["state"], self.states[tree.name], 0
            if tree.name in self.of_rig:
                operation, place = self.of_rig[tree.name]
                return OPERATIONS[operation], place, 0
            if tree.name in VARIABLES:
                return OPERATIONS[tree.name], 0, 0
            return OPERATIONS["parameter"], self.numbers[tree.name], 0
        if (whole := _in_whole_powers(tree)) is not None:
            return self._row(whole)
        places = [self.add(one) for one in tree.operands]
        return OPERATIONS[tree.operation], places[0], places[-1] if len(places) > 1 else 0


@dataclass(frozen=True, eq=False)
class LoweredBodies:
    """A model as the core of general rigs takes it.

    Attributes
    ----------
    arguments
        Of `_core.simulate_bodies`, but for values, modes, times and tolerances.
    values : (size,)
        Every number; the start is put in by `started`.
    layout
        Where each group of numbers begins.
    """

    own: General
    model: Model
    arguments: Mapping[str, Any]
    values: Floats
    layout: Mapping[str, int]
    places: Mapping[str, int]  # of the numbers of laws and speeds

    def started(self, z: Floats) -> Floats:
        """Return the values with a start (q, v, states of the laws)."""
        out = self.values.copy()
        at = self.layout["initial"]
        out[at : at + len(z)] = z
        return out

    def seeds(self, asked: Iterable[str], z: Floats, given: frozenset[str]) -> Floats:
        """Return one row of weights a name, over all values.

        Parameters
        ----------
        asked
            Names as in `Model.parameters`, "belt_speed", "drive_speed", "initial.<state>".
        z
            The start.
        given
            States of the laws that were given; the others move with what they start as.

        Raises
        ------
        InputError
            A name is unknown; the nearest one is said.
        """
        chosen = list(asked)
        rows = np.zeros((len(chosen), len(self.values)))
        for row, name in zip(rows, chosen, strict=True):
            self._put(row, name)
            self._start_moves(row, name, z, given)
        return rows

    def _put(self, row: Floats, name: str) -> None:
        visible = {f"initial.{one}": k for one, k in zip(self.own.state_names, self.own.order, strict=True)}
        n = len(self.own.equations.names)
        hidden = {f"initial.{one}": 2 * n + k for k, one in enumerate(self.own.hidden)}
        initial = {**visible, **hidden}
        if name in initial:
            row[self.layout["initial"] + initial[name]] = 1.0
        elif name in self.places:
            row[self.layout["parameters"] + self.places[name]] = 1.0
        elif name.startswith("tabulated_"):
            raise InputError("no derivative by a curve is known here", key=name)
        elif name == "drive_delay.delay":
            raise InputError("no derivative by a delay is known; give a difference of two runs", key=name)
        elif name in self.model.parameters and name not in self.model.friction.numbers:
            self._refuse_lengths(name)
            row[: self.layout["parameters"]] = self._rig_moves(name)
        else:
            raise unknown("parameter", name, [*self.model.parameters, *self.places, *initial])

    def _rig_moves(self, name: str) -> Floats:
        """Return what the matrices move by with a number of the rig; exact, for what moves with its square at most."""
        size = self.model.parameters[name]
        step = NOMINAL * (abs(size) or 1.0)
        ends = [self.moved_equations(name, size + one) for one in (-step, step)]
        low, high = (_matrices(one, self.own, self.layout) for one in ends)
        return (high - low) / (2 * step)

    def moved_equations(self, name: str, size: float) -> Equations:
        """Return the equations with one number of the rig changed, and the contacts that effects add."""
        own = self.own
        moved = _moved_equations(self.model, name, size)
        return replace(moved, contacts=(*moved.contacts, *own.equations.contacts[own.of_rig :]))

    def moves(self, names: Iterable[str]) -> Floats:
        """Return what the values move by as numbers of the rig grow together, relative to what they are, (size,)."""
        row = np.zeros(len(self.values))
        for name in names:
            row[: self.layout["parameters"]] += self.model.parameters[name] * self._rig_moves(name)
        return row

    def _start_moves(self, row: Floats, name: str, z: Floats, given: frozenset[str]) -> None:
        """Add how the start of a law's state moves with a number, or with the sliding speed at the start."""
        own, n = self.own, len(self.own.equations.names)
        at = self.layout["initial"] + 2 * n
        hidden, seen = iter(own.hidden), own.seen(z, 0.0)
        shares = dict(zip(own.state_names, own.order, strict=True))
        for contact, law in zip(own.equations.contacts, own.laws, strict=True):
            belt = float(own.belt(0.0)) if contact.against == "belt" else 0.0
            v = float(contact.direction @ z[n : 2 * n]) - belt
            dv = -self._share_of_belt() if name == "belt_speed" and contact.against == "belt" else 0.0
            place = shares.get(name.removeprefix("initial."), -1) if name.startswith("initial.") else -1
            dv += float(contact.direction[place - n]) if place >= n else 0.0
            for one in law.states:
                if next(hidden) not in given:
                    of = {**seen, **law.numbers, "u": abs(v), "v": v}
                    slope = dv * np.sign(v) * _at(one.start, "u", of) + dv * _at(one.start, "v", of)
                    number = self._of_law(name, contact.law)
                    row[at] += slope + _at(one.start, self._seen_as(name) if number is None else number, of)
                at += 1
        for push in own.effects.pushes:
            for state in push.states:
                if state.name not in given:
                    row[at] += _at(state.start, self._seen_as(name), {**seen, **own.effects.numbers})
                at += 1

    def _share_of_belt(self) -> float:
        """Return what effects multiply the belt's speed by at the start."""
        factor = self.own.effects.factor("belt_speed")
        return 1.0 if factor is None else float(value(factor, {**self.own.effects.numbers, "t": 0.0}))

    def _seen_as(self, name: str) -> str:
        """Return what a tree of an effect calls a coordinate or a speed at the start; a number as it is."""
        n = len(self.own.equations.names)
        for one, k in zip(self.own.state_names, self.own.order, strict=True):
            if name == f"initial.{one}":
                return coordinate(k).name if k < n else velocity(k - n).name
        if name == self.own.drive_name:
            return prescribed("drive_speed").name
        return name

    def _refuse_lengths(self, name: str) -> None:
        """Refuse a lever arm, a gear or a rest by which an effect would move too: only the matrices are followed."""
        owner, _, key = name.rpartition(".")
        rig = self.model.rig
        of_contact = (
            isinstance(rig.parts.get(owner), Contact)
            if isinstance(rig, BodiesRig)
            else name.startswith("contact_")  # an entry of the rows "contact" of a rig by its matrices
        )
        places = {one.where for one in self.model.effects if isinstance(one, (Effect, FormulaEffect))}
        at_contact = any(one.contact is not None for one in self.own.effects.all)
        if (of_contact and at_contact) or (key in ("gear", "rest") and owner in places):
            raise InputError("an effect acts there; no derivative by this number is known", key=name)

    def _of_law(self, name: str, law: str) -> str | None:
        """Return what a contact's law calls a number of the model."""
        if not isinstance(self.model.friction, ContactLaws):
            return name if name in self.model.friction.numbers else None
        known = dict(self.model.friction.laws)
        owner, _, number = name.partition(".")
        return number if owner == (law or next(iter(known))) and owner in known else None


def _in_whole_powers(tree: Apply) -> Tree | None:
    """A large whole power as powers of powers: the core has a series of a base that is 0 of moderate ones alone."""
    if tree.operation != "power" or not isinstance(tree.operands[1], Number):
        return None
    base, p = tree.operands[0], tree.operands[1].value
    if not (MODERATE < p < 1e6 and p == int(p)):
        return None
    much, rest = divmod(int(p), MODERATE)
    out: Tree = Apply("power", (Apply("power", (base, Number(float(MODERATE)))), Number(float(much))))
    if much == 1:
        out = Apply("power", (base, Number(float(MODERATE))))
    if rest:
        more = base if rest == 1 else Apply("power", (base, Number(float(rest))))
        out = Apply("multiply", (out, more))
    return out


def _at(tree: Tree, by: str, of: Mapping[str, float]) -> float:
    return float(value(derivative(tree, by), of)) if by in names(tree) else 0.0


def lower_bodies(own: General, model: Model) -> LoweredBodies:
    """Translate what `general` made of a model."""
    parameters = _Parameters()
    eq = own.equations
    moving = [(key, one) for key, one, used in _speeds(own) if used]
    of_rig = _of_rig(len(eq.names), [key for key, _ in moving])
    added = {name: parameters.named(name, size) for name, size in own.effects.numbers.items()}
    laws = []
    for contact, law in zip(eq.contacts, own.laws, strict=True):
        several = isinstance(model.friction, ContactLaws)
        prefix = f"{contact.law or dict(model.friction.laws).popitem()[0]}." if several else ""  # type: ignore[attr-defined]
        places = {
            name: added[name] if name in added else parameters.named(prefix + name, size)
            for name, size in law.numbers.items()
        }
        states = {one.name: k for k, one in enumerate(law.states)}
        laws.append(
            tuple(_formulas(law.branch(s), _Tape(parameters, places, states, of_rig)) for s in (-1, 1))
        )
    pushes = [_push(one, parameters, added, of_rig) for one in own.effects.pushes]
    speeds = [_speed(one, own.called(key), parameters, added, own.effects.factor(key)) for key, one in moving]
    keys = [key for key, _ in moving]
    rubs = [keys.index("belt_speed") if one.against == "belt" else -1 for one in eq.contacts]
    layout = _core.bodies_layout(
        n=len(eq.names),
        contacts=len(eq.contacts),
        speeds=len(speeds),
        pushes=len(pushes),
        parameters=len(parameters.values),
        states=len(own.hidden),
    )
    values = np.zeros(layout["size"])
    values[: layout["parameters"]] = _matrices(eq, own, layout)
    values[layout["parameters"] : layout["initial"]] = parameters.values
    arguments = {
        "n": len(eq.names),
        "laws": laws,
        "contact_speed": np.array(rubs, dtype=np.intc),
        "speeds": speeds,
        "pushes": pushes,
        "parameters": len(parameters.values),
    }
    return LoweredBodies(own, model, arguments, values, layout, parameters.places)


def _speeds(own: General) -> list[tuple[str, Speed, bool]]:
    """Return the prescribed speeds as they were given: what effects make of them is a formula of the tape."""
    given = (own.belt, own.drive) if own.effects is NO_EFFECTS else own.effects.prescribed
    return list(zip(own.effects.keys, given, (own.equations.on_belt, own.equations.driven), strict=True))


def _of_rig(n: int, keys: list[str]) -> dict[str, tuple[str, int]]:
    """Return what names of trees read of the rig: operations and places."""
    out = {coordinate(i).name: ("coordinate", i) for i in range(n)}
    out |= {velocity(i).name: ("velocity", i) for i in range(n)}
    out |= {distance(key).name: ("distance", i) for i, key in enumerate(keys)}
    return out | {prescribed(key).name: ("prescribed", i) for i, key in enumerate(keys)}


def _push(
    one: Push, parameters: _Parameters, added: Mapping[str, int], of_rig: Mapping[str, tuple[str, int]]
) -> _core.Formulas:
    states = {each.name: k for k, each in enumerate(one.states)}
    tape = _Tape(parameters, added, states, of_rig)
    rates = [tape.add(each.rate) for each in one.states]
    force = tape.add(one.force)
    return _core.Formulas(nodes=tape.rows, force=force, rates=rates)


def _formulas(branch: BranchForm, tape: _Tape) -> _core.Formulas:
    rates = [tape.add(one) for one in branch.rates]
    force = tape.add(branch.force if branch.force is not None else branch.kinetic or Number(0.0))
    limit = -1 if branch.static is None else tape.add(branch.static)
    return _core.Formulas(nodes=tape.rows, force=force, limit=limit, rates=rates)


def _speed(
    speed: Speed, key: str, parameters: _Parameters, added: Mapping[str, int], factor: Tree | None
) -> _core.PrescribedSpeed:
    pieces = []
    for one in speed.pieces:
        numbers = {key: parameters.named(key, speed.constant)} if speed.constant is not None else {}
        tape = _Tape(parameters, {**numbers, **added})
        tree: Tree = Name(key) if speed.constant is not None else one
        force = tape.add(tree if factor is None else Apply("multiply", (tree, factor)))
        pieces.append(_core.Formulas(nodes=tape.rows, force=force))
    return _core.PrescribedSpeed(begins=list(speed.begins), pieces=pieces)


def _matrices(eq: Equations, own: General, layout: Mapping[str, int]) -> Floats:
    """Every number before the parameters, row by row."""
    rows = [key for key, _, used in _speeds(own) if used]
    zero = np.zeros(len(eq.names))
    pull_x = [eq.drive_stiffness if key == "drive_speed" else zero for key in rows]
    pull_v = [eq.drive_damping if key == "drive_speed" else zero for key in rows]
    groups = {
        "M": eq.M,
        "C": eq.C,
        "K": eq.K,
        "force": eq.force,
        "D": eq.directions,
        "G": [one.direction for one in own.effects.pushes],
        "pull_x": pull_x,
        "pull_v": pull_v,
    }
    out = np.zeros(layout["parameters"])
    for name, group in groups.items():
        flat = np.asarray(group, dtype=np.float64).ravel()
        out[layout[name] : layout[name] + len(flat)] = flat
    return out


def _moved_equations(model: Model, name: str, size: float) -> Equations:
    if isinstance(model.rig, GeneralRig):
        return model.rig.moved({name: size})
    if name not in model.rig.__dataclass_fields__:  # an effect that corrects a number of the rig
        other = model.replace({name: size})
        return stiffened(other, *equations_of(corrected(other)))[0]
    rig = copy(corrected(model))
    share = getattr(rig, name) / model.parameters[name] if model.parameters[name] else 1.0
    object.__setattr__(rig, name, size * share)  # a damping of 0 may be moved below it here
    return stiffened(model, *equations_of(rig))[0]
