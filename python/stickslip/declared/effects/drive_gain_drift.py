"""A drive whose gain drifts within each run."""

from stickslip.declared.acts import DRIVE_ALONE, Acts
from stickslip.declared.dimensions import RATE
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def share(p: Numbers, at: At) -> Value:
    """Share of the drive."""
    return p["r"] * at.t


EFFECT = EffectKind(
    "drive_gain_drift",
    "drive",
    "drive times 1 + r t",
    words="a drive whose gain drifts within each run",
    parameters=(free("r", "relative rate per unit of time", RATE),),
    depends_on=("t",),
    on_slider=160,
    adds=Adds(drive=share),
    drawn={"r": 0.02},
    anywhere=Acts(gain="1 + r*t", refused=DRIVE_ALONE),
)
