"""A nonlinear x1 sensor."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import PER_LENGTH
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "sensor_nonlinearity",
    "x1 channel",
    "reads x1 + q x1^2",
    words="a nonlinear x1 sensor",
    parameters=(free("q", "curvature", PER_LENGTH, 3.0),),
    depends_on=("x1",),
    on_belt=220,
    scored_at={"q": 0.0},
    drawn={"q": 0.3},
    anywhere=Acts(reading="reading + q*reading**2"),
)
