"""A stop that the angle body meets beyond a gap."""

from stickslip.declared.dimensions import LENGTH, STIFFNESS
from stickslip.declared.effect_kind import EffectKind, not_negative, positive

EFFECT = EffectKind(
    "spring_gap_k3",
    "angle_body",
    "-k (y1 -+ d) beyond |y1| > d",
    words="a stop that the angle body meets beyond a gap",
    parameters=(
        not_negative("k", "stiffness of the stop", STIFFNESS, (0.01, 500.0)),
        positive("d", "half width of the gap", LENGTH, (0.001, 2.0), of_size=True),
    ),
    depends_on=("y1",),
    two_degree=True,
    on_belt=60,
    starts=({"k": 3.0, "d": 0.3}, {"k": 3.0, "d": 0.6}),
)
