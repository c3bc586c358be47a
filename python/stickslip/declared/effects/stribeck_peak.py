"""A peak of friction at low sliding speed."""

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import FORCE, SPEED
from stickslip.declared.effect_kind import EffectKind, free, positive
from stickslip.declared.effect_terms import Adds, Behaves, Numbers, Value
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.lacking_friction import takes_too_much

SPEEDS = np.linspace(0.0, 6.0, 601)  # in widths of the peak


def peak(p: Numbers, u: Value) -> Value:
    """What R(u) has more; u = 0: the static limits."""
    return p["dT"] * np.exp(-((u / p["v_s"]) ** 2))


def drives(p: Numbers, law: FrictionLaw, _: float, __: float) -> str | None:
    """A trough may take more than the static limits, or than R(u)."""
    if p["dT"] >= 0:
        return None
    u, change = SPEEDS * p["v_s"], p["dT"] * np.exp(-(SPEEDS**2))
    lacking = min(law.static_limits) + p["dT"] < 0 or any(
        np.min(law.magnitude(side * u[1:]) + change[1:]) < 0 for side in (-1.0, 1.0)
    )
    return takes_too_much("stribeck_peak", p["dT"], law) if lacking else None


EFFECT = EffectKind(
    "stribeck_peak",
    "contact",
    "R and the static limits plus dT exp(-(u/v_s)^2)",
    words="a peak of friction at low sliding speed",
    parameters=(
        free("dT", "height", FORCE, 5.0, as_named=True),
        positive("v_s", "width in speed", SPEED, (0.003, 0.5)),
    ),
    depends_on=("v_w",),
    on_belt=110,
    on_slider=30,
    starts=({"dT": 0.3, "v_s": 0.02}, {"dT": 0.3, "v_s": 0.07}),
    scored_at={"dT": 0.0, "v_s": 0.03},
    adds=Adds(peak=peak),
    behaves=Behaves(drives=drives),
    drawn={"dT": 0.8, "v_s": 0.03},
    anywhere=Acts(peak="dT*exp(-(u/v_s)**2)"),
)
