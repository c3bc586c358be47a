"""A curve as a term of a hypothesis: a force, a factor of friction, or what is added to a reading, its values free."""

from __future__ import annotations

import math

from stickslip.declared.acts import Acts
from stickslip.declared.effect import Tabulated
from stickslip.declared.effect_kind import EffectKind, ParameterInfo
from stickslip.discovery.laboratory.hypothesis import Term


def curve_term(curve: Tabulated, width: float = math.inf, held: str | None = None) -> Term:
    """
    Return a curve as a term.

    Parameters
    ----------
    curve : with the values that a fit starts from
    width : standard deviation of the prior of each value about 0, in the unit of the values
    held : name of a value that stays where it is, where the law has a level of its own
    """
    names = [name for name in curve.parameters if name != held]
    numbers = tuple(ParameterInfo(name, "value at a knot", spread=width) for name in names)
    kind = EffectKind(
        curve.name,
        curve.where,  # type: ignore[arg-type]  # a place of effects
        f"g({curve.variable})",
        "a curve",
        numbers,
        (curve.variable,),
        anywhere=Acts(),
        drawn={},
    )
    return Term(curve, (), kind)
