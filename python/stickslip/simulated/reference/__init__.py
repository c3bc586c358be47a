"""The yardstick of the tests: the model once more in plain Python, slow and obviously right."""

from stickslip.simulated.reference.bodies import simulate as simulate_bodies
from stickslip.simulated.reference.integrate import Run, readings, simulate

__all__ = ["Run", "readings", "simulate", "simulate_bodies"]
