"""What a friction law is made of: magnitudes R(u) of the two branches over u = |v_w|, and the static limits.

Every file of `friction/` holds such a law, `LAW`.

"minus" is slip with v_w < 0 (a block that breaks away from a belt with v_b > 0), "plus" slip with v_w > 0.
The force in (2.1) is T = sgn(v_w) R(|v_w|), so that T v_w >= 0 always; to a block it carries the belt can
supply -static_plus to static_minus.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.declared.dimensions import Dimension
from stickslip.declared.formula.parse import parse
from stickslip.declared.law_form import BranchForm, LawForm
from stickslip.declared.law_numbers import Sized, law_number, measure_of
from stickslip.declared.quantity import InUnits
from stickslip.errors import number
from stickslip.objects import Drawn, as_call

Floats = NDArray[np.float64]
Value = Any  # a float or complex number, or an array of either
Direction = int  # the sign of v_w: -1 or 1


@dataclass(frozen=True)
class LawBranch:
    """One direction of a friction law: static limit, R(u) below the kink, constant R beyond it."""

    static: float
    below: Callable[[Value], Value]
    above: float = 0.0
    kink: float | None = None


@dataclass(frozen=True)
class FrictionLaw(InUnits, Drawn):
    """What the laws share: the branch is chosen by the sign of v_w.

    `kind` is its name in a file and in the core, `rank` its place in lists. `single` names the numbers that are those
    of one branch, `each_way` those that have a twin `..._plus` for v_w > 0, which is None where both are the same.
    `dimensions` has what every number measures, twins aside; `formula` and `at_rest` say R(u) and the static limits in
    the table of laws. `equations` are R(u) and the static limit in Python's syntax, of both branches or of each, with
    its name; `form` reads them. `drawn` are the numbers of the example in the documents, drawn up to the speed
    `drawn_to`.
    """

    __repr__ = as_call

    kind: ClassVar[str]
    rank: ClassVar[int]
    single: ClassVar[tuple[str, ...]] = ()
    each_way: ClassVar[tuple[str, ...]] = ()
    dimensions: ClassVar[Mapping[str, Dimension]]
    formula: ClassVar[str]
    at_rest: ClassVar[str]
    equations: ClassVar[tuple[tuple[str, str, str], ...]]
    drawn: ClassVar[Mapping[str, float]]
    drawn_to: ClassVar[float]

    @property
    def numbers(self) -> dict[str, float]:
        """The law's numbers by name, those that were not given left out."""
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        return {name: one for name, one in values.items() if isinstance(one, float)}

    def with_numbers(self, values: Mapping[str, float]) -> Self:
        """Return the law with some numbers changed."""
        return replace(self, **values)

    @property
    def static_limits(self) -> tuple[float, float]:
        """Static limits (minus, plus)."""
        raise NotImplementedError

    @property
    def kinks(self) -> tuple[float | None, float | None]:
        """Speeds u (minus, plus) from which a branch is constant; None where it never is by itself."""
        raise NotImplementedError

    def branch(self, direction: Direction) -> LawBranch:
        """Return what `reference` integrates for slip with the sign `direction`."""
        raise NotImplementedError

    def form(self) -> LawForm:
        """Return the law as trees, with which a rig of bodies or matrices is simulated."""
        branches = [BranchForm(parse(kinetic), parse(static)) for _, kinetic, static in self.equations]
        if len(branches) == 2:
            return LawForm(branches[0], branches[1], self.numbers)
        twins = {name: f"{name}_plus" for name in self.each_way if getattr(self, f"{name}_plus") is not None}
        return LawForm(branches[0], branches[0].renamed(twins), self.numbers)

    def _minus(self, u: Floats) -> Floats:
        raise NotImplementedError

    def _plus(self, u: Floats) -> Floats:
        raise NotImplementedError

    def magnitude(self, v_w: ArrayLike) -> Floats:
        """Kinetic magnitude R(|v_w|) of the branch that the sign of v_w chooses.

        Parameters
        ----------
        v_w
            Sliding velocity, any shape. At exactly 0 the branch is T_minus, that of a forward belt.

        Returns
        -------
        R, the shape of `v_w`.
        """
        v = np.asarray(v_w, dtype=np.float64)
        u = np.abs(v)
        return np.where(v > 0, self._plus(u), self._minus(u))

    def force(self, v_w: ArrayLike) -> Floats:
        """T = sgn(v_w) R(|v_w|), (4.3) with the sign counted once; 0 at v_w = 0, where T is a set."""
        v = np.asarray(v_w, dtype=np.float64)
        return np.sign(v) * self.magnitude(v)


def given_numbers(law: FrictionLaw, silent: Collection[str] = ()) -> dict[str, float]:
    """Return what was declared of a law: its numbers by name, those that hold for both directions under both names.

    Parameters
    ----------
    law
        As declared.
    silent
        Its numbers that nobody gave.
    """
    own = {one.name: getattr(law, one.name) for one in fields(law) if one.name not in silent}
    if any(not isinstance(value, int | float) for value in own.values() if value is not None):
        return dict(
            law.numbers
        )  # several laws, a curve or a formula: none of its numbers goes without saying
    given = {name: float(value) for name, value in own.items() if value is not None}
    twins = {f"{name}_plus": given[name] for name in law.each_way if name in given}
    return {**{name: one for name, one in twins.items() if getattr(law, name) is None}, **given}


def check_numbers(law: FrictionLaw, bounds: Mapping[str, Mapping[str, float]]) -> None:
    """Turn every number given to a frozen law, bare or with a unit, into a float within its bounds.

    Parameters
    ----------
    law
        As declared; its fields that are no numbers of it stay.
    bounds
        By name, as `stickslip.errors.number` has them; those of a number hold for its twin too, if that has none.
    """
    units: dict[str, str] = {}
    for field in fields(law):
        name, value, own = field.name, getattr(law, field.name), field.name.removesuffix("_plus")
        if not {name, own} & law.dimensions.keys() or (value is None and field.default is None):
            continue
        size, unit = law_number(name, value, measure_of(law.dimensions, name))
        limits = bounds.get(name, bounds.get(own, {}))
        size = number(name, size, **limits)  # type: ignore[arg-type]
        if unit is not None:
            units[name] = unit
            size = Sized(size, unit)
        object.__setattr__(law, name, size)
    object.__setattr__(law, "_units", units)
