"""Crosstalk: the x1 sensor also reads y1."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import NUMBER
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "sensor_crosstalk",
    "x1 channel",
    "reads x1 + c y1",
    words="crosstalk: the x1 sensor also reads y1",
    parameters=(free("c", "share of y1", NUMBER, 1.0),),
    depends_on=("x1", "y1"),
    two_degree=True,
    on_belt=210,
    scored_at={"c": 0.0},
    drawn={"c": 0.2},
    anywhere=Acts(reading="reading + c*other"),
)
