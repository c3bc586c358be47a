"""How a limit cycle moves with the model's numbers: the implicit function theorem on its equations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.arguments import explained, must_be, texts
from stickslip.objects import Displayed, one_line
from stickslip.simulated.orbits.branch_equations import Problem
from stickslip.simulated.orbits.cycle import LimitCycle
from stickslip.simulated.orbits.flow import SPEEDS, Floats

SHOWN = 4  # derivatives in one line


@dataclass(frozen=True, eq=False, repr=False)
class CycleSensitivity(Displayed):
    """Derivatives of a limit cycle; printed, those of the period, in one line.

    Attributes
    ----------
    names
        The parameters, in the order asked for.
    period : (p,)
        d period / d parameter.
    state : (d, p)
        d state on the section / d parameter.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> slope = ss.cycle_sensitivity(ss.limit_cycle(model, belt_speed=0.1), ["alpha1", "T_s_minus"])
    >>> slope.names, slope.period.shape, slope.state.shape
    (('alpha1', 'T_s_minus'), (2,), (4, 2))
    """

    names: tuple[str, ...]
    period: Floats
    state: Floats

    def __repr__(self) -> str:
        pairs = list(zip(self.names, self.period, strict=True))
        by = [f"{name} {x:.6g}" for name, x in pairs[:SHOWN]] + ["..."] * (len(pairs) > SHOWN)
        size = f"{len(self.names)} parameters, {len(self.state)} states"
        return one_line(f"<CycleSensitivity: {size}; d period by {', '.join(by) or 'nothing'}>")


@explained
def cycle_sensitivity(cycle: LimitCycle, names: Sequence[str]) -> CycleSensitivity:
    """Differentiate the period and the state of a cycle by parameters.

    With F(z, T, p) = 0 the equations of the cycle, d(z, T)/dp = -F_(z,T)^-1 F_p. At a fold it does not exist.

    Parameters
    ----------
    cycle
        From `limit_cycle`, or a branch's special point.
    names
        "belt_speed", "drive_speed" or names in `model.parameters`.

    Returns
    -------
    CycleSensitivity
        Derivatives of the period (p,) and of the state on the section (d, p), in the model's own units.

    Raises
    ------
    InputError
        An unknown name, with the nearest known one.
    numpy.linalg.LinAlgError
        The cycle is at a fold.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> cycle = ss.limit_cycle(model, belt_speed=0.1)
    >>> slope = ss.cycle_sensitivity(cycle, ["belt_speed"])
    >>> print(f"d period / d belt_speed = {slope.period[0]:.3f}")
    d period / d belt_speed = -35.934
    """
    must_be("cycle", cycle, LimitCycle, "limit_cycle(model, belt_speed) gives one")
    chosen = texts("names", names, "parameter names")
    flow = cycle.flow
    d = len(cycle.state)
    columns = np.empty((d + 1, len(chosen)))
    for k, given in enumerate(chosen):
        name = given if given in SPEEDS else cycle.model.parameter_name(given)
        value = flow.value_of(name)
        problem = Problem(flow, name, cycle.turns, cycle.contact, np.ones(d + 2), np.ones(d), 1e-10)
        jacobian = problem.at(np.concatenate([cycle.state, [cycle.period, value]])).jacobian
        columns[:, k] = -np.linalg.solve(jacobian[:, :-1], jacobian[:, -1])
    return CycleSensitivity(chosen, columns[d], columns[:d])
