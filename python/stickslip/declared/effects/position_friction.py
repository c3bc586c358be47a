"""Friction that grows along the track."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import PER_LENGTH
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def share(p: Numbers, at: At) -> Value:
    """Share of friction."""
    return p["r"] * at.x1


EFFECT = EffectKind(
    "position_friction",
    "contact",
    "friction times 1 + r x1",
    words="friction that grows along the track",
    parameters=(free("r", "relative rate per unit of x1", PER_LENGTH),),
    depends_on=("x1",),
    on_slider=70,
    adds=Adds(friction=share),
    drawn={"r": 1.5},
    anywhere=Acts(factor="1 + r*position"),
)
