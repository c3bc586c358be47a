"""Static friction that grows with the time at rest."""

from stickslip.declared.dimensions import FORCE
from stickslip.declared.effect_kind import EffectKind, free, time_constant

EFFECT = EffectKind(
    "static_aging",
    "contact",
    "static limits plus dT (1 - exp(-dwell/tau))",
    words="static friction that grows with the time at rest",
    parameters=(
        free("dT", "growth at long rest", FORCE, 5.0),
        time_constant((0.05, 50.0)),
    ),
    depends_on=("memory",),
    hidden=("dwell",),
    on_belt=120,
    starts=({"dT": 0.3, "tau": 0.5}, {"dT": 0.3, "tau": 2.0}),
    scored_at={"dT": 0.0, "tau": 1.5},
)
