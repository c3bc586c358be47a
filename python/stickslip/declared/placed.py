"""An effect at its place on a rig: trees of what the rig has, checked for names, places and dimensions.

Trees name a coordinate, its speed, and where a belt or a drive is, by `coordinate`, `velocity` and `distance`; an
effect's numbers by "<effect>.<number>", its states by "<effect>.<state>".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.acts import Acts
from stickslip.declared.effect import AnyEffect, Effect, FormulaEffect
from stickslip.declared.formula.dimension import Dimensions, dimensions, measures, said
from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import Apply, Name, Number, Tree, names, substituted, switches
from stickslip.declared.formula.value import Value
from stickslip.declared.rig import DrivenSlider, Rig
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import ContactRow, Equations, GeneralRig
from stickslip.errors import InputError, did_you_mean

Floats = NDArray[np.float64]
SPEEDS = {"belt": "belt_speed", "drive": "drive_speed"}
NAMED_PLACES = {"block": 0, "angle_body": 1}  # of the named rigs: which coordinate
CHANNEL = " channel"


def coordinate(i: int) -> Name:
    """Return what names a coordinate in a tree."""
    return Name(f"coordinate {i}")


def velocity(i: int) -> Name:
    """Return what names the speed of a coordinate."""
    return Name(f"velocity {i}")


def distance(key: str) -> Name:
    """Return what names how far a belt ("belt_speed") or a drive ("drive_speed") has come."""
    return Name(f"distance {key}")


def prescribed(key: str) -> Name:
    """Return what names a prescribed speed in a tree: of a driven slider, the force of its drive."""
    return Name(f"prescribed {key}")


def seen(z: Value, n: int, t: Value, belt: Value, drive: Value) -> dict[str, Value]:
    """Return what trees read of a rig: of (q, v, ...), the time, and where the belt and the drive are."""
    of: dict[str, Value] = {coordinate(i).name: z[i] for i in range(n)}
    of |= {velocity(i).name: z[n + i] for i in range(n)}
    return of | {distance("belt_speed").name: belt, distance("drive_speed").name: drive, "t": t}


@dataclass(frozen=True)
class PlacedState:
    """A state of an effect: its full name, its rate and its start."""

    name: str
    rate: Tree
    start: Tree


@dataclass(frozen=True)
class Placed:
    """An effect at its place: one of the things below is there.

    Attributes
    ----------
    label
        What its numbers are called by.
    numbers
        By full name.
    direction, force
        A force on the coordinates, (n,), and its size.
    link
        The link that it acts in, where it does.
    rubs
        Without a force: a further contact along the direction, with the ground, whose law is dry friction of the one
        number; whether it turns.
    contact, acts
        Index of the contact whose law it changes; its formulas by what they are ("factor", "peak", "aging", "bristle").
    number
        Of the contact's law, where the factor is one of that number alone.
    speed, factor
        Of a prescribed speed, "belt_speed" or "drive_speed", and what it is multiplied by.
    channel, reading
        Of a reading.
    states
        Its own.
    """

    label: str
    numbers: Mapping[str, float]
    states: tuple[PlacedState, ...] = ()
    direction: Floats | None = None
    link: str = ""
    force: Tree | None = None
    rubs: bool | None = None
    contact: int | None = None
    acts: Mapping[str, Tree] | None = None
    number: str | None = None
    speed: str | None = None
    factor: Tree | None = None
    channel: str | None = None
    reading: Tree | None = None


@dataclass(frozen=True)
class Site:
    """What an effect's formulas may read at a place: trees, and what they measure (None: not checked)."""

    trees: Mapping[str, Tree]
    of: Mapping[str, Dimensions]
    needed: Dimensions | None
    turns: bool = False


class Places:
    """The places of a rig that effects may act on.

    Parameters
    ----------
    rig
        A `GeneralRig`, or a named one.
    own
        Its equations.
    order
        Places of its states among (q, v).
    """

    def __init__(self, rig: object, own: Equations, order: Sequence[int]) -> None:
        self.rig, self.own, self.n = rig, own, len(own.names)
        states = rig.state_names  # type: ignore[attr-defined]  # every rig has them
        self.states: dict[str, Tree] = {
            name: coordinate(k) if k < self.n else velocity(k - self.n)
            for name, k in zip(states, order, strict=True)
        }
        units = [*own.units, *("1" if one == "1" else f"{one}/s" for one in own.units)]
        self.units = {name: units[k] for name, k in zip(states, order, strict=True)}
        self.bare = isinstance(rig, Rig) or "1" in own.units  # (2.1) is nondimensional

    # -- by what it acts on ------------------------------------------------------------------------------------

    def force(self, where: str) -> tuple[Floats, Site]:
        """Direction of a force, and what it may read."""
        row, of_drive, rest, turns = self._row(where)
        moved: list[tuple[float, Tree, Tree]] = [
            (float(row[i]), coordinate(i), velocity(i)) for i in map(int, np.flatnonzero(row))
        ]
        x = _weighted([(by, place) for by, place, _ in moved])
        v = _weighted([(by, speed) for by, _, speed in moved])
        trees = {"deflection": x, "deflection_rate": v}
        if of_drive:  # a tape reads where the drive is, not how fast it moves
            x = Apply("add", (x, Apply("multiply", (Number(of_drive), distance("drive_speed")))))
            trees = {"deflection": x}
        if rest:
            trees["deflection"] = Apply("subtract", (x, Number(rest)))
        length = "rad" if turns else "m"
        of = {"deflection": dimensions(length), "deflection_rate": dimensions(f"{length}/s")}
        return row, replace(self._site(trees, of, "N m" if turns else "N"), turns=turns)

    def _row(self, where: str) -> tuple[Floats, float, float, bool]:
        names_ = self.own.names
        bodies = {**dict(zip(names_, range(self.n), strict=True)), **self._named()}
        links = (
            [f"link_{i + 1}" for i in range(len(self.rig.link))] if isinstance(self.rig, BodiesRig) else []
        )
        if not where and self.n == 1:
            where = names_[0]
        if where == "both" and isinstance(self.rig, Rig):
            return np.ones(self.n), 0.0, 0.0, False
        if where in bodies:
            i = bodies[where]
            return np.eye(self.n)[i], 0.0, 0.0, self.own.units[i] == "rad"
        if where in links:
            assert isinstance(self.rig, BodiesRig)
            i = links.index(where)
            row, of_drive = self.rig.deflection(i)
            first = int(np.flatnonzero(row)[0])
            return row, of_drive, float(self.rig.link[i].rest), self.own.units[first] == "rad"
        raise _no_place(where, "body or link" if links else "coordinate", [*bodies, *links])

    def _named(self) -> dict[str, int]:
        if isinstance(self.rig, GeneralRig):
            return {}
        # of a slider the damping comes from its contact
        of_contact = {"contact": 0} if isinstance(self.rig, DrivenSlider) else {}
        return of_contact | {k: i for k, i in NAMED_PLACES.items() if i < self.n}

    def contact(self, where: str) -> tuple[int, str | None, Site]:
        """Index of a contact, the number of its law ("bit.normal") or None, and what is read there."""
        contacts = self.own.contacts
        known = [one.name for one in contacts]
        # a contact's name may have a dot
        name = next(
            (one for one in known if where == one or where.startswith(f"{one}.")), where.partition(".")[0]
        )
        number = where.removeprefix(name).removeprefix(".")
        if len(contacts) == 1 and name in ("", "contact"):
            name = known[0]
        if name not in known:
            raise _no_place(where, "contact", [*known, *(place for place in SPEEDS if self._moves(place))])
        j = known.index(name)
        return j, number or None, self._at_contact(contacts[j])

    def _at_contact(self, one: ContactRow) -> Site:
        x = _weighted(
            [(float(one.direction[i]), coordinate(i)) for i in map(int, np.flatnonzero(one.direction))]
        )
        travel: Tree = distance("belt_speed") if one.against == "belt" else Number(0.0)
        length = dimensions("rad" if one.rotation else "m")
        trees = {"position": x, "travel": Apply("subtract", (travel, x)), "u": Name("u"), "v": Name("v")}
        trees |= {"dwell": Name("dwell"), "R": Name("R")}
        rate = length / dimensions("s")
        of = {"position": length, "travel": length, "u": rate, "v": rate}
        return self._site(trees, of, "")

    def _moves(self, place: str) -> bool:
        return self.own.on_belt if place == "belt" else self.own.driven

    def speed(self, where: str) -> tuple[str, Site]:
        """Name of a prescribed speed, and what is read there: t alone."""
        place = where or "belt"
        if place not in SPEEDS or not self._moves(place):
            raise _no_place(where, "prescribed speed", [one for one in SPEEDS if self._moves(one)])
        return SPEEDS[place], Site({"t": Name("t")}, {"t": dimensions("s")}, dimensions(""))

    def channel(self, where: str) -> tuple[str, Site]:
        """Name of a channel, and what its reading is made of."""
        name = where.removesuffix(CHANNEL) or (self.own.names[0] if self.n == 1 else "")
        if name not in self.states:
            raise _no_place(where, "channel", list(self.states))
        unit = self.units[name]
        return name, self._site({"reading": self.states[name]}, {"reading": dimensions(unit)}, unit)

    def _site(self, trees: Mapping[str, Tree], of: Mapping[str, Dimensions], needed: str) -> Site:
        units = {name: dimensions(unit) for name, unit in self.units.items()}
        return Site(
            {**self.states, "t": Name("t"), **trees},
            {**units, "t": dimensions("s"), **of},
            None if self.bare else dimensions(needed),
        )


def placed(effect: AnyEffect, places: Places) -> Placed:
    """Return an effect at its place.

    Raises
    ------
    InputError
        It acts on no such rig, there is no such place, a name is not known there, a formula measures something else.
    """
    try:
        return _placed(effect, places)
    except InputError as error:
        key = f"{effect.name}.{error.key}" if error.key else effect.name
        raise InputError(error.what, key=key, value=error.value) from None


def _placed(effect: AnyEffect, places: Places) -> Placed:
    if not isinstance(effect, (Effect, FormulaEffect)):
        raise InputError(
            "a curve acts on a named rig; a law 'tabulated' or a formula acts here", key="effects"
        )
    acts = effect.as_acts
    named = not isinstance(places.rig, GeneralRig)
    own = effect.where in places.own.names  # a body that is called as a place of the catalogue
    where = effect.where if named or own or isinstance(effect, FormulaEffect) or effect.placed else ""
    numbers = {f"{effect.label}.{name}": size for name, size in effect.parameters.items()}
    match acts.place:
        case None:
            if named:
                raise InputError("acts only at a constant belt speed and under a law that is no formula")
            raise InputError(f"does not act on a rig of bodies or matrices; {acts.refused}")
        case "force":
            direction, site = places.force(where)
            force, states = _formulas(effect, acts, {"force": acts.force}, site)
            link = where if where in [one.name for one in places.own.links] else ""
            if acts.sharp is not None and effect.parameters[acts.sharp[0]] == 0:
                dry = f"{effect.label}.{acts.sharp[1]}"
                return Placed(effect.label, {dry: numbers[dry]}, direction=direction, rubs=site.turns)
            return Placed(effect.label, numbers, states, direction, link, force["force"])
        case "reading":
            if effect.where.removesuffix(CHANNEL) in places.states:  # "x1 channel", where the rig has an x1
                where = effect.where
            channel, site = places.channel(where)
            reading, states = _formulas(effect, acts, {"reading": acts.reading}, site)
            return Placed(effect.label, numbers, states, channel=channel, reading=reading["reading"])
    if acts.of_belt or (acts.place == "factor" and where in SPEEDS):
        return _of_speed(effect, acts, where, numbers, places)
    j, number, site = places.contact(where)
    if number is not None and acts.factor is None:
        raise InputError(f"acts on the whole friction; give where = '{where.partition('.')[0]}'", key="where")
    texts = {key: getattr(acts, key) for key in ("factor", "peak", "aging", "bristle")}
    trees, states = _formulas(effect, acts, texts, site)
    return Placed(effect.label, numbers, states, contact=j, acts=trees, number=number)


def _of_speed(
    effect: Effect | FormulaEffect, acts: Acts, where: str, numbers: Mapping[str, float], places: Places
) -> Placed:
    key, site = places.speed(where)
    if acts.states:
        raise InputError("a factor of a prescribed speed has no states; it reads t", key="states")
    trees, _ = _formulas(effect, acts, {"factor": acts.factor}, site)
    if found := switches(trees["factor"]):
        words = (
            f"'{found[0].operation}' has a kink in time; give the speed itself in steps, with a formula each"
        )
        raise InputError(words, key="factor")
    return Placed(effect.label, numbers, speed=key, factor=trees["factor"])


def _formulas(
    effect: Effect | FormulaEffect, acts: Acts, texts: Mapping[str, str | None], site: Site
) -> tuple[dict[str, Tree], tuple[PlacedState, ...]]:
    """Trees of the formulas that are given, and of the states."""
    own: dict[str, Tree] = {
        name: Name(f"{effect.label}.{name}") for name in (*effect.parameters, *acts.states)
    }
    if clash := [name for name in own if name in site.trees and isinstance(effect, FormulaEffect)]:
        raise InputError("names a state of the rig; name it otherwise", key=clash[0])
    by = {**site.trees, **own}
    if effect.where and "deflection" in by and "deflection_rate" not in by and _reads_rate(texts):
        raise InputError(
            "a link to the drive has no deflection_rate; a formula may read the bodies' velocities"
        )

    def read(key: str, text: str) -> Tree:
        try:
            return substituted(parse(text, [*by]), by)
        except InputError as error:
            raise InputError(error.what, key=key, value=error.value) from None

    given = {key: text for key, text in texts.items() if text is not None}
    if isinstance(effect, FormulaEffect):
        _check_dimensions(effect, given, site)
    trees = {key: read(key, text) for key, text in given.items()}
    states = [
        PlacedState(
            f"{effect.label}.{name}", read(f"states.{name}.rate", rate), read(f"states.{name}.start", start)
        )
        for name, (rate, start) in acts.states.items()
    ]
    return trees, tuple(states)


def _reads_rate(texts: Mapping[str, str | None]) -> bool:
    return any(text is not None and "deflection_rate" in names(parse(text)) for text in texts.values())


def _check_dimensions(effect: FormulaEffect, given: Mapping[str, str], site: Site) -> None:
    """Refuse formulas that measure something else than they must, where a number has a unit."""
    if site.needed is None:
        if effect.units:
            raise InputError(
                "has a unit, but the rig's numbers are nondimensional; give it bare",
                key=next(iter(effect.units)),
            )
        return
    states = dict(effect.states)
    if not effect.units and all(one.unit == "1" for one in states.values()):
        return
    of = {**site.of, **{name: dimensions(effect.units.get(name, "")) for name in effect.parameters}}
    of |= {name: dimensions(one.unit) for name, one in states.items()}
    asked = [(key, text, site.needed) for key, text in given.items()]
    for name, one in states.items():
        asked += [
            (f"states.{name}.rate", one.rate, of[name] / dimensions("s")),
            (f"states.{name}.start", one.start, of[name]),
        ]
    for key, text, needed in asked:
        try:
            found = measures(parse(text, [*of]), of, effect.parameters)
        except InputError as error:
            raise InputError(error.what, key=key, value=error.value) from None
        if found is not None and found != needed:
            raise InputError(f"is {said(found)}; it must be {said(needed)}", key=key, value=text)


def _weighted(parts: Sequence[tuple[float, Tree]]) -> Tree:
    """Return the sum of trees, each by its weight."""
    terms: list[Tree] = [one if by == 1 else Apply("multiply", (Number(float(by)), one)) for by, one in parts]
    return reduce(lambda a, b: Apply("add", (a, b)), terms)


def _no_place(where: str, what: str, known: Sequence[str]) -> InputError:
    if not known:
        return InputError(f"the rig has no {what}", key="where", value=where or None)
    if not where:
        return InputError(f"lacks its place, a {what}: one of {', '.join(known)}", key="where")
    return InputError(f"no {what} '{where}'; {did_you_mean(where, known)}", key="where")
