"""A spring k2 that stiffens (or softens) with the cube of its deflection."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import CUBIC_STIFFNESS
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the block, and on the angle body."""
    return -p["k"] * (at.x1 + at.y1) ** 3


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
    adds=Adds(block=force, angle_body=force),
    drawn={"k": 40.0},
    anywhere=Acts(force="-k*deflection**3"),
)
