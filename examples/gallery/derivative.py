"""How the motion depends on the static limit.

The derivative of the displacement with respect to the static limit goes through every transition between stick and
slip, whose instants move too. The dashed line is a central difference.
"""

import numpy as np
from matplotlib.figure import Figure

import stickslip as ss

rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
model = ss.Model(rig, friction=ss.PaperFriction())
t = np.linspace(0, 40, 2001)
motion = {"belt_speed": 0.1, "initial": (0.1, 0.1, 0, 0), "t_end": 40, "t_eval": t}
run = ss.simulate(model, sensitivity=("T_s_minus",), **motion)
step = 1e-5
up, down = (ss.simulate(model.replace(T_s_minus=5.94 + s), **motion).state[:, 0] for s in (step, -step))
difference = (up - down) / (2 * step)
print(f"largest difference between the two: {np.abs(run.sensitivity[:, 0, 0] - difference).max():.0e}")

figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axis = figure.subplots()
axis.plot(t, run.sensitivity[:, 0, 0], lw=1.4, label="through every transition")
axis.plot(t, difference, "--", lw=1.0, label="central difference")
axis.set_xlabel("$t$")
axis.set_ylabel(r"$\partial x_1 / \partial T_s$")
axis.legend(frameon=False)
