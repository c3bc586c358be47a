"""A rig by its parts: bodies, links between them, contacts on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np

from stickslip.arguments import explained, must_be
from stickslip.declared.rigs.general import (
    Against,
    ContactRow,
    Equations,
    GeneralRig,
    LinkRow,
    RigError,
    Trait,
    Unit,
    check_equations,
    check_names,
)
from stickslip.declared.rigs.parts import RESERVED_OWNERS, Body, Contact, Link, RigPart
from stickslip.errors import InputError, did_you_mean

P = TypeVar("P", bound="RigPart")


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class BodiesRig(GeneralRig):
    """A rig by its parts; every body has one coordinate, and the state is all of these, then their velocities.

    Parameters
    ----------
    body
        `Body`, or a table of its parts, by name: the coordinate's name too.
    link
        `Link`s, or tables. A mass without a spring is allowed.
    contact
        `Contact`s, or tables.

    Raises
    ------
    InputError
        A part is wrong, a name unknown or taken, a unit measures something else, two contacts act on one direction.

    Warns
    -----
    ModelWarning
        Without friction the motion would grow without bound: a stiffness or damping is negative.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.BodiesRig(
    ...     body={"table": ss.Body(inertia=2122), "bit": ss.Body(inertia=374)},  # kg m^2
    ...     link=[
    ...         ss.Link(between=("table", "drive"), stiffness=1000),  # N m/rad
    ...         ss.Link(between=("bit", "table"), stiffness=473, damping=23.2),
    ...     ],
    ...     contact=[ss.Contact(body="bit")],
    ... )
    >>> rig.state_names
    ('table', 'bit', 'v_table', 'v_bit')
    """

    kind: ClassVar[str] = "bodies"

    body: Mapping[str, Body] = field(hash=False)
    link: Sequence[Link] = ()
    contact: Sequence[Contact] = ()

    def __post_init__(self) -> None:
        bodies = {
            str(name): _part(Body, one, "body", str(name))
            for name, one in must_be("body", self.body, Mapping).items()
        }
        object.__setattr__(self, "body", bodies)
        links = [_part(Link, one, "link", i) for i, one in enumerate(_listed("link", self.link))]
        object.__setattr__(self, "link", tuple(links))
        contacts = [
            _part(Contact, one, "contact", i) for i, one in enumerate(_listed("contact", self.contact))
        ]
        object.__setattr__(self, "contact", tuple(contacts))
        if not bodies:
            raise RigError("a rig has a body at least, like [rig.body.block]", "body")
        check_names(tuple(bodies), "body")
        for name in bodies:
            joint = self._joints().get(name)
            if joint is not None or name in RESERVED_OWNERS:
                what = RESERVED_OWNERS.get(name, "a link" if isinstance(joint, Link) else "a contact")
                raise RigError(f"is what {what} is called; name it otherwise", "body", name)
        check_equations(self.equations)

    def __hash__(self) -> int:
        return hash((tuple(self.body.items()), self.link, self.contact))

    @cached_property
    def equations(self) -> Equations:
        """The equations of motion."""
        names = tuple(self.body)
        n = len(names)
        M = np.diag([one.size for one in self.body.values()])
        C, K, force = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
        pulled, dragged = np.zeros(n), np.zeros(n)
        links = []
        for i, one in enumerate(self.link):
            row, of_drive = self._deflection(i, one)
            k, c, rest = float(one.stiffness), float(one.damping), float(one.rest)
            turns = next(self.body[end].rotation for end in one.between if end in self.body)
            links.append(LinkRow(f"link_{i + 1}", row, of_drive, k, c, rest, turns))
            K += k * np.outer(row, row)
            C += c * np.outer(row, row)
            force += k * rest * row
            pulled -= k * of_drive * row  # the force is -row k (row . q + of_drive x_drive - rest)
            dragged -= c * of_drive * row
        rows = tuple(self._contact_row(i, one) for i, one in enumerate(self.contact))
        units: tuple[Unit, ...] = tuple("rad" if one.rotation else "m" for one in self.body.values())
        return Equations(names, units, M, C, K, force, pulled, dragged, rows, tuple(links))

    def _deflection(self, i: int, one: Link) -> tuple[np.ndarray[Any, Any], float]:
        """Row of a link's deflection over the coordinates, and its share of the drive's displacement."""
        names, ends = tuple(self.body), one.between
        for end in ends:
            if end not in names and end not in ("ground", "drive"):
                hint = did_you_mean(end, [*names, "ground", "drive"])
                if end == "belt":
                    hint = "a belt is what contacts rub on; a link is pulled by the 'drive'"
                raise RigError(f"no body '{end}'; {hint}", "link", i, "between")
        turns = [self.body[end].rotation if end in self.body else None for end in ends]
        if not any(end in names for end in ends):
            raise RigError("one end must be a body", "link", i, "between", value=list(ends))
        rotation = turns[0] if turns[0] is not None else turns[1]
        mixed = None not in turns and turns[0] != turns[1]
        if mixed and one.gear is None:
            words = "joins a body that slides and one that turns; it needs a gear, like gear = '0.05 m/rad'"
            raise RigError(words, "link", i, "between")
        if one.gear is not None and one.between[1] == "ground":
            words = "the ground does not move, so that a gear to it does nothing; leave it out"
            raise RigError(words, "link", i, "gear")
        self._check_units(i, one, bool(rotation), mixed)
        row, of_drive = np.zeros(len(names)), 0.0
        for end, share in zip(ends, (1.0, -1.0 if one.gear is None else -float(one.gear)), strict=True):
            if end in names:
                row[names.index(end)] += share
            elif end == "drive":
                of_drive = share
        return row, of_drive

    def deflection(self, i: int) -> tuple[np.ndarray[Any, Any], float]:
        """Row of a link's deflection over the coordinates, and its share of the drive's displacement."""
        return self._deflection(i, self.link[i])

    def _check_units(self, i: int, one: Link, rotation: bool, mixed: bool) -> None:
        length = "rad" if rotation else "m"
        force = "N m" if rotation else "N"
        gear = ("1",) if not mixed else ("rad/m", "1/m") if rotation else ("m/rad", "m")
        try:
            one.measures("stiffness", f"{force}/{length}")
            one.measures("damping", f"{force} s/{length}")
            one.measures("rest", length)
            one.measures("gear", *gear)
        except InputError as error:
            raise RigError(error.what, "link", i, error.key or "") from None

    def _contact_row(self, i: int, one: Contact) -> ContactRow:
        names = tuple(self.body)
        if one.body not in names:
            raise RigError(f"no body '{one.body}'; {did_you_mean(one.body, names)}", "contact", i, "body")
        body = self.body[one.body]
        if one.arm is not None and not body.rotation:
            raise RigError("a body that slides has no lever arm", "contact", i, "arm")
        if one.arm is not None and float(one.arm) == 0:
            raise RigError("a lever arm of 0 carries nothing", "contact", i, "arm")
        row = np.zeros(len(names))
        row[names.index(one.body)] = 1.0 if one.arm is None else float(one.arm)
        turns = body.rotation and one.arm is None
        against: Against = "belt" if one.against == "belt" else "ground"
        if one.against not in ("ground", "belt"):
            other = self.body.get(one.against)
            if other is None:
                hint = did_you_mean(one.against, [*names, "ground", "belt"])
                if one.against == "drive":
                    hint = "a drive pulls at links; what a contact rubs on is the 'belt'"
                raise RigError(f"no body '{one.against}'; {hint}", "contact", i, "against")
            if other.rotation != turns or one.against == one.body:
                words = (
                    "must be another body" if one.against == one.body else "does not move as the body does"
                )
                raise RigError(words, "contact", i, "against", value=one.against)
            row[names.index(one.against)] = -1.0
        return ContactRow(one.name or one.body, row, against, one.law, turns)

    @property
    def numbers(self) -> dict[str, float]:
        """Every number by name: "table.inertia", "link_1.stiffness", "bit.arm"."""
        out: dict[str, float] = {}
        for name, part in self.parts.items():
            sizes = {key: getattr(part, key) for key in part.sizes}
            out |= {f"{name}.{key}": float(size) for key, size in sizes.items() if size is not None}
        return out

    @property
    def uncertain(self) -> Mapping[str, Trait]:
        """Masses, inertias, stiffnesses and dampings; gears, lever arms and rests are lengths."""
        what: dict[str, Trait] = {
            "mass": "inertia",
            "inertia": "inertia",
            "stiffness": "stiffness",
            "damping": "damping",
        }
        kinds = {name: what.get(name.rpartition(".")[2]) for name, size in self.numbers.items() if size != 0}
        return {name: kind for name, kind in kinds.items() if kind is not None}

    def _changed(self, values: Mapping[str, float]) -> dict[str, Any]:
        by: dict[str, dict[str, float]] = {}
        for name, size in values.items():
            owner, _, key = name.rpartition(".")
            by.setdefault(owner, {})[key] = size
        return {
            "body": {name: replace(one, **by.get(name, {})) for name, one in self.body.items()},
            "link": [replace(one, **by.get(f"link_{i + 1}", {})) for i, one in enumerate(self.link)],  # type: ignore[arg-type]  # numbers by name
            "contact": [replace(one, **by.get(f"contact_{i + 1}", {})) for i, one in enumerate(self.contact)],  # type: ignore[arg-type]
        }

    @property
    def parts(self) -> dict[str, RigPart]:
        """Bodies, links and contacts by what their numbers are called."""
        return {**self.body, **self._joints()}

    def _joints(self) -> dict[str, RigPart]:
        links: dict[str, RigPart] = {f"link_{i + 1}": one for i, one in enumerate(self.link)}
        contacts: dict[str, RigPart] = {f"contact_{i + 1}": one for i, one in enumerate(self.contact)}
        return {**links, **contacts}

    def table(self) -> dict[str, object]:
        """Return a file's table [rig]."""
        out: dict[str, object] = {"kind": self.kind}
        out["body"] = {name: one.table() for name, one in self.body.items()}
        if self.link:
            out["link"] = [one.table() for one in self.link]
        if self.contact:
            out["contact"] = [one.table() for one in self.contact]
        return out


def _listed(key: str, given: object) -> list[object]:
    if isinstance(given, (str, Mapping)) or not isinstance(given, Sequence):
        raise RigError(f"must be a list of {key}s, [[rig.{key}]] in a file", key)
    return list(given)


def _part(kind: type[P], given: object, *path: str | int) -> P:
    if isinstance(given, kind):
        return given
    if not isinstance(given, Mapping):
        raise RigError(f"must be a {kind.__name__} or a table of its parts", *path)
    known = [one.name for one in fields(kind)]
    for key in given:
        if key not in known:
            raise RigError(f"unknown; {did_you_mean(str(key), known)}", *path, str(key))
    needed = {"link": "between", "contact": "body"}.get(str(path[0]))
    if needed is not None and needed not in given:
        raise RigError(f"lacks '{needed}'", *path)
    try:
        return kind(**given)
    except InputError as error:
        raise RigError(error.what, *path, *([error.key] if error.key else []), value=error.value) from None
