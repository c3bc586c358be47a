"""Coulomb friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from stickslip.arguments import explained
from stickslip.declared.dimensions import FORCE, Dimension
from stickslip.declared.friction_law import Direction, Floats, FrictionLaw, LawBranch, check_numbers
from stickslip.declared.law_numbers import Size
from stickslip.errors import InputError


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class CoulombFriction(FrictionLaw):
    """Coulomb friction: one kinetic magnitude below a static limit.

    Parameters
    ----------
    static, kinetic
        0 <= kinetic <= static; for both directions, or for v_w < 0 where v_w > 0 has a value of its own. Numbers may be
        text with a unit, here and below ("4 N").
    static_plus, kinetic_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        A number is not finite or negative, its unit is not one of a force (or a torque), or kinetic exceeds static.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.CoulombFriction(static="2 N", kinetic=1.2)
    >>> law.static_limits
    (2.0, 2.0)
    >>> law.magnitude(0.01)
    array(1.2)
    """

    kind: ClassVar[str] = "coulomb"
    rank: ClassVar[int] = 20
    formula: ClassVar[str] = "kinetic"
    at_rest: ClassVar[str] = "static"
    equations: ClassVar[tuple[tuple[str, str, str], ...]] = (("R", "kinetic", "static"),)
    drawn: ClassVar[Mapping[str, float]] = {"static": 3.0, "kinetic": 2.0}
    drawn_to: ClassVar[float] = 1.0
    each_way: ClassVar[tuple[str, ...]] = ("static", "kinetic")
    dimensions: ClassVar[Mapping[str, Dimension]] = {"static": FORCE, "kinetic": FORCE}

    static: float = 1.0
    kinetic: float = 0.5
    static_plus: float | None = None
    kinetic_plus: float | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            static: Size = ...,
            kinetic: Size = ...,
            static_plus: Size | None = ...,
            kinetic_plus: Size | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        check_numbers(self, {field.name: {"least": 0} for field in fields(self)})
        limits, kinetic = self.static_limits, self.kinetic_limits
        for side, (limit, force) in enumerate(zip(limits, kinetic, strict=True)):
            if force > limit:
                key = "kinetic_plus" if side and self.kinetic_plus is not None else "kinetic"
                words = f"above the static limit {limit:g}; kinetic friction must not exceed static friction"
                raise InputError(words, key=key, value=force)

    @property
    def static_limits(self) -> tuple[float, float]:
        """Static limits (minus, plus)."""
        return self.static, self.static if self.static_plus is None else self.static_plus

    @property
    def kinetic_limits(self) -> tuple[float, float]:
        """Kinetic magnitudes (minus, plus)."""
        return self.kinetic, self.kinetic if self.kinetic_plus is None else self.kinetic_plus

    @property
    def kinks(self) -> tuple[None, None]:
        """None: the branches are constant."""
        return None, None

    def _minus(self, u: Floats) -> Floats:
        return np.full_like(u, self.kinetic_limits[0])

    def _plus(self, u: Floats) -> Floats:
        return np.full_like(u, self.kinetic_limits[1])

    def branch(self, direction: Direction) -> LawBranch:
        """Return the constant branch for slip with the sign `direction`."""
        side = int(direction > 0)
        kinetic = self.kinetic_limits[side]
        return LawBranch(self.static_limits[side], lambda u: kinetic + 0 * u)


LAW = CoulombFriction
