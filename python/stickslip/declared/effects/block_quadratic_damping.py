"""Damping of the block that grows with the square of its velocity."""

from stickslip.declared.dimensions import QUADRATIC_DAMPING
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "block_quadratic_damping",
    "block",
    "-c x2 |x2|",
    words="damping of the block that grows with the square of its velocity",
    parameters=(free("c", "damping", QUADRATIC_DAMPING, 50.0),),
    depends_on=("x2",),
    on_belt=20,
    on_slider=20,
    scored_at={"c": 0.0},
)
