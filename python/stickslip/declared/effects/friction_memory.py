"""Friction that lags behind the sliding speed."""

from stickslip.declared.effect_kind import EffectKind, time_constant

EFFECT = EffectKind(
    "friction_memory",
    "contact",
    "R at the lagged speed |w|, tau w' = v - w; w = 0 on sticking",
    words="friction that lags behind the sliding speed",
    parameters=(time_constant((0.004, 2.0)),),
    depends_on=("v_w", "memory"),
    hidden=("w",),
    on_belt=130,
    starts=({"tau": 0.03}, {"tau": 0.2}),
)
