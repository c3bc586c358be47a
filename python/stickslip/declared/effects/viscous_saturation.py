"""Friction that rises at low speed and levels off."""

from stickslip.declared.dimensions import FORCE, SPEED
from stickslip.declared.effect_kind import EffectKind, free, positive

EFFECT = EffectKind(
    "viscous_saturation",
    "contact",
    "T plus dT (1 - exp(-u/v_s)): friction that rises at low speed and levels off",
    words="friction that rises at low speed and levels off",
    parameters=(
        free("dT", "rise", FORCE),
        positive("v_s", "speed of the rise", SPEED),
    ),
    depends_on=("v_w",),
    on_slider=50,
)
