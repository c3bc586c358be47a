"""Friction measured at some speeds: a curve through them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from stickslip.arguments import explained
from stickslip.declared.dimensions import FORCE, SPEED, Dimension
from stickslip.declared.formula.dimension import dimensions
from stickslip.declared.formula.tree import Name, Tree
from stickslip.declared.formula_law import LawByFormula, monotone_cubic
from stickslip.declared.law_form import BranchForm, LawForm
from stickslip.declared.law_numbers import Size, Sized, law_number, measure_of
from stickslip.errors import InputError, number

FORCES = ("forces", "forces_plus")  # lists whose members are numbers of the law


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class TabulatedFriction(LawByFormula):
    """R(u) through any number of points, constant before the first and after the last.

    Between the points runs the cubic of Fritsch and Butland (1984), which has no hump that the points have not.

    Parameters
    ----------
    speeds
        u of the points, not negative, increasing; at least two. Lists may hold text with units ("2 mm/s").
    forces
        R there, not negative; `Model.parameters` has them as "forces[0]", "forces[1]" and so on.
    static
        Static limit; the first of `forces` if absent.
    speeds_plus, forces_plus, static_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        The lists differ in length, speeds do not increase, a number is negative or not finite.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.TabulatedFriction(speeds=[0, "1 cm/s", "10 cm/s"], forces=["2 N", "1.2 N", "1.5 N"])
    >>> print(law.magnitude([0.0, 0.005]).round(4))
    [2.     1.4896]
    """

    kind: ClassVar[str] = "tabulated"
    rank: ClassVar[int] = 50
    each_way: ClassVar[tuple[str, ...]] = ("speeds", "forces", "static")
    dimensions: ClassVar[Mapping[str, Dimension]] = {"speeds": SPEED, "forces": FORCE, "static": FORCE}

    speeds: Sequence[float]
    forces: Sequence[float]
    static: float | None = None
    speeds_plus: Sequence[float] | None = None
    forces_plus: Sequence[float] | None = None
    static_plus: float | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            speeds: Sequence[Size],
            forces: Sequence[Size],
            static: Size | None = ...,
            speeds_plus: Sequence[Size] | None = ...,
            forces_plus: Sequence[Size] | None = ...,
            static_plus: Size | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        units: dict[str, str] = {}
        for name in ("speeds", "forces", "speeds_plus", "forces_plus"):
            if (given := getattr(self, name)) is not None:
                object.__setattr__(self, name, self._numbers(name, given, units))
        for name in ("static", "static_plus"):
            if (one := getattr(self, name)) is not None:
                object.__setattr__(self, name, self._numbers(name, [one], units)[0])
        object.__setattr__(self, "_units", units)
        for twin in ("", "_plus"):
            speeds, forces, _ = self._side(bool(twin))
            if len(speeds) != len(forces):
                key = f"forces{twin if self.forces_plus is not None else ''}"
                raise InputError(f"has {len(forces)} numbers for {len(speeds)} speeds", key=key)
            if len(speeds) < 2:
                raise InputError("a curve needs two points at least", key=f"speeds{twin}")
            if np.any(np.diff(speeds) <= 0):
                raise InputError("must increase", key=f"speeds{twin}")

    def _numbers(self, name: str, values: Sequence[float | str], units: dict[str, str]) -> tuple[float, ...]:
        """The numbers of a list in SI; a unit that any of them is given in is noted."""
        if isinstance(values, (str, bytes)) or not isinstance(values, (Sequence, np.ndarray)):
            raise InputError("must be a list of numbers, in [ ]", key=name)
        what = measure_of(self.dimensions, name)
        own = name if name.startswith("static") else f"{name}[{{}}]"
        read = [law_number(own.format(i), one, what) for i, one in enumerate(values)]
        given = [unit for _, unit in read if unit is not None]
        if given:
            units[name] = given[0]
        if any(dimensions(unit) != dimensions(given[0]) for unit in given):
            raise InputError("has units of a contact that slides and of one that turns", key=name)
        sizes = [number(own.format(i), size, least=0.0) for i, (size, _) in enumerate(read)]
        return tuple(
            size if unit is None else Sized(size, unit) for size, (_, unit) in zip(sizes, read, strict=True)
        )

    def _side(self, plus: bool) -> tuple[Sequence[float], Sequence[float], float | None]:
        if not plus:
            return self.speeds, self.forces, self.static
        return (
            self.speeds if self.speeds_plus is None else self.speeds_plus,
            self.forces if self.forces_plus is None else self.forces_plus,
            self.static if self.static_plus is None else self.static_plus,
        )

    @property
    def numbers(self) -> dict[str, float]:
        """The forces by their places, "forces[0]" the first, and the static limits."""
        of = {name: getattr(self, name) or () for name in FORCES}
        forces = {f"{name}[{i}]": float(one) for name, each in of.items() for i, one in enumerate(each)}
        return forces | super().numbers

    def with_numbers(self, values: Mapping[str, float]) -> Self:
        """Return the law with some forces or static limits changed."""
        given: dict[str, Any] = {
            name: list(getattr(self, name)) for name in FORCES if getattr(self, name) is not None
        }
        for name, one in values.items():
            of, _, place = name.partition("[")
            if place:
                given[of][int(place.removesuffix("]"))] = one
            else:
                given[name] = one
        return replace(self, **given)

    def _make_form(self) -> LawForm:
        numbers = self.numbers
        branches = []
        for twin in (False, True):
            speeds, forces, static = self._side(twin)
            of = "forces_plus" if twin and self.forces_plus is not None else "forces"
            knots: list[Tree] = [Name(f"{of}[{i}]") for i in range(len(forces))]
            limit = knots[0]
            if static is not None:
                limit = Name("static_plus" if twin and self.static_plus is not None else "static")
            branches.append(BranchForm(monotone_cubic("u", speeds, knots), limit))
        return LawForm(branches[0], branches[1], numbers)


LAW = TabulatedFriction
