"""What rigs of any kind share: M q'' + C q' + K q = force - sum of d_j T_j(v_j) + what a drive pulls with."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.dimensions import Dimension
from stickslip.errors import InputError, ModelWarning
from stickslip.objects import Displayed

Floats = NDArray[np.float64]
Against = Literal["ground", "belt"]
Unit = Literal["m", "rad", "1"]
Trait = Literal["inertia", "stiffness", "damping"]
PLACES = ("ground", "belt", "drive")  # no bodies: rest, what contacts rub on, and what links are pulled by
RESERVED = (*PLACES, "t", "mode")


class RigError(InputError):
    """An error within a rig: `path` leads to what is at fault, through its tables."""

    def __init__(self, what: str, *path: str | int, value: object = None) -> None:
        words = [str(one + 1) if isinstance(one, int) else one for one in path]
        super().__init__(what, key=" ".join(words) or None, value=value)
        self.path = path

    def __reduce__(self) -> tuple[object, ...]:
        return _rebuilt, (self.what, self.path, self.value)


def _rebuilt(what: str, path: tuple[str | int, ...], value: object) -> RigError:
    return RigError(what, *path, value=value)


@dataclass(frozen=True, eq=False)
class ContactRow:
    """A contact in the equations: v = direction . q' - speed of what it rubs on."""

    name: str
    direction: Floats  # (n,)
    against: Against
    law: str
    rotation: bool  # its force is a torque, its v an angular speed

    def slip(self, v: Floats, belt: Floats | float) -> Floats:
        """Return its v, of velocities (..., n) and the belt's speed there."""
        return np.asarray(v @ self.direction - (belt if self.against == "belt" else 0.0))


@dataclass(frozen=True, eq=False)
class LinkRow:
    """The force in a link: stiffness (row . q + of_drive x_drive - rest) + damping (row . q' + of_drive x_drive')."""

    name: str
    row: Floats  # (n,)
    of_drive: float
    stiffness: float
    damping: float
    rest: float
    rotation: bool  # a torque, as its first end turns

    @property
    def weights(self) -> Floats:
        """What it is by (q, q', x_drive, x_drive', 1), (2 n + 3,)."""
        k, c = self.stiffness, self.damping
        return np.array([*k * self.row, *c * self.row, k * self.of_drive, c * self.of_drive, -k * self.rest])


@dataclass(frozen=True, eq=False)
class Equations:
    """A rig's equations of motion.

    Attributes
    ----------
    names, units : (n,) coordinates, and what each is measured in.
    M, C, K : (n, n)
    force : (n,) constant force, of springs that are at rest elsewhere than at 0.
    drive_stiffness, drive_damping : (n,) force by displacement and by speed of the drive.
    contacts : one a contact.
    links : one a link of bodies; of matrices there are none.
    """

    names: tuple[str, ...]
    units: tuple[Unit, ...]
    M: Floats
    C: Floats
    K: Floats
    force: Floats
    drive_stiffness: Floats
    drive_damping: Floats
    contacts: tuple[ContactRow, ...]
    links: tuple[LinkRow, ...] = ()

    @property
    def sensed(self) -> dict[str, str]:
        """What sensors may read beside the state, with units: accelerations, forces in links, friction at contacts."""
        rates = {f"a_{name}": unit if unit == "1" else f"{unit}/s^2" for name, unit in self._coordinates}
        forces = {f"F_{one.name}": "N m" if one.rotation else "N" for one in self.links}
        return rates | forces | {f"T_{one.name}": self._of_contact(one) for one in self.contacts}

    @property
    def _coordinates(self) -> zip[tuple[str, Unit]]:
        return zip(self.names, self.units, strict=True)

    def _of_contact(self, one: ContactRow) -> str:
        if any(self.units[i] == "1" for i in np.flatnonzero(one.direction)):
            return "1"
        return "N m" if one.rotation else "N"

    @property
    def directions(self) -> Floats:
        """Rows of the contacts (m, n)."""
        return np.array([one.direction for one in self.contacts]).reshape(-1, len(self.names))

    @property
    def driven(self) -> bool:
        """The drive pulls at something."""
        return bool(np.any(self.drive_stiffness) or np.any(self.drive_damping))

    @property
    def on_belt(self) -> bool:
        """A contact rubs on the belt."""
        return any(one.against == "belt" for one in self.contacts)

    @property
    def belt_unit(self) -> str:
        """Unit of the belt's speed; "1" where contacts that turn and contacts that slide rub on it."""
        turns = {one.rotation for one in self.contacts if one.against == "belt"}
        return {frozenset({True}): "rad/s", frozenset({False}): "m/s"}.get(frozenset(turns), "1")

    @property
    def drive_unit(self) -> str:
        """Unit of the drive's speed; "1" where it pulls at coordinates of several kinds."""
        pulled = np.flatnonzero((self.drive_stiffness != 0) | (self.drive_damping != 0))
        units = {self.units[i] for i in pulled}
        return f"{units.pop()}/s" if len(units) == 1 and "1" not in units else "1"


class GeneralRig(Displayed):
    """A rig that is declared by its parts or by its matrices."""

    kind: ClassVar[str]
    dimensions: ClassVar[Mapping[str, Dimension]] = {}  # its numbers are in SI already

    @cached_property
    def equations(self) -> Equations:
        """The equations of motion."""
        raise NotImplementedError

    @property
    def numbers(self) -> dict[str, float]:
        """Every number by the name that `Model.parameters` gives it."""
        raise NotImplementedError

    def with_numbers(self, values: Mapping[str, float]) -> Self:
        """Return the rig with some numbers changed, in SI; a matrix stays symmetric only if both its entries are."""
        return replace(self, **self._changed(values))  # type: ignore[type-var]

    def moved(self, values: Mapping[str, float]) -> Equations:
        """Return the equations with some numbers a little off; what they may be is not asked."""
        other = copy(self)
        other.__dict__.pop("equations", None)
        other.__dict__.update(self._changed(values))
        return other.equations

    def _changed(self, values: Mapping[str, float]) -> dict[str, Any]:
        """Fields that hold some numbers, those changed."""
        raise NotImplementedError

    def table(self) -> dict[str, object]:
        """Return a file's table [rig]."""
        raise NotImplementedError

    @property
    def uncertain(self) -> Mapping[str, Trait]:
        """What each number is, of those that are measured and no lengths or choices, by name."""
        raise NotImplementedError

    def tied(self, name: str) -> tuple[str, ...]:
        """Return the numbers that are one with a number of `uncertain`: itself, and its mirror in a matrix."""
        return (name,)

    @property
    def channel_units(self) -> dict[str, str]:
        """What may be recorded, with its unit in the model: time, the state, what is sensed, prescribed speeds."""
        own = self.equations
        rates = ["1" if one == "1" else f"{one}/s" for one in own.units]
        out = {"t": "s", **dict(zip(self.state_names, [*own.units, *rates], strict=True))}
        out |= own.sensed
        out |= {"belt": own.belt_unit} if own.on_belt else {}
        way = own.drive_unit.removesuffix("/s")
        return out | ({"drive": own.drive_unit, "x_drive": way} if own.driven else {})

    @property
    def state_names(self) -> tuple[str, ...]:
        """Coordinates, then their velocities."""
        names = self.equations.names
        return (*names, *(f"v_{name}" for name in names))


def check_names(names: tuple[str, ...], where: str) -> None:
    """Refuse names of coordinates that a formula, a column or a place could not tell apart."""
    for name in names:
        if not name.isidentifier():
            raise RigError("is no name; letters, digits and _ make one", where, str(name))
        if name in RESERVED:
            raise RigError("is taken; name it otherwise", where, name)
        if names.count(name) > 1 or f"v_{name}" in names:
            other = name if names.count(name) > 1 else f"v_{name}"
            raise RigError(f"'{other}' names two states; name one otherwise", where)


def check_equations(own: Equations) -> None:
    """Refuse equations that do not determine the motion, and warn of ones that blow up by themselves.

    Raises
    ------
    RigError
        M is not symmetric and positive definite, or two contacts act on one direction.

    Warns
    -----
    ModelWarning
        Without friction the motion grows without bound.
    """
    M = own.M
    if not np.allclose(M, M.T, rtol=1e-12, atol=0):
        raise RigError("must be symmetric", "M")
    sizes = np.linalg.eigvalsh(M)
    if sizes[0] <= 1e-14 * abs(sizes[-1]):
        lacks = (
            "is singular: a coordinate has no inertia"
            if abs(sizes[0]) <= 1e-14 * abs(sizes[-1])
            else (f"has the eigenvalue {sizes[0]:.4g}; every inertia is positive")
        )
        raise RigError(lacks, "M")
    check_contacts(own)
    for name in own.sensed:
        if name in own.names:
            raise RigError(
                f"'{name}' names a coordinate and what a sensor reads of another; name one otherwise"
            )
    damped = np.linalg.eigvalsh((own.C + own.C.T) / 2)
    stiff = np.linalg.eigvals(np.linalg.solve(M, own.K))
    rate = np.sqrt(np.max(np.abs(stiff), initial=0.0)) + np.max(
        np.abs(np.linalg.solve(M, own.C)), initial=0.0
    )
    n = len(own.names)
    block = np.block(
        [[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, own.K), -np.linalg.solve(M, own.C)]]
    )
    growth = float(np.max(np.linalg.eigvals(block).real))
    if growth > 1e-6 * rate:
        why = (
            "a stiffness is negative"
            if np.min(stiff.real) < -1e-12 * np.max(np.abs(stiff))
            else ("a damping is negative" if damped[0] < 0 else "the matrices are not symmetric")
        )
        words = f"{why}: without friction the motion grows as exp({growth:.4g} t)"
        warnings.warn(words, ModelWarning, stacklevel=5)


def check_contacts(own: Equations) -> None:
    """Refuse contacts of one name or one direction, and of so many directions that what each carries is not known."""
    rows = own.directions
    for i, one in enumerate(own.contacts):
        if not np.any(rows[i]):
            raise RigError("acts on no coordinate: its direction is zero", "contact", i)
        for k in range(i):
            if own.contacts[k].name == one.name and not np.array_equal(rows[i], rows[k]):
                raise RigError(f"'{one.name}' names two contacts; name one otherwise", "contact", i)
            a, b = rows[i] / np.linalg.norm(rows[i]), rows[k] / np.linalg.norm(rows[k])
            if abs(abs(a @ b) - 1) < 1e-12:
                words = f"acts on the same direction as contact {k + 1} ('{own.contacts[k].name}')"
                raise RigError(f"{words}; put both into one law", "contact", i)
    if len(rows) > len(own.names) or (len(rows) and np.linalg.matrix_rank(rows) < len(rows)):
        words = f"{len(rows)} contacts on {len(own.names)} coordinates depend on each other: "
        raise RigError(words + "what each carries in stick would be undetermined", "contact")
