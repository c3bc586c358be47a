"""The two measured branches of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import scipy

from stickslip.arguments import explained
from stickslip.declared.dimensions import FORCE, SPEED, Dimension
from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import Name, substituted
from stickslip.declared.friction_law import Direction, Floats, FrictionLaw, LawBranch, Value, check_numbers
from stickslip.declared.law_form import LawForm
from stickslip.declared.law_numbers import Size
from stickslip.errors import InputError


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class PaperFriction(FrictionLaw):
    """The two measured branches (4.1), (4.2) with the numbers of Table 1.

    R_minus(u) = max(T_min_minus, T_s_minus - A1 exp(-(|v_w_min| - u)/t1) - A2 exp(-(|v_w_min| - u)/t2))
    R_plus(u)  = max(T_min_plus, T_s_plus - u (T_s_plus - T_min_plus)/v_w_max)

    Parameters
    ----------
    T_s_minus, T_s_plus
        Static limits. Bare numbers are those of the model; text with a unit ("20 N") is turned into them by the scales
        of the rig of (2.1), here and below.
    A1, A2, t1, t2
        Amplitudes (not negative) and decay speeds (positive) of (4.2).
    v_w_min, v_w_max
        Ends of the fitted ranges, negative and positive.
    T_min_minus, T_min_plus
        What the branches hold beyond the fitted range; not negative, not above the static limits.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds, or its unit is one of something else.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.PaperFriction()
    >>> print(law.magnitude([-0.1, 0.1]).round(4))
    [4.3297 2.6041]
    >>> law.static_limits
    (5.94, 3.63)
    """

    kind: ClassVar[str] = "paper"
    rank: ClassVar[int] = 10
    formula: ClassVar[str] = "(4.1) and (4.2) of the paper, see [model.md](model.md)"
    at_rest: ClassVar[str] = "T_s_minus, T_s_plus"
    equations: ClassVar[tuple[tuple[str, str, str], ...]] = (
        (
            "R_minus",
            "max(T_min_minus, T_s_minus - A1*exp((u + v_w_min)/t1) - A2*exp((u + v_w_min)/t2))",
            "T_s_minus",
        ),
        ("R_plus", "max(T_min_plus, T_s_plus - u*(T_s_plus - T_min_plus)/v_w_max)", "T_s_plus"),
    )
    drawn: ClassVar[Mapping[str, float]] = {"T_s_minus": 5.94, "T_s_plus": 3.63}
    drawn_to: ClassVar[float] = 0.35
    single: ClassVar[tuple[str, ...]] = (
        "T_s_minus",
        "A1",
        "A2",
        "t1",
        "t2",
        "v_w_min",
        "T_min_minus",
        "T_s_plus",
        "T_min_plus",
        "v_w_max",
    )
    dimensions: ClassVar[Mapping[str, Dimension]] = {
        **dict.fromkeys(("T_s_minus", "T_min_minus", "T_s_plus", "T_min_plus", "A1", "A2"), FORCE),
        **dict.fromkeys(("t1", "t2", "v_w_min", "v_w_max"), SPEED),
    }

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

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            T_s_minus: Size = ...,
            A1: Size = ...,
            A2: Size = ...,
            t1: Size = ...,
            t2: Size = ...,
            v_w_min: Size = ...,
            T_min_minus: Size = ...,
            T_s_plus: Size = ...,
            T_min_plus: Size = ...,
            v_w_max: Size = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        not_negative = ("T_s_minus", "A1", "A2", "T_min_minus", "T_s_plus", "T_min_plus")
        bounds: dict[str, dict[str, float]] = {name: {"least": 0} for name in not_negative}
        bounds |= {"t1": {"above": 0}, "t2": {"above": 0}, "v_w_max": {"above": 0}, "v_w_min": {"below": 0}}
        check_numbers(self, bounds)
        for side in ("minus", "plus"):
            if (f"T_s_{side}" in self.declared_units) != (f"T_min_{side}" in self.declared_units):
                continue  # newtons and a number of the model: they are compared in it
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

    def form(self) -> LawForm:
        """Return (4.1) and (4.2) as trees; beyond twice the speed of the floor the exponentials are left alone."""
        form, kink = super().form(), self.kinks[0]
        minus = form.minus.kinetic
        assert minus is not None
        if kink is not None:
            minus = substituted(minus, {"u": parse(f"min(u, {2 * kink!r})")})
        elif float(self.magnitude(-1e-300)) <= self.T_min_minus:
            minus = Name("T_min_minus")
        return replace(form, minus=replace(form.minus, kinetic=minus))

    def branch(self, direction: Direction) -> LawBranch:
        """Return Table 1's branch for slip with the sign `direction`."""
        return _minus(self) if direction < 0 else _plus(self)


LAW = PaperFriction


def _minus(law: PaperFriction) -> LawBranch:
    """T_- of (4.2), read as 0.28 - u, held at T_min_minus once it falls there."""
    end = abs(law.v_w_min)

    def curve(u: Value) -> Value:
        e1, e2 = np.exp(-(end - u) / law.t1), np.exp(-(end - u) / law.t2)
        return law.T_s_minus - law.A1 * e1 - law.A2 * e2

    with np.errstate(over="ignore"):
        high = end
        while curve(high) > law.T_min_minus and high < 1e6:
            high *= 2
        if curve(0.0) <= law.T_min_minus:
            return LawBranch(law.T_s_minus, lambda u: law.T_min_minus + 0 * u)
        if curve(high) > law.T_min_minus:  # amplitudes so small that it never gets there
            return LawBranch(law.T_s_minus, curve)
        kink = float(
            scipy.optimize.brentq(lambda u: curve(u) - law.T_min_minus, 0.0, high, xtol=1e-16, rtol=1e-15)
        )

    def below(u: Value) -> Value:
        # a trial stage far beyond the kink must not meet the exponentials' blow-up
        return curve(np.where(u.real > kink + 0.05, kink + 0.05, u))

    return LawBranch(law.T_s_minus, below, law.T_min_minus, kink)


def _plus(law: PaperFriction) -> LawBranch:
    """T_+ of (4.1), held at T_min_plus beyond the fitted range."""
    slope = (law.T_s_plus - law.T_min_plus) / law.v_w_max
    return LawBranch(law.T_s_plus, lambda u: law.T_s_plus - slope * u, law.T_min_plus, law.v_w_max)
