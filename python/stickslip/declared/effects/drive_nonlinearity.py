"""A drive whose gain changes with the force."""

from stickslip.declared.dimensions import PER_FORCE
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "drive_nonlinearity",
    "drive",
    "drive times 1 + q abs(F)",
    words="a drive whose gain changes with the force",
    parameters=(free("q", "relative rate per unit of force", PER_FORCE),),
    depends_on=("F",),
    on_slider=170,
)
