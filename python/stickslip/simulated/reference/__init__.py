"""The yardstick of the tests: the model once more in plain Python, slow and obviously right.

Examples
--------
>>> import stickslip as ss
>>> model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1.0, kinetic=0.5))
>>> slow = ss.reference.simulate(model, belt_speed=0.1, initial=(0, 0.1), t_end=20)
>>> core = ss.simulate(model, belt_speed=0.1, initial=(0, 0.1), t_end=20)
>>> [f"{t:.6f}" for t in slow.transitions.t]
['10.000000', '13.536384']
>>> bool(abs(slow.transitions.t - core.transitions.t).max() < 1e-9)
True
"""

from stickslip.simulated.reference.bodies import simulate as simulate_bodies
from stickslip.simulated.reference.integrate import Run, readings, simulate

__all__ = ["Run", "readings", "simulate", "simulate_bodies"]
