"""Friction that falls from a static to a Coulomb level, and rises again with the speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from stickslip.arguments import explained
from stickslip.declared.dimensions import DAMPING, FORCE, NUMBER, SPEED, Dimension
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.friction_law import check_numbers
from stickslip.declared.law_numbers import Size
from stickslip.errors import InputError


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class StribeckFriction(LawByFormula):
    """R(u) = F_c + (F_s - F_c) exp(-(u/v_s)^delta) + c u, static limit F_s.

    Parameters
    ----------
    F_c, F_s
        Coulomb and static level, 0 <= F_c <= F_s. Numbers may be text with a unit, here and below ("4 N").
    v_s, delta
        Speed and exponent of the fall, positive.
    c
        Viscous friction, not negative.
    F_c_plus, F_s_plus, v_s_plus, delta_plus, c_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds, or F_c exceeds F_s.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.StribeckFriction(F_c="5 N", F_s="8 N", v_s="10 mm/s")
    >>> print(law.magnitude([0.0, 0.01]).round(4))
    [8.     6.1036]
    """

    kind: ClassVar[str] = "stribeck"
    rank: ClassVar[int] = 40
    each_way: ClassVar[tuple[str, ...]] = ("F_c", "F_s", "v_s", "delta", "c")
    dimensions: ClassVar[Mapping[str, Dimension]] = {
        **dict.fromkeys(("F_c", "F_s"), FORCE),
        "v_s": SPEED,
        "delta": NUMBER,
        "c": DAMPING,
    }
    kinetic_text: ClassVar[str | None] = "F_c + (F_s - F_c)*exp(-(u/v_s)**delta) + c*u"
    static_text: ClassVar[str | None] = "F_s"

    F_c: float
    F_s: float
    v_s: float
    delta: float = 1.0
    c: float = 0.0
    F_c_plus: float | None = None
    F_s_plus: float | None = None
    v_s_plus: float | None = None
    delta_plus: float | None = None
    c_plus: float | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            F_c: Size,
            F_s: Size,
            v_s: Size,
            delta: Size = ...,
            c: Size = ...,
            F_c_plus: Size | None = ...,
            F_s_plus: Size | None = ...,
            v_s_plus: Size | None = ...,
            delta_plus: Size | None = ...,
            c_plus: Size | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        not_negative, positive = {"least": 0.0}, {"above": 0.0}
        bounds = {**dict.fromkeys(("F_c", "F_s", "c"), not_negative)}
        check_numbers(self, {**bounds, "v_s": positive, "delta": positive})
        check_levels(self.F_c, self.F_s, self.F_c_plus, self.F_s_plus)


def check_levels(F_c: float, F_s: float, F_c_plus: float | None, F_s_plus: float | None) -> None:
    """Refuse a Coulomb level above the static one, in either direction."""
    plus = (F_c if F_c_plus is None else F_c_plus, F_s if F_s_plus is None else F_s_plus)
    for key, level, limit in (("F_c", F_c, F_s), ("F_c_plus" if F_c_plus is not None else "F_c", *plus)):
        if level > limit:
            words = f"above the static level {limit:g}; kinetic friction must not exceed static friction"
            raise InputError(words, key=key, value=level)


LAW = StribeckFriction
