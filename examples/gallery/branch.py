"""Sliding and stick-slip, both stable.

Leine's damped block over the belt's speed. The branch of cycles turns round where it loses its stick, and ends,
unstable, where steady sliding loses its stability. Between these two speeds, the dotted lines, the start decides.
"""

from matplotlib.figure import Figure

import stickslip as ss

leine = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
branch = ss.continuation(leine, 2.0, parameter="belt_speed", span=(0.5, 3.5), guess=(3.0, 0.0))
for point in branch.special:
    print(f"{point.kind} at {point.value:.6f}")
print(f"Hopf, in closed form: {(30**0.5 - 1) / 3:.6f}")

figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axis = figure.subplots()
axis.plot(branch.values, branch.period, lw=1.2)
for point in branch.special:
    axis.axvline(point.value, color="0.6", lw=0.8, ls=":")
axis.set_xlabel("belt speed")
axis.set_ylabel("period of the cycle")
