"""Friction that grows along the track."""

from stickslip.declared.dimensions import PER_LENGTH
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "position_friction",
    "contact",
    "friction times 1 + r x1",
    words="friction that grows along the track",
    parameters=(free("r", "relative rate per unit of x1", PER_LENGTH),),
    depends_on=("x1",),
    on_slider=70,
)
