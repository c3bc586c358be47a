"""Friction that drifts within each run."""

from stickslip.declared.dimensions import RATE
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "friction_drift",
    "contact",
    "friction times 1 + r t within each run",
    words="friction that drifts within each run",
    parameters=(free("r", "relative rate", RATE, 0.05),),
    depends_on=("t",),
    on_belt=140,
    on_slider=80,
    scored_at={"r": 0.0},
)
