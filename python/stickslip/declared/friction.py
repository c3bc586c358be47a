"""Friction laws: magnitudes R(u) of the two branches over u = |v_w|, and the static limits.

"minus" is slip with v_w < 0 (a block that breaks away from a belt with v_b > 0), "plus" slip with v_w > 0.
The force in (2.1) is T = sgn(v_w) R(|v_w|), so that T v_w >= 0 always; to a block it carries the belt can
supply -static_plus to static_minus.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained
from stickslip.errors import InputError, number

Floats = NDArray[np.float64]


class _TwoBranches:
    """What the laws share: the branch is chosen by the sign of v_w."""

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


@explained
@dataclass(frozen=True, kw_only=True)
class PaperFriction(_TwoBranches):
    """The two measured branches (4.1), (4.2) with the numbers of Table 1.

    R_minus(u) = max(T_min_minus, T_s_minus - A1 exp(-(|v_w_min| - u)/t1) - A2 exp(-(|v_w_min| - u)/t2))
    R_plus(u)  = max(T_min_plus, T_s_plus - u (T_s_plus - T_min_plus)/v_w_max)

    Parameters
    ----------
    T_s_minus, T_s_plus
        Static limits.
    A1, A2, t1, t2
        Amplitudes (not negative) and decay speeds (positive) of (4.2).
    v_w_min, v_w_max
        Ends of the fitted ranges, negative and positive.
    T_min_minus, T_min_plus
        What the branches hold beyond the fitted range; not negative, not above the static limits.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds.
    """

    kind: ClassVar[str] = "paper"

    T_s_minus: float = 5.94
    A1: float = 3.2345
    A2: float = 2.8736
    t1: float = 0.0342
    t2: float = 0.3053
    v_w_min: float = -0.28
    T_min_minus: float = 1.42
    T_s_plus: float = 3.63
    T_min_plus: float = 0.86
    v_w_max: float = 0.27

    def __post_init__(self) -> None:
        not_negative = ("T_s_minus", "A1", "A2", "T_min_minus", "T_s_plus", "T_min_plus")
        bounds: dict[str, dict[str, float]] = {name: {"least": 0} for name in not_negative}
        bounds |= {"t1": {"above": 0}, "t2": {"above": 0}, "v_w_max": {"above": 0}, "v_w_min": {"below": 0}}
        _check_numbers(self, bounds)
        for side in ("minus", "plus"):
            limit, floor = getattr(self, f"T_s_{side}"), getattr(self, f"T_min_{side}")
            if floor > limit:
                words = f"above the static limit T_s_{side} = {limit:g}; friction must not grow on slipping"
                raise InputError(words, key=f"T_min_{side}", value=floor)

    def _open_minus(self, u: Floats) -> Floats:
        """(4.2) without its floor."""
        left = u + self.v_w_min
        return self.T_s_minus - self.A1 * np.exp(left / self.t1) - self.A2 * np.exp(left / self.t2)

    def _minus(self, u: Floats) -> Floats:
        kink = self.kinks[0]
        if kink is None:
            with np.errstate(over="ignore"):
                return np.maximum(self.T_min_minus, self._open_minus(u))
        inside = self._open_minus(np.minimum(u, kink))  # far beyond the kink the exponentials overflow
        return np.where(u < kink, inside, self.T_min_minus)

    def _plus(self, u: Floats) -> Floats:
        slope = (self.T_s_plus - self.T_min_plus) / self.v_w_max
        return np.maximum(self.T_min_plus, self.T_s_plus - slope * u)

    @property
    def static_limits(self) -> tuple[float, float]:
        """Static limits (minus, plus)."""
        return self.T_s_minus, self.T_s_plus

    @cached_property
    def kinks(self) -> tuple[float | None, float | None]:
        """Speeds u (minus, plus) from which a branch holds its T_min; None where it always or never does."""
        plus = self.v_w_max if self.T_s_plus > self.T_min_plus else None
        return self._kink_minus(), plus

    def _kink_minus(self) -> float | None:
        def above(u: float) -> float:
            with np.errstate(over="ignore"):
                return float(self._open_minus(np.float64(u)) - self.T_min_minus)  # type: ignore[arg-type]

        if above(0.0) <= 0 or (self.A1 == 0 and self.A2 == 0):
            return None
        high = -self.v_w_min
        while above(high) > 0:
            high *= 2
            if high > 1e6:  # amplitudes so small that no speed of this world saturates the branch
                return None
        return float(scipy.optimize.brentq(above, 0.0, high, xtol=1e-16, rtol=4 * np.finfo(float).eps))


@explained
@dataclass(frozen=True, kw_only=True)
class CoulombFriction(_TwoBranches):
    """Coulomb friction: one kinetic magnitude below a static limit.

    Parameters
    ----------
    static, kinetic
        0 <= kinetic <= static; for both directions, or for v_w < 0 where v_w > 0 has a value of its own.
    static_plus, kinetic_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        A number is not finite or negative, or kinetic exceeds static.
    """

    kind: ClassVar[str] = "coulomb"

    static: float = 1.0
    kinetic: float = 0.5
    static_plus: float | None = None
    kinetic_plus: float | None = None

    def __post_init__(self) -> None:
        _check_numbers(self, {field.name: {"least": 0} for field in fields(self)})
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


@explained
@dataclass(frozen=True, kw_only=True)
class HyperbolicFriction(_TwoBranches):
    """R(u) = scale/(1 + decay u) + constant + quadratic u^2, static limit R(0).

    Parameters
    ----------
    scale, decay
        Not negative.
    constant, quadratic
        Such that R stays positive or zero at every speed.
    scale_plus, decay_plus, constant_plus, quadratic_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds, or R turns negative at some speed.
    """

    kind: ClassVar[str] = "hyperbolic"

    scale: float = 1.0
    decay: float = 3.0
    constant: float = 0.0
    quadratic: float = 0.0
    scale_plus: float | None = None
    decay_plus: float | None = None
    constant_plus: float | None = None
    quadratic_plus: float | None = None

    def __post_init__(self) -> None:
        not_negative = ("scale", "decay", "scale_plus", "decay_plus")
        _check_numbers(self, {f.name: {"least": 0} if f.name in not_negative else {} for f in fields(self)})
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


FrictionLaw = PaperFriction | CoulombFriction | HyperbolicFriction
LAWS: dict[str, type[PaperFriction] | type[CoulombFriction] | type[HyperbolicFriction]] = {
    law.kind: law for law in (PaperFriction, CoulombFriction, HyperbolicFriction)
}


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


def _check_numbers(law: FrictionLaw, bounds: dict[str, dict[str, float]]) -> None:
    """Turn every number given to a frozen law into a float within its bounds."""
    for field in fields(law):
        value = getattr(law, field.name)
        if value is None and field.default is None:
            continue
        limits = bounds[field.name]
        checked = number(field.name, value, **limits)  # type: ignore[arg-type]
        object.__setattr__(law, field.name, checked)
