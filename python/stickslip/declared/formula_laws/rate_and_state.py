"""Friction of rock and of much else at low speed: rate and state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, get_args

from stickslip.arguments import explained, one_of
from stickslip.declared.dimensions import FORCE, LENGTH, NUMBER, SPEED, TIME, Dimension
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.friction_law import check_numbers
from stickslip.declared.law_numbers import Size
from stickslip.errors import InputError

StateLaw = Literal["aging", "slip"]
RATES: Mapping[str, str] = {
    "aging": "1 - u*theta/D_c",
    # the 1e-300 makes the product 0 at rest, as its limit is
    "slip": "-(u*theta/D_c)*log(u*theta/D_c + 1e-300)",
}
STEEPEST = 650.0  # mu0/a beyond which the exponential leaves the range of float64


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class RateAndStateFriction(LawByFormula):
    """T = normal a asinh(v/(2 V_0) exp((mu0 + b ln(V_0 theta/D_c))/a)).

    That is normal (mu0 + a ln(u/V_0) + b ln(V_0 theta/D_c)), made smooth at rest: where the logarithm holds the two
    differ by exp(-2 mu/a) (Rice and Ben-Zion, PNAS 93 (1996) 3811). There is no stick: what rests creeps.

    The state theta, the mean age of the contacts, follows theta' = 1 - u theta/D_c ("aging", Dieterich 1979) or
    -(u theta/D_c) ln(u theta/D_c) ("slip", Ruina 1983). It starts steady at the starting speed, D_c/u, unless it is
    given.

    Parameters
    ----------
    mu0
        Coefficient of friction in steady sliding at V_0, positive, at most 650 a.
    a, b
        Direct and evolution effect; positive, and not negative.
    D_c, V_0
        Slip over which the contacts are renewed, and reference speed; positive.
    normal
        Normal force, positive.
    state_law
        "aging" or "slip".
    mu0_plus, a_plus, b_plus, D_c_plus, normal_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> rock = ss.RateAndStateFriction(mu0=0.6, a=0.008, b=0.012, D_c=1e-5, V_0=1e-5, normal=100)
    >>> k = 0.9 * 100 * (0.012 - 0.008) / 1e-5  # N/m, below the critical normal (b - a)/D_c
    >>> slider = ss.Model(ss.BlockOnBelt(mass=1, stiffness=k), friction=rock)
    >>> t, start = np.linspace(0, 30, 3001), (60 / k * 1.0005, 0)
    >>> run = ss.simulate(slider, belt_speed=1e-5, initial=start, t_end=30, t_eval=t, atol=1e-14)
    >>> print(f"{np.ptp(run.x1[2000:]) / np.ptp(run.x1[500:1500]):.1f} times as far as at first")
    1.4 times as far as at first
    """

    kind: ClassVar[str] = "rate_and_state"
    rank: ClassVar[int] = 80
    each_way: ClassVar[tuple[str, ...]] = ("mu0", "a", "b", "D_c", "normal")
    dimensions: ClassVar[Mapping[str, Dimension]] = {
        **dict.fromkeys(("mu0", "a", "b"), NUMBER),
        "D_c": LENGTH,
        "V_0": SPEED,
        "normal": FORCE,
    }
    force_text: ClassVar[str | None] = "normal*a*asinh(v/(2*V_0)*exp((mu0 + b*log(V_0*theta/D_c))/a))"

    mu0: float
    a: float
    b: float
    D_c: float
    V_0: float
    normal: float
    state_law: StateLaw = "aging"
    mu0_plus: float | None = None
    a_plus: float | None = None
    b_plus: float | None = None
    D_c_plus: float | None = None
    normal_plus: float | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            mu0: Size,
            a: Size,
            b: Size,
            D_c: Size,
            V_0: Size,
            normal: Size,
            state_law: StateLaw = ...,
            mu0_plus: Size | None = ...,
            a_plus: Size | None = ...,
            b_plus: Size | None = ...,
            D_c_plus: Size | None = ...,
            normal_plus: Size | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        one_of("state_law", self.state_law, get_args(StateLaw))
        positive = {key: {"above": 0.0} for key in ("mu0", "a", "D_c", "V_0", "normal")}
        check_numbers(self, {**positive, "b": {"least": 0.0}})
        plus = (
            self.mu0 if self.mu0_plus is None else self.mu0_plus,
            self.a if self.a_plus is None else self.a_plus,
        )
        for mu0, a in ((self.mu0, self.a), plus):
            if mu0 > STEEPEST * a:
                words = (
                    f"so small beside mu0 = {mu0:g} that friction at rest is a step; it must be above mu0/650"
                )
                raise InputError(words, key="a", value=a)

    def _texts(self) -> tuple[str | None, str | None, str | None, Mapping[str, tuple[str, str, Dimension]]]:
        return None, None, self.force_text, {"theta": (RATES[self.state_law], "D_c/u", TIME)}


LAW = RateAndStateFriction
