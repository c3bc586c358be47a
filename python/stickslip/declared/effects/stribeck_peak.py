"""A peak of friction at low sliding speed."""

from stickslip.declared.dimensions import FORCE, SPEED
from stickslip.declared.effect_kind import EffectKind, free, positive

EFFECT = EffectKind(
    "stribeck_peak",
    "contact",
    "R and the static limits plus dT exp(-(u/v_s)^2)",
    words="a peak of friction at low sliding speed",
    parameters=(
        free("dT", "height", FORCE, 5.0),
        positive("v_s", "width in speed", SPEED, (0.003, 0.5)),
    ),
    depends_on=("v_w",),
    on_belt=110,
    on_slider=30,
    starts=({"dT": 0.3, "v_s": 0.02}, {"dT": 0.3, "v_s": 0.07}),
    scored_at={"dT": 0.0, "v_s": 0.03},
)
