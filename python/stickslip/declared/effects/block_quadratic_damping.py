"""Damping of the block that grows with the square of its velocity."""

from collections.abc import Callable

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import QUADRATIC_DAMPING
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Sides, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the block, with the sign of x2 frozen."""
    return -p["c"] * at.sides["block_quadratic_damping"] * at.x2 * at.x2


def sign(_: Numbers, at: At) -> Value:
    """Sign of x2."""
    return np.where(at.x2 < 0, -1, 1)


def ends(_: Numbers, side: int) -> dict[str, tuple[Callable[[At], Value], int]]:
    """It turns where x2 does."""
    return {"drag": (lambda at: -side * at.x2, -side)}


EFFECT = EffectKind(
    "block_quadratic_damping",
    "block",
    "-c x2 |x2|",
    words="damping of the block that grows with the square of its velocity",
    parameters=(free("c", "damping", QUADRATIC_DAMPING, 50.0, as_named=True),),
    depends_on=("x2",),
    on_belt=20,
    on_slider=20,
    scored_at={"c": 0.0},
    adds=Adds(block=force, sides=Sides(sign, ends)),
    drawn={"c": 6.0},
    anywhere=Acts(force="-c*deflection_rate*abs(deflection_rate)"),
)
