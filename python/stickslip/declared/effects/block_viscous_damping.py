"""Viscous damping of the block."""

from stickslip.declared.dimensions import DAMPING
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "block_viscous_damping",
    "block",
    "-c x2",
    words="viscous damping of the block",
    parameters=(free("c", "damping", DAMPING, 5.0),),
    depends_on=("x2",),
    on_belt=10,
    scored_at={"c": 0.0},
)
