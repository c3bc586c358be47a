"""A load that grows with the position, like a spring."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import STIFFNESS
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the slider."""
    return -p["k"] * at.x1


EFFECT = EffectKind(
    "position_load",
    "block",
    "-k x1",
    words="a load that grows with the position, like a spring",
    parameters=(free("k", "stiffness", STIFFNESS),),
    depends_on=("x1",),
    on_slider=60,
    adds=Adds(block=force),
    drawn={"k": 60.0},
    anywhere=Acts(force="-k*deflection"),
)
