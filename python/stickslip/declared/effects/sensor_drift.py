"""A drift of the x1 sensor within each run."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import SPEED
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "sensor_drift",
    "x1 channel",
    "reads x1 + r t within each run",
    words="a drift of the x1 sensor within each run",
    parameters=(free("r", "rate", SPEED, 0.05),),
    depends_on=("t",),
    on_belt=230,
    scored_at={"r": 0.0},
    drawn={"r": 0.001},
    anywhere=Acts(reading="reading + r*t"),
)
