"""A drive whose gain waves along the track."""

from stickslip.declared.acts import DRIVE_ALONE, Acts
from stickslip.declared.effect_kind import PHASE, EffectKind, amplitude, wavelength
from stickslip.declared.effect_terms import Adds, wave_of_position

EFFECT = EffectKind(
    "drive_ripple",
    "drive",
    "drive times 1 + a sin(2 pi x1/L + phi)",
    words="a drive whose gain waves along the track",
    parameters=(
        amplitude(),
        wavelength(),
        PHASE,
    ),
    depends_on=("x1",),
    on_slider=150,
    adds=Adds(drive=wave_of_position),
    drawn={"a": 0.1, "L": 0.04, "phi": 0.0},
    anywhere=Acts(gain="1 + a*sin(2*pi*position/L + phi)", refused=DRIVE_ALONE),
)
