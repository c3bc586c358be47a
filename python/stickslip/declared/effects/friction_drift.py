"""Friction that drifts within each run."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import RATE
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Behaves, Numbers, Value
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.lacking_friction import DRIVES
from stickslip.errors import InputError


def share(p: Numbers, at: At) -> Value:
    """Share of friction."""
    return p["r"] * at.t


def period(p: Numbers, _: float) -> float | None:
    """Return None for no drift; no motion repeats with one."""
    if p["r"] != 0:
        words = "friction that drifts with time repeats no motion; leave it out"
        raise InputError(words, key="friction_drift")
    return None


def drives(p: Numbers, _: FrictionLaw, start: float, end: float) -> str | None:
    """There is a time beyond which nothing is left."""
    r = p["r"]
    if min(1 + r * start, 1 + r * end) >= 0:
        return None
    until = "from" if r < 0 else "until"
    return f"friction_drift.r = {r:g}: 1 + r t is below 0 {until} t = {-1 / r:.4g}; {DRIVES}"


EFFECT = EffectKind(
    "friction_drift",
    "contact",
    "friction times 1 + r t within each run",
    words="friction that drifts within each run",
    parameters=(free("r", "relative rate", RATE, 0.05),),
    depends_on=("t",),
    on_belt=140,
    on_slider=80,
    scored_at={"r": 0.0},
    adds=Adds(friction=share),
    behaves=Behaves(period=period, drives=drives),
    drawn={"r": 0.004},
    anywhere=Acts(factor="1 + r*t"),
)
