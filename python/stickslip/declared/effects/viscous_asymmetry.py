"""A viscous damping that differs by direction."""

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import DAMPING
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the slider."""
    return -p["c"] * np.abs(at.x2)


EFFECT = EffectKind(
    "viscous_asymmetry",
    "contact",
    "-c abs(x2)",
    words="a viscous damping that differs by direction",
    parameters=(free("c", "half the difference of the dampings", DAMPING),),
    depends_on=("x2",),
    on_slider=10,
    adds=Adds(block=force),
    drawn={"c": -40.0},
    anywhere=Acts(force="-c*abs(deflection_rate)"),
)
