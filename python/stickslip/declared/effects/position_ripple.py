"""A load that waves along the track."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import FORCE
from stickslip.declared.effect_kind import PHASE, EffectKind, free, wavelength
from stickslip.declared.effect_terms import Adds, wave_of_position

NAMES = ("position_ripple", "position_ripple_2", "position_ripple_3")  # one after the other

EFFECT = EffectKind(
    "position_ripple",
    "block",
    "+a sin(2 pi x1/L + phi)",
    words="a load that waves along the track",
    parameters=(
        free("a", "amplitude", FORCE),
        wavelength(),
        PHASE,
    ),
    depends_on=("x1",),
    on_slider=100,
    adds=Adds(block=wave_of_position),
    drawn={"a": 4.0, "L": 0.04, "phi": 0.0},
    anywhere=Acts(force="a*sin(2*pi*deflection/L + phi)"),
)
