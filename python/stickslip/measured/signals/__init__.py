"""Recorded channels: checked, filtered and differentiated, by (3.1) or better.

Times, displacements and speeds may be in any one system of units.

Examples
--------
>>> import numpy as np
>>> from stickslip import signals
>>> t = np.arange(0, 10, 0.01)
>>> x = np.sin(t) + 1e-3 * np.random.default_rng(0).standard_normal(t.size)
>>> signals.check_time_base(t).problems
[]
>>> print(f"noise {signals.noise_std(x):.4f}")
noise 0.0010
"""

from stickslip.measured.signals.belt import BeltSpeed, find_belt_speed
from stickslip.measured.signals.derivatives import Derivatives, derivatives
from stickslip.measured.signals.glitches import Glitches, find_glitches, remove_glitches
from stickslip.measured.signals.lowpass import Lowpassed, lowpass
from stickslip.measured.signals.quality import (
    Clipping,
    Quantisation,
    find_clipping,
    noise_std,
    quantisation,
)
from stickslip.measured.signals.recursion import Differentiator, differentiate, differentiator, first_order
from stickslip.measured.signals.smoother import Smoothed, smooth
from stickslip.measured.signals.timebase import TimeBase, check_time_base

__all__ = [
    "BeltSpeed",
    "Clipping",
    "Derivatives",
    "Differentiator",
    "Glitches",
    "Lowpassed",
    "Quantisation",
    "Smoothed",
    "TimeBase",
    "check_time_base",
    "derivatives",
    "differentiate",
    "differentiator",
    "find_belt_speed",
    "find_clipping",
    "find_glitches",
    "first_order",
    "lowpass",
    "noise_std",
    "quantisation",
    "remove_glitches",
    "smooth",
]
