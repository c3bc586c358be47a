"""Dry friction in the pivot of the angle body."""

import math

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import FORCE, SPEED
from stickslip.declared.effect_kind import EffectKind, ParameterInfo, not_negative

EFFECT = EffectKind(
    "pivot_dry_friction",
    "angle_body",
    "-f sgn(y2), sticks at y2 = 0; with a creep speed v_c: -f tanh(y2/v_c)",
    words="dry friction in the pivot of the angle body",
    parameters=(
        not_negative("f", "friction force", FORCE, (0.0001, 5.0)),
        ParameterInfo(
            "v_c",
            "creep speed that rounds the sign; 0: sharp",
            (0.0, math.inf),
            optional=True,
            dimension=SPEED,
            sought=(2e-05, 0.05),
        ),
    ),
    depends_on=("y2",),
    two_degree=True,
    on_belt=90,
    starts=({"f": 0.08}, {"f": 0.08, "v_c": 2e-3}),
    drawn={"f": 0.1, "v_c": 0.0},
    anywhere=Acts(force="-f*tanh(deflection_rate/v_c)", sharp=("v_c", "f")),
)
