"""Friction that rises at low speed and levels off."""

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import FORCE, SPEED
from stickslip.declared.effect_kind import EffectKind, free, positive
from stickslip.declared.effect_terms import Adds, Numbers, Value


def peak(p: Numbers, u: Value) -> Value:
    """What R(u) has more."""
    return -p["dT"] * np.expm1(-u / p["v_s"])


EFFECT = EffectKind(
    "viscous_saturation",
    "contact",
    "T plus dT (1 - exp(-u/v_s)): friction that rises at low speed and levels off",
    words="friction that rises at low speed and levels off",
    parameters=(
        free("dT", "rise", FORCE),
        positive("v_s", "speed of the rise", SPEED),
    ),
    depends_on=("v_w",),
    on_slider=50,
    adds=Adds(peak=peak),
    drawn={"dT": 12.0, "v_s": 0.02},
    anywhere=Acts(peak="dT*(1 - exp(-u/v_s))"),
)
