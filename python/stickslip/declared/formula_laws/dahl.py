"""Bristles that bend under a constant level: Dahl."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from stickslip.arguments import explained
from stickslip.declared.dimensions import FORCE, LENGTH, STIFFNESS, Dimension
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.friction_law import check_numbers
from stickslip.declared.law_numbers import Size


@explained
@dataclass(frozen=True, kw_only=True, repr=False)
class DahlFriction(LawByFormula):
    """T = sigma0 z, z' = v (1 - sigma0 z sgn(v)/F_c). There is no stick; z is 0 at first unless it is given.

    P. R. Dahl, A solid friction model, Aerospace Corporation TOR-158(3107-18) (1968).

    Parameters
    ----------
    sigma0, F_c
        Stiffness of the bristles and Coulomb level, positive.
    sigma0_plus, F_c_plus
        For v_w > 0; None: the same as for v_w < 0.

    Raises
    ------
    InputError
        A number is not finite or not positive.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.DahlFriction(sigma0=1e4, F_c=5)  # N/m, N
    >>> model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=100, damping=20), friction=law)
    >>> run = ss.simulate(model, belt_speed=0.01, t_end=20, atol=1e-12)
    >>> print(f"{100 * run.x1[-1]:.4f} N")  # of the spring in steady sliding: F_c
    5.0000 N
    """

    kind: ClassVar[str] = "dahl"
    rank: ClassVar[int] = 70
    each_way: ClassVar[tuple[str, ...]] = ("sigma0", "F_c")
    dimensions: ClassVar[Mapping[str, Dimension]] = {"sigma0": STIFFNESS, "F_c": FORCE}
    force_text: ClassVar[str | None] = "sigma0*z"
    state_texts: ClassVar[Mapping[str, tuple[str, str, Dimension]]] = {
        "z": ("v - sigma0*u*z/F_c", "0", LENGTH)
    }

    sigma0: float
    F_c: float
    sigma0_plus: float | None = None
    F_c_plus: float | None = None

    if TYPE_CHECKING:

        def __init__(
            self, *, sigma0: Size, F_c: Size, sigma0_plus: Size | None = ..., F_c_plus: Size | None = ...
        ) -> None: ...

    def __post_init__(self) -> None:
        check_numbers(self, {key: {"above": 0.0} for key in ("sigma0", "F_c")})


LAW = DahlFriction
