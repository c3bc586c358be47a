"""A seam of the belt that comes round: friction varies along the belt."""

from stickslip.declared.dimensions import LENGTH
from stickslip.declared.effect_kind import PHASE, EffectKind, Wave, amplitude, positive

EFFECT = EffectKind(
    "belt_seam",
    "contact",
    "friction times 1 + a sin(2 pi (v_b t - x1)/L + phi)",
    words="a seam of the belt that comes round: friction varies along the belt",
    parameters=(
        amplitude(1.0),
        positive("L", "length of the belt", LENGTH, (0.1, 60.0)),
        PHASE,
    ),
    depends_on=("x1", "t"),
    on_belt=150,
    wave=Wave("L", along_belt=True, largest=0.5),
)
