"""A harmonic force on the block, an outside vibration."""

import math

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import FORCE
from stickslip.declared.effect_kind import PHASE, EffectKind, Wave, free, frequency
from stickslip.declared.effect_terms import Adds, At, Behaves, Numbers, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the block."""
    return p["a"] * np.sin(p["w"] * at.t + p["phi"])


def period(p: Numbers, _: float) -> float | None:
    """One turn of the angular frequency."""
    return 2 * math.pi / abs(p["w"]) if p["a"] != 0 and p["w"] != 0 else None


EFFECT = EffectKind(
    "harmonic_forcing",
    "block",
    "+a sin(w t + phi)",
    words="a harmonic force on the block, an outside vibration",
    parameters=(
        free("a", "force amplitude", FORCE, 3.0),
        frequency(),
        PHASE,
    ),
    depends_on=("t",),
    on_belt=80,
    on_slider=140,
    wave=Wave("w", along_belt=False, largest=3.0),
    adds=Adds(block=force),
    behaves=Behaves(period=period),
    drawn={"a": 0.6, "w": 1.7, "phi": 0.3},
    anywhere=Acts(force="a*sin(w*t + phi)"),
)
