"""A lag of the x1 sensor."""

from stickslip.declared.effect_kind import EffectKind, time_constant

EFFECT = EffectKind(
    "sensor_lag",
    "x1 channel",
    "first-order lag of the reading",
    words="a lag of the x1 sensor",
    parameters=(time_constant((0.004, 3.0)),),
    depends_on=("x1", "memory"),
    hidden=("m",),
    on_belt=190,
    starts=({"tau": 0.05},),
)
