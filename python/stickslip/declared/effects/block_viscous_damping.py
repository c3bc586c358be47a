"""Viscous damping of the block."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import DAMPING
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the block."""
    return -p["c"] * at.x2


EFFECT = EffectKind(
    "block_viscous_damping",
    "block",
    "-c x2",
    words="viscous damping of the block",
    parameters=(free("c", "damping", DAMPING, 5.0, as_named=True),),
    depends_on=("x2",),
    on_belt=10,
    scored_at={"c": 0.0},
    adds=Adds(block=force),
    drawn={"c": 1.0},
    anywhere=Acts(force="-c*deflection_rate"),
)
