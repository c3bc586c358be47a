"""A sensor gain other than the declared one."""

from stickslip.declared.acts import Acts
from stickslip.declared.effect_kind import EffectKind, relative_error

EFFECT = EffectKind(
    "sensor_gain",
    "x1 channel",
    "reads (1 + e) times what it should",
    words="a sensor gain other than the declared one",
    parameters=(relative_error(),),
    depends_on=("x1",),
    on_belt=260,
    corrects="reading",
    drawn={"e": 0.15},
    anywhere=Acts(reading="(1 + e)*reading"),
)
