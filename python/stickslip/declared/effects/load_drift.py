"""A load that drifts within each run."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import FORCE_RATE
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the slider."""
    return p["r"] * at.t


EFFECT = EffectKind(
    "load_drift",
    "block",
    "+r t",
    words="a load that drifts within each run",
    parameters=(free("r", "rate", FORCE_RATE),),
    depends_on=("t",),
    on_slider=90,
    adds=Adds(block=force),
    drawn={"r": 0.8},
    anywhere=Acts(force="r*t"),
)
