"""A delay of the y1 reading against x1."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import TIME
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "sensor_delay",
    "y1 channel",
    "reading late against x1",
    words="a delay of the y1 reading against x1",
    parameters=(free("delay", "time by which y1 is late", TIME, 1.0),),
    depends_on=("y1", "memory"),
    two_degree=True,
    on_belt=200,
    scored_at={"delay": 0.0},
    drawn={"delay": 0.4},
    anywhere=Acts(refused="a reading of the past is no formula; sensor_lag acts there"),
)
