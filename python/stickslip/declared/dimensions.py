"""What a number of the model measures: exponents of the rig's scales, and the SI units that they make."""

from __future__ import annotations

from collections.abc import Mapping

# exponents of (length, omega, k2): value in SI = value * length^a omega^b k2^c
Dimension = tuple[int, int, int]
NUMBER: Dimension = (0, 0, 0)
TIME, RATE = (0, -1, 0), (0, 1, 0)
LENGTH, SPEED = (1, 0, 0), (1, 1, 0)
FORCE, STIFFNESS, DAMPING = (1, 0, 1), (0, 0, 1), (0, -1, 1)
QUADRATIC_DAMPING, CUBIC_STIFFNESS = (-1, -2, 1), (-2, 0, 1)
PER_LENGTH, PER_FORCE, PER_SPEED = (-1, 0, 0), (-1, 0, -1), (-1, -1, 0)
FORCE_RATE, SPEED_BY_FORCE = (1, 1, 1), (0, 1, -1)

UNITS: Mapping[Dimension, str] = {
    NUMBER: "1",
    TIME: "s",
    RATE: "1/s",  # of a growth; angular frequencies are in rad/s
    LENGTH: "m",
    SPEED: "m/s",
    FORCE: "N",
    STIFFNESS: "N/m",
    DAMPING: "N s/m",
    QUADRATIC_DAMPING: "N s^2/m^2",
    CUBIC_STIFFNESS: "N/m^3",
    SPEED_BY_FORCE: "m/(N s)",
    PER_LENGTH: "1/m",
    PER_FORCE: "1/N",
    PER_SPEED: "s/m",
    FORCE_RATE: "N/s",
}
