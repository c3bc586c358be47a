"""Friction that falls with the speed as a hyperbola."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from stickslip.arguments import explained
from stickslip.declared.dimensions import FORCE, PER_SPEED, QUADRATIC_DAMPING, Dimension
from stickslip.declared.friction_law import Direction, Floats, FrictionLaw, LawBranch, check_numbers
from stickslip.declared.law_numbers import Size
from stickslip.errors import InputError


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class HyperbolicFriction(FrictionLaw):
    """R(u) = scale/(1 + decay u) + constant + quadratic u^2, static limit R(0).

    Parameters
    ----------
    scale, decay
        Not negative. Numbers may be text with a unit, here and below ("4 N").
    constant, quadratic
        Such that R stays positive or zero at every speed.
    scale_plus, decay_plus, constant_plus, quadratic_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        A number is not finite, out of its bounds, or of another unit; R turns negative at some speed.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.HyperbolicFriction(scale=1, decay=3)
    >>> print(law.magnitude([-0.1, 0.5]).round(4))
    [0.7692 0.4   ]
    """

    kind: ClassVar[str] = "hyperbolic"
    rank: ClassVar[int] = 30
    formula: ClassVar[str] = "scale/(1 + decay u) + constant + quadratic u^2"
    at_rest: ClassVar[str] = "R(0) = scale + constant"
    equations: ClassVar[tuple[tuple[str, str, str], ...]] = (
        ("R", "scale/(1 + decay*u) + constant + quadratic*u**2", "scale + constant"),
    )
    drawn: ClassVar[Mapping[str, float]] = {"scale": 2.0, "decay": 3.0, "constant": 1.0}
    drawn_to: ClassVar[float] = 2.0
    each_way: ClassVar[tuple[str, ...]] = ("scale", "decay", "constant", "quadratic")
    dimensions: ClassVar[Mapping[str, Dimension]] = {
        "scale": FORCE,
        "decay": PER_SPEED,
        "constant": FORCE,
        "quadratic": QUADRATIC_DAMPING,
    }

    scale: float = 1.0
    decay: float = 3.0
    constant: float = 0.0
    quadratic: float = 0.0
    scale_plus: float | None = None
    decay_plus: float | None = None
    constant_plus: float | None = None
    quadratic_plus: float | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            scale: Size = ...,
            decay: Size = ...,
            constant: Size = ...,
            quadratic: Size = ...,
            scale_plus: Size | None = ...,
            decay_plus: Size | None = ...,
            constant_plus: Size | None = ...,
            quadratic_plus: Size | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        not_negative = ("scale", "decay", "scale_plus", "decay_plus")
        check_numbers(self, {f.name: {"least": 0} if f.name in not_negative else {} for f in fields(self)})
        for side, numbers in zip(("v_w < 0", "v_w > 0"), (self.minus, self.plus), strict=True):
            u = _negative_from(*numbers)
            if u is not None:
                where = f"for {side} " + (f"from u = {u:.3g} on" if u else "at u = 0 already")
                raise InputError(f"R turns negative {where}; friction must oppose sliding")

    @property
    def minus(self) -> tuple[float, float, float, float]:
        """Scale, decay, constant and quadratic for v_w < 0."""
        return self.scale, self.decay, self.constant, self.quadratic

    @property
    def plus(self) -> tuple[float, float, float, float]:
        """Scale, decay, constant and quadratic for v_w > 0."""
        own = (self.scale_plus, self.decay_plus, self.constant_plus, self.quadratic_plus)
        a, d, c, q = (m if p is None else p for m, p in zip(self.minus, own, strict=True))
        return a, d, c, q

    @property
    def static_limits(self) -> tuple[float, float]:
        """Static limits R(0) (minus, plus)."""
        return self.minus[0] + self.minus[2], self.plus[0] + self.plus[2]

    @property
    def kinks(self) -> tuple[None, None]:
        """None: the branches are smooth."""
        return None, None

    def _minus(self, u: Floats) -> Floats:
        return _hyperbola(u, *self.minus)

    def _plus(self, u: Floats) -> Floats:
        return _hyperbola(u, *self.plus)

    def branch(self, direction: Direction) -> LawBranch:
        """Return the smooth branch for slip with the sign `direction`."""
        a, d, c, q = self.plus if direction > 0 else self.minus
        return LawBranch(a + c, lambda u: a / (1 + d * u) + c + q * u * u)


LAW = HyperbolicFriction


def _hyperbola(u: Floats, scale: float, decay: float, constant: float, quadratic: float) -> Floats:
    return np.asarray(scale / (1 + decay * u) + constant + quadratic * u * u)


def _negative_from(scale: float, decay: float, constant: float, quadratic: float) -> float | None:
    """Return the speed from which R < 0, or None.

    There (1 + d u) R = q d u^3 + q u^2 + c d u + scale + c, which has the sign of R, passes through 0.
    """
    coefficients = np.array([quadratic * decay, quadratic, constant * decay, scale + constant])
    if np.all(coefficients >= 0):
        return None
    size = scale + abs(constant)
    roots = np.roots(coefficients)
    crossings = sorted(float(r.real) for r in roots if abs(r.imag) < 1e-9 * abs(r) and r.real > 0)
    edges = [0.0, *crossings]
    between = [0.5 * (a + b) for a, b in pairwise(edges)] + [2 * edges[-1] + 1]
    for start, inside in zip(edges, between, strict=True):
        if np.polyval(coefficients, inside) < -1e-12 * size * (1 + decay * inside):
            return start
    return 0.0 if scale + constant < 0 else None
