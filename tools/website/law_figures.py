"""A figure of every friction law: T over v_w, and the loop of a law without stick."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import stickslip as ss
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.laws import ALL_LAWS, LAWS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = (6.4, 3.6)  # inches
BLUE, ORANGE, GREY = "#1f6fb4", "#d1661b", "#888888"
EXAMPLES: Mapping[str, Mapping[str, Any]] = {
    **{kind: law.drawn for kind, law in LAWS.items()},
    "stribeck": {"F_c": "1.2 N", "F_s": "2 N", "v_s": "10 mm/s", "c": "4 N s/m"},
    "tabulated": {"speeds": [0.0, 0.005, 0.02, 0.05], "forces": [1.8, 1.3, 1.1, 1.25], "static": 2.0},
    "lugre": {"sigma0": 1e5, "sigma1": 316.0, "sigma2": 0.4, "F_c": 1.0, "F_s": 1.5, "v_s": 1e-3},
    "dahl": {"sigma0": 1e4, "F_c": 1.0},
    "rate_and_state": {"mu0": 0.6, "a": 0.008, "b": 0.012, "D_c": 1e-5, "V_0": 1e-6, "normal": 100.0},
}
TO_AND_FRO = {  # largest speed [m/s] and period [s]
    "lugre": (6e-3, 0.2),
    "dahl": (4e-3, 0.4),
}
SPAN = {**{kind: law.drawn_to for kind, law in LAWS.items()}, "stribeck": 0.06, "tabulated": 0.06}


def draw(kind: str, path: Path) -> None:
    """Draw a law with the numbers of its example."""
    law = ALL_LAWS[kind](**EXAMPLES[kind])
    if kind in SPAN:
        save(_curve(law, SPAN[kind]), path)
    elif kind in TO_AND_FRO:
        save(_loop(law, *TO_AND_FRO[kind]), path)
    else:
        save(_steps(law), path)


def save(figure: Figure, path: Path) -> None:
    """Write a figure as SVG, the same bytes each time."""
    import matplotlib as mpl

    with mpl.rc_context({"svg.hashsalt": "stickslip", "svg.fonttype": "path"}):
        figure.savefig(path, metadata={"Date": None})


def _curve(law: FrictionLaw, span: float) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    axis = figure.subplots()
    u = np.linspace(span * 1e-6, span, 600)
    for v in (-u, u):
        axis.plot(v, law.force(v), color=BLUE)
    minus, plus = law.static_limits
    axis.plot([0, 0], [-minus, plus], color=ORANGE, lw=2, label="at rest")
    axis.legend(frameon=False)
    _head(axis, "" if law.kind in LAWS else "SI")
    return figure


def _loop(law: FrictionLaw, speed: float, period: float) -> Figure:
    """A light block that a stiff spring and a strong damper hold: they carry the friction, and nothing rings."""
    from matplotlib.figure import Figure

    mass, damping, stiffness, w = 1e-3, 2000.0, 1e6, 2 * np.pi / period
    held = ss.Model(ss.BlockOnBelt(mass=mass, stiffness=stiffness, damping=damping), friction=law)
    t = np.linspace(0, 2 * period, 3001)
    run = ss.simulate(
        held, belt_speed=f"{speed}*cos({w}*t)", initial=(0, 0), t_end=float(t[-1]), t_eval=t, rtol=1e-7
    )
    figure = Figure(figsize=SIZE, layout="constrained")
    axis = figure.subplots()
    x, v = run.state[len(t) // 2 :].T
    axis.plot(v - speed * np.cos(w * t[len(t) // 2 :]), -stiffness * x - damping * v, color=BLUE, lw=1.2)
    _head(axis, "SI")
    return figure


def _steps(law: FrictionLaw) -> Figure:
    """The speed steps up and down, as in a velocity-stepping test of rock."""
    from matplotlib.figure import Figure

    slow, stiffness, level = law.numbers["V_0"], 1e6, law.numbers["mu0"] * law.numbers["normal"]
    up, down, end = 50.0, 60.0, 160.0
    t = np.linspace(0, end, 4001)
    speed = ss.Speed.steps([0, up, down], [slow, 10 * slow, slow])
    held = ss.Model(ss.BlockOnBelt(mass=100.0, stiffness=stiffness, damping=2e4), friction=law)
    run = ss.simulate(held, belt_speed=speed, initial=(level / stiffness, 0), t_end=end, t_eval=t, atol=1e-13)
    slid = slow * (t + 9 * np.clip(t - up, 0, down - up)) - run.state[:, 0] + level / stiffness
    figure = Figure(figsize=SIZE, layout="constrained")
    axis = figure.subplots()
    axis.plot(1e6 * slid, stiffness * run.state[:, 0], color=BLUE, lw=1.2)
    axis.set_xlabel("distance slid [µm]")
    axis.set_ylabel("friction $T$ [N]")
    return figure


def _head(axis: Any, units: str) -> None:
    axis.axhline(0, color=GREY, lw=0.6)
    axis.set_xlabel("sliding velocity $v_w$ [m/s]" if units else "sliding velocity $v_w$")
    axis.set_ylabel("friction $T$ [N]" if units else "friction $T$")
