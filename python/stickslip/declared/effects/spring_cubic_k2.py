"""A spring k2 that stiffens (or softens) with the cube of its deflection."""

from stickslip.declared.dimensions import CUBIC_STIFFNESS
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "spring_cubic_k2",
    "both",
    "-k (x1+y1)^3 on each",
    words="a spring k2 that stiffens (or softens) with the cube of its deflection",
    parameters=(free("k", "cubic stiffness", CUBIC_STIFFNESS, 200.0),),
    depends_on=("x1", "y1"),
    two_degree=True,
    on_belt=40,
    scored_at={"k": 0.0},
)
