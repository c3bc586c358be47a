"""A viscous damping that differs by direction."""

from stickslip.declared.dimensions import DAMPING
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "viscous_asymmetry",
    "contact",
    "-c abs(x2)",
    words="a viscous damping that differs by direction",
    parameters=(free("c", "half the difference of the dampings", DAMPING),),
    depends_on=("x2",),
    on_slider=10,
)
