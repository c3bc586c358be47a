"""Measured order of convergence, of the steps and of the times of transitions, against theory.

A series of order p leaves out terms of order h^(p+1) a step, so that a motion over a fixed time is off by h^p,
and so is the time at which it meets a surface.
"""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("stickslip._core")
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.simulated.simulate import simulate
from stickslip.simulated.trajectory import Trajectory

RIG = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
BELT = 0.1
LAWS = {
    "exponentials": PaperFriction(t1=0.15, T_min_minus=0.2),
    "rational": HyperbolicFriction(scale=3, decay=3, constant=1, quadratic=0.5),
}
STARTS = [(x1, 0.06, 0.02, y2) for x1 in np.linspace(0.26, 0.32, 8) for y2 in np.linspace(-0.05, 0.05, 6)]
# steps in SPAN, in the range where h^p rules and rounding does not; the exponentials of (4.2) need them short
STEPS = {
    ("exponentials", 4): (32, 48, 64, 96),
    ("exponentials", 6): (64, 80, 96, 128),
    ("exponentials", 5): (64, 80, 96, 128),
    ("rational", 4): (16, 24, 32, 48),
    ("rational", 6): (12, 16, 24, 32),
    ("rational", 8): (16, 20, 24, 28),
}
SPAN = 1.5  # within one slip, on its curved branch
laws_and_orders = pytest.mark.parametrize(("law", "order"), STEPS)


def run(law: str, start: tuple[float, ...], t_end: float, **how: float) -> Trajectory:
    model = Model(RIG, friction=LAWS[law])
    return simulate(model, belt_speed=BELT, initial=start, t_end=t_end, **how)  # type: ignore[arg-type]


def reference(law: str, start: tuple[float, ...], t_end: float) -> Trajectory:
    return run(law, start, t_end, rtol=1e-14, atol=1e-14)


def steps(law: str, order: int) -> list[float]:
    return [SPAN / n for n in STEPS[law, order]]


def measured_order(errors: dict[float, float]) -> float:
    h, e = np.log(list(errors)), np.log(list(errors.values()))
    return float(np.polyfit(h, e, 1)[0])


def root_mean_square(errors: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))


@laws_and_orders
def test_order_of_steps(law: str, order: int) -> None:
    told = [reference(law, start, SPAN) for start in STARTS]
    assert all(len(run.transitions) + len(run.kinks) == 0 for run in told)
    errors = {}
    for h in steps(law, order):
        runs = [run(law, start, SPAN, order=order, step=h) for start in STARTS]
        errors[h] = root_mean_square(
            [float(np.abs(a.state[-1] - b.state[-1]).max()) for a, b in zip(runs, told, strict=True)]
        )
    assert min(errors.values()) > 5e-16  # not yet rounding
    assert measured_order(errors) == pytest.approx(order, abs=0.2)


@laws_and_orders
@pytest.mark.parametrize("locator", ["henon", "bracket"])
def test_order_of_transition_times(law: str, order: int, locator: str) -> None:
    # the end of the slip: caught by the belt, or on to the other side; root mean square over the starts, for the
    # fraction of a step at which a surface is met differs from one to the next
    told = [reference(law, start, 7.0) for start in STARTS]
    assert all(len(run.transitions) > 0 for run in told)
    ends = [float(run.transitions.t[0]) for run in told]
    errors = {}
    for h in steps(law, order):
        runs = [
            run(law, start, end + 0.2, order=order, step=h, locator=locator)
            for start, end in zip(STARTS, ends, strict=True)
        ]
        assert all(len(run.transitions) >= 1 for run in runs)
        errors[h] = root_mean_square(
            [float(a.transitions.t[0] - end) for a, end in zip(runs, ends, strict=True)]
        )
    assert min(errors.values()) > 1e-14
    assert measured_order(errors) == pytest.approx(order, abs=0.2)
