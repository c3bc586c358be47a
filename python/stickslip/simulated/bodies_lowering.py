"""From a model of any rig to what the core of such rigs computes with: tapes, a row of numbers, rows of seeds.

The only place that knows that core's operations and the places of its numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.tree import Name, Number, Tree, names
from stickslip.declared.formula.value import value
from stickslip.declared.law_form import VARIABLES, BranchForm
from stickslip.declared.model import Model
from stickslip.declared.rigs.general import Equations, GeneralRig
from stickslip.declared.speeds import Speed
from stickslip.errors import unknown
from stickslip.simulated.general import General, rig_equations

Floats = NDArray[np.float64]
OPERATIONS: Mapping[str, int] = {name: i for i, name in enumerate(_core.OPERATIONS)}
NOMINAL = (
    1e-3  # relative step of a rig's number in a central difference: what it moves is at most a square of it
)


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
            if tree.name in VARIABLES:
                return OPERATIONS[tree.name], 0, 0
            return OPERATIONS["parameter"], self.numbers[tree.name], 0
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
        elif name in self.model.parameters and name not in self.model.friction.numbers:
            row[: self.layout["parameters"]] = self._rig_moves(name)
        else:
            raise unknown("parameter", name, [*self.model.parameters, *self.places, *initial])

    def _rig_moves(self, name: str) -> Floats:
        """Return what the matrices move by with a number of the rig; exact, for what moves with its square at most."""
        size = self.model.parameters[name]
        step = NOMINAL * (abs(size) or 1.0)
        ends = [_moved(self.model, name, size + one) for one in (-step, step)]
        low, high = (_matrices(one, self.own, self.layout) for one in ends)
        return (high - low) / (2 * step)

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
        hidden = iter(own.hidden)
        shares = dict(zip(own.state_names, own.order, strict=True))
        for contact, law in zip(own.equations.contacts, own.laws, strict=True):
            belt = float(own.belt(0.0)) if contact.against == "belt" else 0.0
            v = float(contact.direction @ z[n : 2 * n]) - belt
            dv = -1.0 if name == "belt_speed" and contact.against == "belt" else 0.0
            place = shares.get(name.removeprefix("initial."), -1) if name.startswith("initial.") else -1
            dv += float(contact.direction[place - n]) if place >= n else 0.0
            for one in law.states:
                if next(hidden) not in given:
                    of = {**law.numbers, "u": abs(v), "v": v}
                    slope = dv * np.sign(v) * _at(one.start, "u", of) + dv * _at(one.start, "v", of)
                    number = self._of_law(name, contact.law)
                    slope += 0.0 if number is None else _at(one.start, number, of)
                    row[at] += slope
                at += 1

    def _of_law(self, name: str, law: str) -> str | None:
        """Return what a contact's law calls a number of the model."""
        if not isinstance(self.model.friction, ContactLaws):
            return name if name in self.model.friction.numbers else None
        known = dict(self.model.friction.laws)
        owner, _, number = name.partition(".")
        return number if owner == (law or next(iter(known))) and owner in known else None


def _at(tree: Tree, by: str, of: Mapping[str, float]) -> float:
    return float(value(derivative(tree, by), of)) if by in names(tree) else 0.0


def lower_bodies(own: General, model: Model) -> LoweredBodies:
    """Translate what `general` made of a model."""
    parameters = _Parameters()
    eq = own.equations
    moving = [(key, one) for key, one, used in _speeds(own) if used]
    laws = []
    for contact, law in zip(eq.contacts, own.laws, strict=True):
        several = isinstance(model.friction, ContactLaws)
        prefix = f"{contact.law or dict(model.friction.laws).popitem()[0]}." if several else ""  # type: ignore[attr-defined]
        places = {name: parameters.named(prefix + name, size) for name, size in law.numbers.items()}
        states = {one.name: k for k, one in enumerate(law.states)}
        laws.append(tuple(_formulas(law.branch(s), _Tape(parameters, places, states)) for s in (-1, 1)))
    speeds = [_speed(one, key, parameters) for key, one in moving]
    keys = [key for key, _ in moving]
    rubs = [keys.index("belt_speed") if one.against == "belt" else -1 for one in eq.contacts]
    layout = _core.bodies_layout(
        n=len(eq.names),
        contacts=len(eq.contacts),
        speeds=len(speeds),
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
        "parameters": len(parameters.values),
    }
    return LoweredBodies(own, model, arguments, values, layout, parameters.places)


def _speeds(own: General) -> list[tuple[str, Speed, bool]]:
    return [("belt_speed", own.belt, own.equations.on_belt), ("drive_speed", own.drive, own.equations.driven)]


def _formulas(branch: BranchForm, tape: _Tape) -> _core.Formulas:
    rates = [tape.add(one) for one in branch.rates]
    force = tape.add(branch.force if branch.force is not None else branch.kinetic or Number(0.0))
    limit = -1 if branch.static is None else tape.add(branch.static)
    return _core.Formulas(nodes=tape.rows, force=force, limit=limit, rates=rates)


def _speed(speed: Speed, key: str, parameters: _Parameters) -> _core.PrescribedSpeed:
    pieces = []
    for one in speed.pieces:
        tape = _Tape(
            parameters, {key: parameters.named(key, speed.constant)} if speed.constant is not None else {}
        )
        force = tape.add(Name(key) if speed.constant is not None else one)
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
        "pull_x": pull_x,
        "pull_v": pull_v,
    }
    out = np.zeros(layout["parameters"])
    for name, group in groups.items():
        flat = np.asarray(group, dtype=np.float64).ravel()
        out[layout[name] : layout[name] + len(flat)] = flat
    return out


def _moved(model: Model, name: str, size: float) -> Equations:
    """Equations of a model with one number of its rig changed."""
    if isinstance(model.rig, GeneralRig):
        return model.rig.moved({name: size})
    rig = copy(model.rig)
    object.__setattr__(rig, name, size)  # a damping of 0 may be moved below it here
    return rig_equations(rig)[0]
