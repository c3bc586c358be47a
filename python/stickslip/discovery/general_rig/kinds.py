"""Effects of the catalogue at every place of a rig of bodies or matrices that has what they act on, in SI.

The catalogue's bounds, priors and starts are for numbers like those of (2.1): lengths in which the largest deflection
is about 0.3, forces in which friction is about 5, times in 1/omega. What is 1 in such numbers is taken for each place
from the readings: how far, how fast and with what force things move there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.bodies_model import law_of
from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.effect import AnyEffect, FormulaEffect, effect
from stickslip.declared.effect_kind import EffectKind, ParameterInfo
from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import names
from stickslip.declared.model import Model
from stickslip.declared.places import CHANNEL
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import ContactRow, GeneralRig
from stickslip.discovery.laboratory.rival_kind import RivalKind, rival
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.scaled import ALPHA, STATIC

Floats = NDArray[np.float64]
DEFLECTION = STATIC / ALPHA  # the largest one in numbers like those of (2.1)
LARGEST = 0.995  # quantile that counts as the largest


@dataclass(frozen=True)
class Units:
    """What is 1 at a place, as `Dimension.size` takes it."""

    length: float
    omega: float
    k2: float


def largest(x: Floats) -> float:
    """Return the size of what is as good as the largest; never 0."""
    return max(float(np.quantile(np.abs(x), LARGEST)), 1e-300)


class Sizes:
    """How far, how fast and with what force things move at the places of a rig, over all runs."""

    def __init__(self, model: Model, data: Sequence[BodiesData]) -> None:
        assert isinstance(model.rig, GeneralRig)
        self.model, self.data, self.rig, self.own = model, data, model.rig, model.rig.equations
        self.omega = 2 * math.pi / data[0].periods[0]

    def by(self, deflection: float, force: float) -> Units:
        """What is 1 where things move so far, with such a force."""
        length, unit = deflection / DEFLECTION, force / STATIC
        return Units(length, self.omega, unit / length)

    def driven(self, run: BodiesData) -> Floats:
        """Where the drive is, (n,)."""
        if not self.own.driven:
            return np.zeros(len(run.t))
        return np.asarray(run.drawn + run.drive.way(run.t))

    def link(self, i: int) -> Units:
        """Of a link, by its deflection and the force of its spring."""
        x = self.deflection(i)
        assert isinstance(self.rig, BodiesRig)
        return self.by(x, abs(float(self.rig.link[i].stiffness)) * x or self.friction())

    def deflection(self, i: int) -> float:
        """Return the largest deflection of a link."""
        assert isinstance(self.rig, BodiesRig)
        row, of_drive = self.rig.deflection(i)
        rest = float(self.rig.link[i].rest)
        return max(largest(run.q @ row + of_drive * self.driven(run) - rest) for run in self.data)

    def coordinate(self, i: int) -> Units:
        """Of a coordinate, by its speed and the force of all springs on it; without any, that of friction."""
        own, force = self.own, 0.0
        if not own.K[i].any():
            return self.by(self.speed(i) / self.omega, self.friction())
        for run in self.data:
            pulled = own.drive_stiffness[i] * self.driven(run) + own.force[i]
            force = max(force, largest(run.q @ own.K[i] - pulled))
        return self.by(self.speed(i) / self.omega, force)

    def speed(self, i: int) -> float:
        """Return the largest speed of a coordinate about its usual one."""
        return max(largest(run.v[:, i] - np.median(run.v[:, i])) for run in self.data)

    def friction(self) -> float:
        """Return the largest static friction of all contacts, as declared."""
        return max((self.static(one) for one in self.own.contacts), default=1.0)

    def static(self, one: ContactRow) -> float:
        """Return the static friction of a contact, as declared: what its law has at rest."""
        return max(float(np.max(law_of(self.model.friction, one).static_limits)), 1e-300)

    def sticks(self, one: ContactRow) -> bool:
        """Return whether the law of a contact has a static limit."""
        return not law_of(self.model.friction, one).form().compliant

    def contact(self, one: ContactRow) -> Units:
        """Of a contact, by its fastest slip and its static friction."""
        fast = max(largest(slip(run, one)) for run in self.data)
        return self.by(fast / self.omega, self.static(one))

    def channel(self, name: str) -> Units:
        """Of what a channel reads."""
        states = self.rig.state_names
        place, n = states.index(name), len(self.own.names)
        moves = self.speed(place % n)
        return self.by(moves / self.omega if place < n else moves, self.friction())


def slip(run: BodiesData, one: ContactRow) -> Floats:
    """Return the slip speed of a contact as the readings show it, (n,)."""
    return one.slip(run.v, run.belt(run.t))


def placed_kinds(model: Model, data: Sequence[BodiesData], *, one_way: bool) -> list[EffectKind]:
    """
    Return every effect of the catalogue at every place that has what it acts on.

    Parameters
    ----------
    model, data : the declared model, and its runs
    one_way : whether every contact slips one way only, so that a constant load is a change of friction
    """
    sizes, acts = Sizes(model, data), []
    out: list[EffectKind] = []
    for kind in CATALOGUE.values():
        if kind.anywhere.place is None or kind.anywhere.bristle is not None or kind.anywhere in acts:
            continue
        if one_way and kind.both_ways:
            continue
        acts.append(kind.anywhere)
        if kind.anywhere.couples:
            out += _coupled(kind, sizes)
            continue
        out += [scaled(kind, where, units) for where, units in _places(kind, sizes)]
    return [one for one in out if has_room(model, one)]


def has_room(model: Model, kind: EffectKind, others: Sequence[AnyEffect] = ()) -> bool:
    """
    Return whether an effect that is a further contact may rub at its place: no contact does what it would.

    Parameters
    ----------
    model : the declared model
    kind : at its place
    others : effects beside it
    """
    if kind.anywhere.sharp is None:
        return True
    numbers = {one.name: 0.0 for one in kind.parameters}
    one = effect(kind.name, where=kind.where, **numbers)
    with suppress(InputError):
        Model(model.rig, friction=model.friction, effects=(*others, one))
        return True
    return False


def rival_at(one: FormulaEffect, rig: GeneralRig) -> RivalKind:
    """Return the facts of a user's own effect; its numbers, and those that it is made of, are in SI as they are."""
    own, where = rig.equations, one.where
    if one.acts == "reading":
        where = f"{where.removesuffix(CHANNEL) or own.names[0]}{CHANNEL}"
    elif not where:
        where = own.names[0] if one.acts == "force" else own.contacts[0].name
    kind = rival(replace(one, where=where), None)
    return replace(kind, depends_on=one.depends_on)


def scaled(kind: EffectKind, where: str, units: Units) -> EffectKind:
    """Return a kind at a place, its bounds, priors and starts in SI, and what its formulas read there."""
    info = tuple(_scaled(one, one.dimension.size(units)) for one in kind.parameters)
    sizes = {one.name: one.unit for one in info}
    starts = tuple({k: v * sizes[k] for k, v in one.items()} for one in kind.starts)
    own = {"parameters": info, "starts": starts, "depends_on": _read(kind)}
    return replace(kind, where=where, **own)  # type: ignore[arg-type]  # a place of its own


def _coupled(kind: EffectKind, sizes: Sizes) -> Iterator[EffectKind]:
    """Friction of a contact pressed by what moves across it; a reading that has a share of another of its unit."""
    own = sizes.own
    for i, by in enumerate(own.names):
        if kind.anywhere.reading is None:
            for one in own.contacts:
                if one.direction[i] == 0:
                    units = sizes.by(sizes.speed(i) / sizes.omega, sizes.static(one))
                    yield replace(scaled(kind, one.name, units), by=by, depends_on=(by, f"v_{by}"))
            continue
        for where, units in _places(kind, sizes):
            if where != by and where in own.names and own.units[own.names.index(where)] == own.units[i]:
                yield replace(scaled(kind, where, units), by=by, depends_on=(by,))


def _read(kind: EffectKind) -> tuple[str, ...]:
    """What a kind's formulas read at its place, "memory" where it has states, but for a reading that is added to."""
    acts = kind.anywhere
    texts = [
        acts.force,
        acts.factor,
        acts.peak,
        acts.aging,
        acts.reading,
        *(one for one, _ in acts.states.values()),
    ]
    trees = [parse(text) for text in texts if text is not None]
    read = {name for tree in trees for name in names(tree)} - {*kind.parameter_names, *acts.states}
    if not any(names(derivative(tree, "reading")) for tree in trees) and not acts.states:
        read -= {"reading"}
    remembers = bool(acts.states) or "dwell" in read
    return (*sorted(read - {"dwell"}), *(("memory",) if remembers else ()))


def _scaled(info: ParameterInfo, size: float) -> ParameterInfo:
    low, high = (None, None) if info.sought is None else (x * size for x in info.sought)
    return replace(
        info,
        unit=size,
        bounds=(info.bounds[0] * size, info.bounds[1] * size),
        spread=None if info.spread is None else info.spread * size,
        sought=None if low is None or high is None else (low, high),
    )


def _places(kind: EffectKind, sizes: Sizes) -> Iterator[tuple[str, Units]]:
    acts, own = kind.anywhere, sizes.own
    match acts.place:
        case "force":
            assert acts.force is not None
            yield from _pushed(kind, names(parse(acts.force)), sizes)
        case "reading":
            for name in sizes.data[0].channels:
                if name in sizes.rig.state_names:
                    yield name, sizes.channel(name)
        case "factor" if acts.of_belt:
            moving = {"belt": own.on_belt, "drive": own.driven}
            yield from ((name, Units(1.0, sizes.omega, 1.0)) for name, moves in moving.items() if moves)
        case _:
            for one in own.contacts:
                if acts.aging is None or sizes.sticks(one):
                    yield one.name, sizes.contact(one)


def _pushed(kind: EffectKind, read: set[str], sizes: Sizes) -> Iterator[tuple[str, Units]]:
    """Springs on links that have one, dampings on links and bodies, loads on bodies."""
    rig, own = sizes.rig, sizes.own
    rate, spring = "deflection_rate" in read, "deflection" in read
    rows: list[Floats] = []
    if isinstance(rig, BodiesRig) and (rate or spring):
        for i, one in enumerate(rig.link):
            row, of_drive = rig.deflection(i)
            if (rate and not of_drive) or (spring and float(one.stiffness) != 0):
                rows.append(row)
                yield f"link_{i + 1}", sizes.link(i)
    if isinstance(rig, BodiesRig) and spring:
        return
    for i, name in enumerate(own.names):
        if "abs" in (kind.anywhere.force or "") and any(
            along(one.direction, i) for one in own.contacts if one.against == "ground"
        ):
            continue  # such a drag is friction by speed, and of what rests it is a kink that never passes
        if not any(along(row, i) for row in rows):
            yield name, sizes.coordinate(i)


def along(row: Floats, i: int) -> bool:
    """Return whether a link, or a contact, acts on one coordinate alone."""
    return bool(row[i] != 0 and np.count_nonzero(row) == 1)
