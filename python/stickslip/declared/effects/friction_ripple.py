"""Friction that waves along the track."""

from stickslip.declared.acts import Acts
from stickslip.declared.effect_kind import PHASE, EffectKind, amplitude, wavelength
from stickslip.declared.effect_terms import Adds, wave_of_position

EFFECT = EffectKind(
    "friction_ripple",
    "contact",
    "friction times 1 + a sin(2 pi x1/L + phi)",
    words="friction that waves along the track",
    parameters=(
        amplitude(),
        wavelength(),
        PHASE,
    ),
    depends_on=("x1",),
    on_slider=130,
    adds=Adds(friction=wave_of_position),
    drawn={"a": 0.15, "L": 0.04, "phi": 0.0},
    anywhere=Acts(factor="1 + a*sin(2*pi*position/L + phi)"),
)
