"""A ripple of the belt speed."""

from stickslip.declared.effect_kind import PHASE, EffectKind, Wave, amplitude, frequency

EFFECT = EffectKind(
    "belt_speed_ripple",
    "belt",
    "belt speed v_b (1 + a sin(w t + phi))",
    words="a ripple of the belt speed",
    parameters=(
        amplitude(1.0),
        frequency(),
        PHASE,
    ),
    depends_on=("t",),
    on_belt=170,
    wave=Wave("w", along_belt=False, largest=0.5),
)
