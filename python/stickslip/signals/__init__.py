"""Recorded channels: checked, filtered and differentiated, by (3.1) or better."""

from stickslip.signals.derivatives import Derivatives, derivatives
from stickslip.signals.lowpass import Lowpassed, lowpass
from stickslip.signals.quality import (
    Clipping,
    Glitches,
    Quantisation,
    find_clipping,
    find_glitches,
    noise_std,
    quantisation,
    remove_glitches,
)
from stickslip.signals.recursion import Differentiator, differentiate, differentiator, first_order
from stickslip.signals.timebase import TimeBase, check_time_base

__all__ = [
    "Clipping",
    "Derivatives",
    "Differentiator",
    "Glitches",
    "Lowpassed",
    "Quantisation",
    "TimeBase",
    "check_time_base",
    "derivatives",
    "differentiate",
    "differentiator",
    "find_clipping",
    "find_glitches",
    "first_order",
    "lowpass",
    "noise_std",
    "quantisation",
    "remove_glitches",
]
