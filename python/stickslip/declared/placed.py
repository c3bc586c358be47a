"""An effect at its place on a rig: trees of what the rig has, checked for names, places and dimensions.

Trees name an effect's numbers by "<effect>.<number>", its states by "<effect>.<state>"; all else as `places` does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.acts import Acts
from stickslip.declared.effect import AnyEffect, Effect, FormulaEffect
from stickslip.declared.formula.dimension import dimensions, measures, said
from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import Name, Tree, names, substituted, switches
from stickslip.declared.places import CHANNEL, SPEEDS, Places, Site
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError

Floats = NDArray[np.float64]
LIMIT = "T_s"  # what trees call the static limit of a contact's law for v < 0


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
            site = _coupled(effect, acts, places, site)
            reading, states = _formulas(effect, acts, {"reading": acts.reading}, site)
            return Placed(effect.label, numbers, states, channel=channel, reading=reading["reading"])
    if acts.of_belt or (acts.place == "factor" and where in SPEEDS):
        return _of_speed(effect, acts, where, numbers, places)
    j, number, site = places.contact(where)
    if number is not None and acts.factor is None:
        raise InputError(f"acts on the whole friction; give where = '{where.partition('.')[0]}'", key="where")
    site = _coupled(effect, acts, places, site)
    texts = {key: getattr(acts, key) for key in ("factor", "peak", "aging", "bristle")}
    trees, states = _formulas(effect, acts, texts, site)
    return Placed(effect.label, numbers, states, contact=j, acts=trees, number=number)


def _coupled(effect: Effect | FormulaEffect, acts: Acts, places: Places, site: Site) -> Site:
    """What an effect of the catalogue reads beside its place."""
    if isinstance(effect, FormulaEffect) or not acts.couples:
        return site
    named = not isinstance(places.rig, GeneralRig)  # whose one other coordinate is the angle body's
    site = places.beside(places.own.names[-1] if named else effect.by, site)
    return replace(site, trees={**site.trees, LIMIT: Name(LIMIT)})


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
