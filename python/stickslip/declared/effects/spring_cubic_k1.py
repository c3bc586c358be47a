"""A spring k1 that stiffens (or softens) with the cube of its deflection."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import CUBIC_STIFFNESS
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the block."""
    return -p["k"] * at.x1**3


EFFECT = EffectKind(
    "spring_cubic_k1",
    "block",
    "-k x1^3",
    words="a spring k1 that stiffens (or softens) with the cube of its deflection",
    parameters=(free("k", "cubic stiffness", CUBIC_STIFFNESS, 200.0),),
    depends_on=("x1",),
    on_belt=30,
    scored_at={"k": 0.0},
    adds=Adds(block=force),
    drawn={"k": 8.0},
    anywhere=Acts(force="-k*deflection**3"),
)
