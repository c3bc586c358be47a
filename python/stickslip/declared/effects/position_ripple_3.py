"""A third wave of the load along the track: a screw with several ripples has one wavelength each."""

from dataclasses import replace

from stickslip.declared.effects.position_ripple import EFFECT as FIRST

EFFECT = replace(
    FIRST,
    name="position_ripple_3",
    words="a third wave of the load along the track",
    on_slider=120,
    drawn={"a": 4.0, "L": 0.08, "phi": 0.0},
)
