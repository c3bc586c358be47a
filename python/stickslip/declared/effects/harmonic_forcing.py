"""A harmonic force on the block, an outside vibration."""

from stickslip.declared.dimensions import FORCE
from stickslip.declared.effect_kind import PHASE, EffectKind, Wave, free, frequency

EFFECT = EffectKind(
    "harmonic_forcing",
    "block",
    "+a sin(w t + phi)",
    words="a harmonic force on the block, an outside vibration",
    parameters=(
        free("a", "force amplitude", FORCE, 3.0),
        frequency(),
        PHASE,
    ),
    depends_on=("t",),
    on_belt=80,
    on_slider=140,
    wave=Wave("w", along_belt=False, largest=3.0),
)
