"""Branches of limit cycles in a parameter, with the bifurcations on the way; `walk` says how."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stickslip.arguments import explained, listed, whole_number
from stickslip.declared.model import Model
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, number, unknown
from stickslip.simulated.orbits.branch import Branch, Trace, branch_of
from stickslip.simulated.orbits.branch_equations import Problem
from stickslip.simulated.orbits.cycle import LimitCycle
from stickslip.simulated.orbits.flow import SPEEDS, Floats, Flow
from stickslip.simulated.orbits.flow_of import flow_of
from stickslip.simulated.orbits.limit_cycle import check_states, limit_cycle
from stickslip.simulated.orbits.steady_sliding import NoLimitCycleError
from stickslip.simulated.orbits.walk import Walk


@explained
def continuation(
    model: Model,
    belt_speed: float | str | Speed | None = None,
    *,
    drive_speed: float | str | Speed | None = None,
    parameter: str = "belt_speed",
    span: tuple[float, float],
    guess: ArrayLike | LimitCycle | None = None,
    step: float = 0.02,
    max_points: int = 500,
    tol: float = 1e-10,
) -> Branch:
    """Trace a branch of limit cycles in a parameter, both ways from where it starts.

    Parameters
    ----------
    model, belt_speed, drive_speed
        The rig and what moves it. The branch starts at its numbers; a speed may be left out where it is the parameter,
        and the branch then starts in the middle of the span.
    parameter
        "belt_speed", "drive_speed" or a name in `model.parameters`.
    span
        Least and greatest value.
    guess
        A cycle to start from, or a state to settle from; at rest at the origin if absent.
    step
        First and greatest step: 1 is the whole span, or a change of the cycle by its own size.
    max_points
        In each direction.
    tol
        Residual of the equations at each point, in the rig's own scale; and relative distance in which special points
        are bracketed.

    Returns
    -------
    Branch

    Raises
    ------
    InputError
        A bad span, a start outside it, an unknown parameter.
    NoLimitCycleError
        There is no cycle to start from.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> branch = ss.continuation(model, 0.1, span=(0.09, 0.11), step=0.5)
    >>> print(f"{branch.values.min():.2f} to {branch.values.max():.2f}, all stable: {branch.stable.all()}")
    0.09 to 0.11, all stable: True
    """
    if len(ends := listed("span", span, "two numbers, the least and the greatest value")) != 2:
        raise InputError("must be two numbers, the least and the greatest value", key="span", value=span)
    low, high = number("span[0]", ends[0]), number("span[1]", ends[1])
    if not low < high:
        raise InputError("must increase", key="span", value=span)
    number("step", step, above=0, most=0.5)
    max_points, tol = whole_number("max_points", max_points), number("tol", tol, above=0, below=1e-2)
    if not isinstance(parameter, str):
        raise InputError("must be the name of a parameter", key="parameter", value=parameter)
    middle = 0.5 * (low + high)
    if parameter == "belt_speed" and belt_speed is None:
        belt_speed = middle
    if parameter == "drive_speed" and drive_speed is None:
        drive_speed = middle
    flow = flow_of(model, belt_speed, drive_speed)
    name, value = _start(flow, parameter, (low, high))
    if isinstance(guess, LimitCycle):
        check_states(guess, flow)
    first = (
        guess
        if isinstance(guess, LimitCycle)
        else limit_cycle(model, belt_speed, guess, drive_speed=drive_speed)
    )
    scale, unit = _scale(flow, first, high - low)
    problem = Problem(flow, name, first.turns, first.contact, scale, unit, tol)
    x = np.concatenate([first.state, [first.period, value]]) / problem.scale
    e = np.zeros(len(x))
    e[-1] = 1.0
    found = problem.correct(x, e)
    if found is None:
        raise NoLimitCycleError("the cycle to start from cannot be corrected; give a nearer guess")
    walk = Walk(problem, (low, high), step, max_points)
    ahead = walk.go(found[0], e)
    alone = Trace([found[0]], [], "closed")
    back = alone if ahead.end == "closed" else walk.go(found[0], -e)
    return branch_of(
        name, problem.cycle, back, alone if back.end == "closed" and back is not alone else ahead
    )


def _start(flow: Flow, parameter: str, span: tuple[float, float]) -> tuple[str, float]:
    """Full name of the parameter, and the value to start at."""
    model, name = flow.model, parameter
    if parameter not in SPEEDS:
        if parameter.startswith("initial."):
            raise unknown("parameter of a branch", parameter, ["belt_speed", *model.parameters])
        name = model.parameter_name(parameter)
        if name not in flow.plain.parameters:
            raise InputError("acts on the reading, not on the motion; no cycle depends on it", key=name)
    value = flow.value_of(name)
    if not span[0] <= value <= span[1]:
        raise InputError(f"the branch starts at {value:g}, outside {span[0]:g} to {span[1]:g}", key=name)
    return name, value


def _scale(flow: Flow, cycle: LimitCycle, width: float) -> tuple[Floats, Floats]:
    """What is 1 of the state, the period and the parameter, and of the residual."""
    size, unit = flow.scales(flow.full(cycle.trajectory(65)))
    return np.concatenate([size, [cycle.period, width]]), unit
