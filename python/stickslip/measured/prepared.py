"""A run as a fit takes it: readings in the rig's units, its modes, and the belt speed to use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stickslip.measured import sticks as segments
from stickslip.measured.fit_window import Array

# times, readings and their noise to the motion behind them and its noise
Motion = Callable[[Array, Array, float], tuple[Array, float]]


@dataclass(frozen=True)
class Measured:
    """One run ready for fitting: readings (n, c) in the rig's units, its modes, the belt speed to use."""

    name: str
    t: Array
    readings: Array
    noise: Array
    belt_speed: float
    set_point: float
    plateau: float
    plateau_std: float
    track: segments.Track
    averaged: int = 1  # readings that each row is the mean of
    motion: Motion | None = None  # what shows where the block sticks, if not the readings themselves
