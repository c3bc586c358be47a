"""Friction that grows and falls with the normal force from the angle body."""

from stickslip.declared.dimensions import DAMPING, STIFFNESS
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "normal_force_feedback",
    "contact",
    "friction times max(0, 1 + (beta2 y1 + eta2 y2)/T_s), T_s that of T_-",
    words="friction that grows and falls with the normal force from the angle body",
    parameters=(
        free("beta2", "stiffness feedback", STIFFNESS, 20.0),
        free("eta2", "damping feedback", DAMPING, 20.0),
    ),
    depends_on=("y1", "y2"),
    two_degree=True,
    on_belt=100,
    scored_at={"beta2": 0.0, "eta2": 0.0},
)
