"""What the effects of a model make of its laws and prescribed speeds, and the forces that they add."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import AnyEffect
from stickslip.declared.formula.tree import Apply, Name, Number, Tree, names, substituted
from stickslip.declared.law_form import BranchForm, LawForm, StateForm
from stickslip.declared.placed import LIMIT, Placed, PlacedState, placed
from stickslip.declared.places import Places
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, did_you_mean

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Push:
    """A force on a direction (n,), of a link if it names one, and states; without a direction these alone."""

    direction: Floats
    force: Tree
    states: tuple[PlacedState, ...]
    link: str = ""


@dataclass(frozen=True, eq=False)
class Effects:
    """The effects of a model at their places.

    Attributes
    ----------
    all
        Each at its place.
    numbers
        Of all effects, by "<effect>.<number>".
    pushes
        Forces, and the states of readings.
    readings
        Formula of each channel that an effect changes.
    prescribed
        Speeds of the belt and the drive as they were given.
    """

    keys: ClassVar[tuple[str, str]] = ("belt_speed", "drive_speed")

    all: tuple[Placed, ...]
    numbers: Mapping[str, float]
    pushes: tuple[Push, ...]
    readings: Mapping[str, Tree]
    prescribed: tuple[Speed, Speed] = (Speed.of(0.0), Speed.of(0.0))

    def changed(self, j: int, law: LawForm, declared: LawForm | None = None) -> LawForm:
        """Return the law of contact j with what effects make of it, in their order; T_s is that of the one declared."""
        plain = declared or law
        for one in self.all:
            if one.contact == j:
                law = _changed(law, one, plain)
        return law

    def factor(self, key: str) -> Tree | None:
        """Return what a prescribed speed is multiplied by."""
        out: Tree | None = None
        for one in self.all:
            if one.speed == key and one.factor is not None:
                out = one.factor if out is None else Apply("multiply", (out, one.factor))
        return out

    def moved(self, key: str, speed: Speed) -> Speed:
        """Return a prescribed speed as effects make it, their numbers put in."""
        factor = self.factor(key)
        if factor is None:
            return speed
        by: dict[str, Tree] = {name: Number(size) for name, size in self.numbers.items()}
        fixed = substituted(factor, by)
        return replace(speed, pieces=tuple(Apply("multiply", (one, fixed)) for one in speed.pieces))


NO_EFFECTS = Effects((), {}, (), {})


def effects_of(effects: Sequence[AnyEffect], places: Places) -> Effects:
    """Put effects to their places; several of one channel act one after the other.

    Raises
    ------
    InputError
        As `placed`.
    """
    return of_placed([placed(one, places) for one in effects], places.states)


def of_placed(found: Sequence[Placed], states: Mapping[str, Tree]) -> Effects:
    """Return what effects at their places make; `states` are trees of the rig's own."""
    numbers = {name: size for one in found for name, size in one.numbers.items()}
    pushes, readings = list[Push](), dict[str, Tree]()
    zero = np.zeros(len(states) // 2)
    for one in found:
        if one.direction is not None and one.force is not None:
            pushes.append(Push(one.direction, one.force, one.states, one.link))
        elif one.channel is not None and one.reading is not None:
            true = states[one.channel]
            seen = _after(true, readings.get(one.channel, true))
            readings[one.channel] = seen(one.reading)
            if one.states:
                kept = [replace(each, rate=seen(each.rate), start=seen(each.start)) for each in one.states]
                pushes.append(Push(zero, Number(0.0), tuple(kept)))
    return Effects(tuple(found), numbers, tuple(pushes), readings)


def _after(true: Tree, before: Tree) -> Callable[[Tree], Tree]:
    """What an effect reads of a channel is what the ones before it make of the true value."""
    assert isinstance(true, Name)
    return lambda tree: substituted(tree, {true.name: before})


def _changed(law: LawForm, one: Placed, declared: LawForm) -> LawForm:
    acts = dict(one.acts or {})
    if any(LIMIT in names(tree) for tree in acts.values()):
        limit = _limit(declared, one.label)
        acts = {key: substituted(tree, {LIMIT: limit}) for key, tree in acts.items()}
    extra = {**law.numbers, **one.numbers}
    states = tuple(StateForm(each.name, each.start) for each in one.states)
    branches = [_branch(law.branch(s), law, one, acts) for s in (-1, 1)]
    if "bristle" in acts:
        if law.compliant:
            raise InputError("yields already; its law has no stick", key=f"{one.label}.where")
        extra |= {name: size for name, size in law.numbers.items() if name not in extra}
    return LawForm(branches[0], branches[1], extra, (*law.states, *states))


def _limit(law: LawForm, label: str) -> Tree:
    """The static limit for v < 0 of a contact that has just come to rest; of a law without stick its friction there."""
    limit = law.minus.static or law.minus.kinetic
    if limit is None:
        raise InputError(
            "the law has no static limit that friction could be a share of", key=f"{label}.where"
        )
    at_rest: dict[str, Tree] = {"u": Number(0.0), "v": Number(0.0), "dwell": Number(0.0)}
    return substituted(limit, at_rest)


def _branch(branch: BranchForm, law: LawForm, one: Placed, acts: Mapping[str, Tree]) -> BranchForm:
    at_rest: dict[str, Tree] = {"u": Number(0.0), "v": Number(0.0)}
    kinetic, static, force = branch.kinetic, branch.static, branch.force
    if (bristle := acts.get("bristle")) is not None:
        by: dict[str, Tree] = {"R": kinetic or Number(0.0)}
        rates = tuple(substituted(each.rate, by) for each in one.states)
        return BranchForm(force=substituted(bristle, by), rates=(*branch.rates, *rates))
    if (peak := acts.get("peak")) is not None:
        kinetic, static, force = _sum(kinetic, peak), _sum(static, substituted(peak, at_rest)), force
        if force is not None:  # friction against the motion
            force = Apply("add", (force, Apply("multiply", (Apply("sign", (Name("v"),)), peak))))
    if (aging := acts.get("aging")) is not None:
        if static is None:
            raise InputError("the law has no stick whose limit could grow", key=f"{one.label}.where")
        static = _sum(static, aging)
    if (factor := acts.get("factor")) is not None:
        if one.number is not None:
            kinetic, static, force = (
                _scaled(tree, one.number, law, factor) for tree in (kinetic, static, force)
            )
        else:
            kinetic, force = _product(kinetic, factor), _product(force, factor)
            static = _product(static, substituted(factor, at_rest))
    rates = tuple(each.rate for each in one.states)
    return BranchForm(kinetic, static, force, (*branch.rates, *rates))


def _scaled(tree: Tree | None, number: str, law: LawForm, factor: Tree) -> Tree | None:
    """Multiply one number of a law, and its twin of the other direction."""
    if number not in law.numbers:
        raise InputError(
            f"the law has no number '{number}'; {did_you_mean(number, law.numbers)}", key="where"
        )
    if tree is None:
        return None
    both = [name for name in (number, f"{number}_plus") if name in law.numbers]
    return substituted(tree, {name: Apply("multiply", (Name(name), factor)) for name in both})


def _sum(a: Tree | None, b: Tree) -> Tree | None:
    return None if a is None else Apply("add", (a, b))


def _product(a: Tree | None, b: Tree) -> Tree | None:
    return None if a is None else Apply("multiply", (a, b))
