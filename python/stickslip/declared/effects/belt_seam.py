"""A seam of the belt that comes round: friction varies along the belt."""

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import LENGTH
from stickslip.declared.effect_kind import PHASE, EffectKind, Wave, amplitude, positive
from stickslip.declared.effect_terms import Adds, At, Behaves, Numbers, Value


def share(p: Numbers, at: At) -> Value:
    """Share of friction."""
    travel = 2 * np.pi * (at.belt_speed * at.t - at.x1) / p["L"]
    return p["a"] * np.sin(travel + p["phi"])


def period(p: Numbers, belt_speed: float) -> float | None:
    """One turn of the belt."""
    return p["L"] / abs(belt_speed) if p["a"] != 0 and belt_speed != 0 else None


EFFECT = EffectKind(
    "belt_seam",
    "contact",
    "friction times 1 + a sin(2 pi (v_b t - x1)/L + phi)",
    words="a seam of the belt that comes round: friction varies along the belt",
    parameters=(
        amplitude(1.0),
        positive("L", "length of the belt", LENGTH, (0.1, 60.0)),
        PHASE,
    ),
    depends_on=("x1", "t"),
    on_belt=150,
    wave=Wave("L", along_belt=True, largest=0.5),
    adds=Adds(friction=share),
    behaves=Behaves(period=period),
    drawn={"a": 0.1, "L": 2.0, "phi": 0.1},
    anywhere=Acts(factor="1 + a*sin(2*pi*travel/L + phi)"),
)
