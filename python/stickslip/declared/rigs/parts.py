"""The parts of a rig: bodies, links between them, contacts on them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import ClassVar

from stickslip.arguments import explained, must_be
from stickslip.declared.formula.dimension import dimensions, said
from stickslip.declared.quantity import quantity
from stickslip.errors import InputError, number
from stickslip.objects import Displayed, as_call

Size = float | str
# "initial.x1", "gain.x1" and "offset.x1" are no numbers of a model: no part, law or effect owns them
RESERVED_OWNERS = {
    "initial": "a start",
    "gain": "a sensor's gain",
    "offset": "a sensor's offset",
}


@dataclass(frozen=True, kw_only=True, repr=False)
class RigPart(Displayed):
    """A part of a rig: its numbers, given bare in SI or as text with a unit, become floats in SI."""

    __repr__ = as_call

    sizes: ClassVar[Mapping[str, Mapping[str, float]]] = {}  # its numbers, and their bounds

    def __post_init__(self) -> None:
        units = {}
        for name, bounds in self.sizes.items():
            given = getattr(self, name)
            if given is None:
                continue
            size, unit = quantity(name, given)
            if unit is not None:
                units[name] = unit
            object.__setattr__(self, name, number(name, size, above=bounds.get("above", -math.inf)))
        object.__setattr__(self, "_units", units)

    def measures(self, name: str, *allowed: str) -> None:
        """Refuse a number that was given in a unit of something else."""
        unit = self.__dict__["_units"].get(name)
        if unit is not None and dimensions(unit) not in [dimensions(one) for one in allowed]:
            words = f"is {said(dimensions(unit))}; it must be {said(dimensions(allowed[0]))}"
            raise InputError(words, key=name)

    def table(self) -> dict[str, object]:
        """Return the part as a file has it, what was not given left out."""
        given = {one.name: (getattr(self, one.name), one.default) for one in fields(self)}
        return {
            name: list(one) if isinstance(one, tuple) else one
            for name, (one, usual) in given.items()
            if one != usual
        }


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class Body(RigPart):
    """A body that slides (a mass) or turns (an inertia); one coordinate.

    Parameters
    ----------
    mass, inertia
        One of the two, positive: "0.5 kg" or "0.35 kg m^2"; a bare number is in SI.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.Body(mass="500 g").size
    0.5
    >>> ss.Body(inertia="0.35 kg m^2").rotation
    True
    """

    sizes: ClassVar[Mapping[str, Mapping[str, float]]] = {"mass": {"above": 0.0}, "inertia": {"above": 0.0}}

    mass: Size | None = None
    inertia: Size | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.mass is None) == (self.inertia is None):
            raise InputError("give a mass (it slides) or an inertia (it turns), one of the two", key="mass")
        self.measures("mass", "kg")
        self.measures("inertia", "kg m^2", "kg m^2/rad", "kg m^2/rad^2")

    @property
    def rotation(self) -> bool:
        """It turns."""
        return self.inertia is not None

    @property
    def size(self) -> float:
        """The mass or the inertia, in SI."""
        return float(self.inertia or self.mass or 0.0)


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class Link(RigPart):
    """A spring and a damper between two bodies: of the deflection e = q_first - gear q_second - rest.

    Parameters
    ----------
    between
        Two names: of bodies, "ground" or "drive".
    stiffness, damping
        As of what the first body does: "12 N m/rad", "0.01 N s/m".
    rest
        Deflection at which the spring is slack, in m or rad.
    gear
        What the second moves for in the deflection; 1 if absent. Between a body that slides and one that turns it is
        a lever arm, like "0.05 m/rad".

    Examples
    --------
    >>> import stickslip as ss
    >>> table = ss.Link(between=("table", "drive"), stiffness="80 N m/rad", damping="0.5 N m s/rad")
    >>> table.stiffness
    80.0
    """

    sizes: ClassVar[Mapping[str, Mapping[str, float]]] = {
        name: {} for name in ("stiffness", "damping", "rest", "gear")
    }

    between: tuple[str, str]
    stiffness: Size = 0.0
    damping: Size = 0.0
    rest: Size = 0.0
    gear: Size | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        given: object = self.between
        if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
            raise InputError('must be two names, like ["block", "ground"]', key="between", value=given)
        object.__setattr__(self, "between", (str(given[0]), str(given[1])))
        if self.between[0] == self.between[1]:
            raise InputError("a link joins two different ends", key="between", value=list(self.between))
        if self.gear == 0:
            raise InputError("a gear of 0 joins nothing", key="gear")


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class Contact(RigPart):
    """A place where a body rubs on something.

    Parameters
    ----------
    body
        Its name.
    against
        "ground", "belt" (moved at a prescribed speed) or another body.
    law
        Name of its law, a table [law.<name>]; "" for the only one.
    arm
        Lever arm of friction on a body that turns ("20 mm"): v is then a speed, T a force; absent, an angular speed
        and a torque.
    name
        That of the body if absent.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.Contact(body="bit", against="ground", law="rock").against
    'ground'
    >>> ss.Contact(body="arm", against="belt", arm="20 mm").arm
    0.02
    """

    sizes: ClassVar[Mapping[str, Mapping[str, float]]] = {"arm": {}}

    body: str
    against: str = "ground"
    law: str = ""
    arm: Size | None = None
    name: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self.measures("arm", "m", "m/rad")
        for key in ("body", "against", "law"):
            must_be(key, getattr(self, key), str)
