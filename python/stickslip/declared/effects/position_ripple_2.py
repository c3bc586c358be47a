"""A second wave of the load along the track: a screw with several ripples has one wavelength each."""

from dataclasses import replace

from stickslip.declared.effects.position_ripple import EFFECT as FIRST

EFFECT = replace(
    FIRST,
    name="position_ripple_2",
    words="a second wave of the load along the track",
    on_slider=110,
    drawn={"a": 4.0, "L": 0.02, "phi": 0.0},
)
