"""A drive whose gain changes with the force."""

import numpy as np

from stickslip.declared.acts import DRIVE_ALONE, Acts
from stickslip.declared.dimensions import PER_FORCE
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Value


def share(p: Numbers, at: At) -> Value:
    """Share of the drive."""
    return p["q"] * np.abs(at.drive)


EFFECT = EffectKind(
    "drive_nonlinearity",
    "drive",
    "drive times 1 + q abs(F)",
    words="a drive whose gain changes with the force",
    parameters=(free("q", "relative rate per unit of force", PER_FORCE),),
    depends_on=("F",),
    on_slider=170,
    adds=Adds(drive=share),
    drawn={"q": 0.003},
    anywhere=Acts(gain="1 + q*abs(F)", refused=DRIVE_ALONE),
)
