"""A ripple of the belt speed."""

import math

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.effect_kind import PHASE, EffectKind, Wave, amplitude, frequency
from stickslip.declared.effect_terms import Adds, At, Behaves, Numbers, Value


def share(p: Numbers, at: At) -> Value:
    """Share of the belt's speed."""
    return p["a"] * np.sin(p["w"] * at.t + p["phi"])


def rate(p: Numbers, at: At) -> Value:
    """Rate of the belt's speed."""
    return at.belt_speed * p["a"] * p["w"] * np.cos(p["w"] * at.t + p["phi"])


def period(p: Numbers, _: float) -> float | None:
    """One turn of the angular frequency."""
    return 2 * math.pi / abs(p["w"]) if p["a"] != 0 and p["w"] != 0 else None


EFFECT = EffectKind(
    "belt_speed_ripple",
    "belt",
    "belt speed v_b (1 + a sin(w t + phi))",
    words="a ripple of the belt speed",
    parameters=(
        amplitude(1.0),
        frequency(),
        PHASE,
    ),
    depends_on=("t",),
    on_belt=170,
    wave=Wave("w", along_belt=False, largest=0.5),
    adds=Adds(belt_share=share, belt_rate=rate),
    behaves=Behaves(period=period),
    drawn={"a": 0.15, "w": 4.0, "phi": 0.2},
    anywhere=Acts(factor="1 + a*sin(w*t + phi)", of_belt=True),
)
