"""Bristles that bend: LuGre."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from stickslip.arguments import explained
from stickslip.declared.dimensions import DAMPING, FORCE, LENGTH, SPEED, STIFFNESS, Dimension
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.formula_laws.stribeck import check_levels
from stickslip.declared.friction_law import check_numbers
from stickslip.declared.law_numbers import Size


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class LuGreFriction(LawByFormula):
    """T = sigma0 z + sigma1 z' + sigma2 v, z' = v - sigma0 |v| z/g(v), g = F_c + (F_s - F_c) exp(-(v/v_s)^2).

    There is no stick: bristles of deflection z bend instead. z is 0 at first unless it is given. Canudas de Wit,
    Olsson, Astrom and Lischinsky, IEEE Transactions on Automatic Control 40 (1995) 419.

    Parameters
    ----------
    sigma0, sigma1, sigma2
        Stiffness (positive) and damping of the bristles, and viscous friction (not negative).
    F_c, F_s
        Coulomb and static level, 0 < F_c <= F_s.
    v_s
        Stribeck speed, positive.
    sigma0_plus, sigma1_plus, sigma2_plus, F_c_plus, F_s_plus, v_s_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        A number is not finite or out of its bounds, or F_c exceeds F_s.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.LuGreFriction(sigma0=1e5, sigma1=316, sigma2=0.4, F_c=1, F_s=1.5, v_s=1e-3)  # N, m, s
    >>> model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=2), friction=law)
    >>> run = ss.simulate(model, belt_speed=0.1, t_end=20, atol=1e-12)
    >>> print(f"the spring pulls {2 * run.x1.max():.3f} N before the first slip")
    the spring pulls 1.508 N before the first slip
    """

    kind: ClassVar[str] = "lugre"
    rank: ClassVar[int] = 60
    each_way: ClassVar[tuple[str, ...]] = ("sigma0", "sigma1", "sigma2", "F_c", "F_s", "v_s")
    dimensions: ClassVar[Mapping[str, Dimension]] = {
        "sigma0": STIFFNESS,
        **dict.fromkeys(("sigma1", "sigma2"), DAMPING),
        **dict.fromkeys(("F_c", "F_s"), FORCE),
        "v_s": SPEED,
    }
    force_text: ClassVar[str | None] = "sigma0*z + sigma1*z_rate + sigma2*v"
    state_texts: ClassVar[Mapping[str, tuple[str, str, Dimension]]] = {
        "z": ("v - sigma0*u*z/(F_c + (F_s - F_c)*exp(-(v/v_s)**2))", "0", LENGTH)
    }

    sigma0: float
    sigma1: float
    sigma2: float
    F_c: float
    F_s: float
    v_s: float
    sigma0_plus: float | None = None
    sigma1_plus: float | None = None
    sigma2_plus: float | None = None
    F_c_plus: float | None = None
    F_s_plus: float | None = None
    v_s_plus: float | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            sigma0: Size,
            sigma1: Size,
            sigma2: Size,
            F_c: Size,
            F_s: Size,
            v_s: Size,
            sigma0_plus: Size | None = ...,
            sigma1_plus: Size | None = ...,
            sigma2_plus: Size | None = ...,
            F_c_plus: Size | None = ...,
            F_s_plus: Size | None = ...,
            v_s_plus: Size | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        positive, not_negative = {"above": 0.0}, {"least": 0.0}
        bounds = {**dict.fromkeys(("sigma0", "F_c", "F_s", "v_s"), positive)}
        check_numbers(self, {**bounds, **dict.fromkeys(("sigma1", "sigma2"), not_negative)})
        check_levels(self.F_c, self.F_s, self.F_c_plus, self.F_s_plus)


LAW = LuGreFriction
