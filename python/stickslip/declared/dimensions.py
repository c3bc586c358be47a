"""What a number measures: exponents of a rig's scales, and the SI unit that they make. The one table of dimensions.

A number of an effect, of a law or of a rig names its dimension beside itself; its value in SI follows from the scales.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Protocol


class _Scales(Protocol):
    """What is 1 in the model, in SI: see `stickslip.declared.rig.Scales`."""

    @property
    def length(self) -> float: ...
    @property
    def omega(self) -> float: ...
    @property
    def k2(self) -> float: ...


@dataclass(frozen=True)
class Dimension:
    """Value in SI = value * length^a omega^b k2^c, in `unit`."""

    a: int
    b: int
    c: int
    unit: str

    def size(self, scales: _Scales) -> float:
        """SI value of 1 in the model's numbers."""
        return float(scales.length**self.a * scales.omega**self.b * scales.k2**self.c)


NUMBER, ANGLE = Dimension(0, 0, 0, "1"), Dimension(0, 0, 0, "rad")
TIME, RATE = Dimension(0, -1, 0, "s"), Dimension(0, 1, 0, "1/s")
ANGULAR_FREQUENCY = Dimension(0, 1, 0, "rad/s")
LENGTH, SPEED = Dimension(1, 0, 0, "m"), Dimension(1, 1, 0, "m/s")
MASS, INERTIA = Dimension(0, -2, 1, "kg"), Dimension(2, -2, 1, "kg m^2")
FORCE, STIFFNESS, DAMPING = (
    Dimension(1, 0, 1, "N"),
    Dimension(0, 0, 1, "N/m"),
    Dimension(0, -1, 1, "N s/m"),
)
QUADRATIC_DAMPING, CUBIC_STIFFNESS = Dimension(-1, -2, 1, "N s^2/m^2"), Dimension(-2, 0, 1, "N/m^3")
PER_LENGTH, PER_FORCE, PER_SPEED = (
    Dimension(-1, 0, 0, "1/m"),
    Dimension(-1, 0, -1, "1/N"),
    Dimension(-1, -1, 0, "s/m"),
)
FORCE_RATE, SPEED_BY_FORCE = Dimension(1, 1, 1, "N/s"), Dimension(0, 1, -1, "m/(N s)")
_WHERE_IT_TURNS = {"N": "N m", "m": "rad", "kg": "kg m^2"}


def turning(unit: str) -> str:
    """Return the unit, of something that turns, of what is in `unit` of something that slides."""
    over, bar, under = (
        re.sub(r"[A-Za-z]+", lambda one: _WHERE_IT_TURNS.get(one[0], one[0]), part)
        for part in unit.partition("/")
    )
    bracket = " " in under and not under.startswith("(")
    return f"{over}{bar}({under})" if bracket else f"{over}{bar}{under}"
