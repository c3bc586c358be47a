"""A constant load on the block."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import FORCE
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def force(p: Numbers, _: At) -> Value:
    """Force on the block."""
    return p["f"]


EFFECT = EffectKind(
    "constant_load",
    "block",
    "+f",
    words="a constant load on the block",
    parameters=(free("f", "force", FORCE, 3.0),),
    depends_on=(),
    on_belt=70,
    both_ways=True,
    adds=Adds(block=force),
    drawn={"f": 0.5},
    anywhere=Acts(force="f"),
)
