"""A spring k3 that stiffens (or softens) with the cube of its deflection."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import CUBIC_STIFFNESS
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the angle body."""
    return -p["k"] * at.y1**3


EFFECT = EffectKind(
    "spring_cubic_k3",
    "angle_body",
    "-k y1^3",
    words="a spring k3 that stiffens (or softens) with the cube of its deflection",
    parameters=(free("k", "cubic stiffness", CUBIC_STIFFNESS, 400.0),),
    depends_on=("y1",),
    two_degree=True,
    on_belt=50,
    scored_at={"k": 0.0},
    adds=Adds(angle_body=force),
    drawn={"k": 300.0},
    anywhere=Acts(force="-k*deflection**3"),
)
