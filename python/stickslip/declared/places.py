"""The places of a rig that effects may act on: what their formulas may read there, as trees.

Trees name a coordinate, its speed, and where a belt or a drive is, by `coordinate`, `velocity` and `distance`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.formula.dimension import Dimensions, dimensions
from stickslip.declared.formula.tree import Apply, Name, Number, Tree
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

    def beside(self, by: str, site: Site) -> Site:
        """A place from where another coordinate is read, too."""
        names_ = self.own.names
        if by not in names_:
            words = (
                f"no coordinate '{by}'; {did_you_mean(by, names_)}"
                if by
                else "lacks the coordinate that it couples"
            )
            raise InputError(words if by else f"{words} to: one of {', '.join(names_)}", key="by")
        i = names_.index(by)
        return replace(site, trees={**site.trees, "other": coordinate(i), "other_rate": velocity(i)})

    def _site(self, trees: Mapping[str, Tree], of: Mapping[str, Dimensions], needed: str) -> Site:
        units = {name: dimensions(unit) for name, unit in self.units.items()}
        return Site(
            {**self.states, "t": Name("t"), **trees},
            {**units, "t": dimensions("s"), **of},
            None if self.bare else dimensions(needed),
        )


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
