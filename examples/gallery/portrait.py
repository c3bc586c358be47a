"""The portrait of the paper's rig.

The block rides the belt, breaks away at the static limit and slips back. Fig. 4 of Awrejcewicz and Olejnik (2007), with
illustrative parameters: the paper publishes none.
"""

from matplotlib.figure import Figure

import stickslip as ss

rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
model = ss.Model(rig, friction=ss.PaperFriction())
run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=120)
cycle = ss.limit_cycle(model, belt_speed=0.1)
print(
    f"{len(run.transitions)} transitions; the cycle has the period {cycle.period:.6f}, stable: {cycle.stable}"
)

figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axis = figure.subplots()
axis.plot(run.state[:, 0], run.state[:, 1], lw=0.9)
axis.plot(run.transitions.state[:, 0], run.transitions.state[:, 1], "o", ms=3, label="stick begins or ends")
axis.set_xlabel("$x_1$")
axis.set_ylabel("$x_2$")
axis.legend(frameon=False)
