"""Steady sliding: the block at rest, the belt slipping under it; or all bodies moving evenly with the drive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.arguments import explained
from stickslip.declared.model import Model
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, StickslipError
from stickslip.objects import Displayed
from stickslip.simulated.orbits.flow import Complexes, Floats, Flow
from stickslip.simulated.orbits.flow_of import flow_of

NEWTON_STEPS = 30


@dataclass(frozen=True, eq=False, repr=False)
class SteadySliding(Displayed):
    """The equilibrium in which the block rests and the belt slides under it, or the drive pulls evenly.

    Attributes
    ----------
    state : (d,)
        The state, with x2 = y2 = 0; of a rig that is driven, the drive at 0.
    eigenvalues : complex
        Of the linearised motion, one for each state that has influence; stable if all real parts are negative.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
    >>> rest = ss.steady_sliding(model, belt_speed=1.0)
    >>> print(f"a disturbance grows as exp({rest.eigenvalues.real.max():.4f} t)")
    a disturbance grows as exp(0.0438 t)
    """

    state: Floats
    eigenvalues: Complexes

    @property
    def stable(self) -> bool:
        """Do small disturbances die out?"""
        return bool(np.all(self.eigenvalues.real < 0))

    @property
    def turning_time(self) -> float:
        """Period in which the leading disturbance turns; infinite if it does not oscillate."""
        speed = abs(float(self.eigenvalues[np.argmax(self.eigenvalues.real)].imag))
        return 2 * np.pi / speed if speed > 0 else np.inf


class NoLimitCycleError(StickslipError):
    """No cycle was found.

    Attributes
    ----------
    equilibrium
        The `SteadySliding` that the motion settles to instead; None where it does not.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
    >>> try:
    ...     ss.limit_cycle(model, belt_speed=2.0)
    ... except ss.NoLimitCycleError as error:
    ...     print(error.equilibrium.stable)
    True
    """

    def __init__(self, what: str, equilibrium: SteadySliding | None = None) -> None:
        self.equilibrium = equilibrium
        super().__init__(what)


@explained
def steady_sliding(
    model: Model,
    belt_speed: float | str | Speed | None = None,
    guess: ArrayLike | None = None,
    *,
    drive_speed: float | str | Speed | None = None,
) -> SteadySliding:
    """Find the equilibrium in which every contact slides evenly, and its eigenvalues.

    Parameters
    ----------
    model, belt_speed
        The rig on its belt, which moves evenly; left out where nothing rubs on one.
    guess
        State (d,) to start Newton's method from; the origin if absent. Its speeds count for what no spring holds alone.
    drive_speed
        Speed of the drive that pulls at links of a rig of bodies.

    Returns
    -------
    SteadySliding
        The state (d,) and the eigenvalues of the motion near it.

    Raises
    ------
    NoLimitCycleError
        Newton's method does not converge to a point at which the block slips.
    InputError
        The belt stands still, a contact does not slide, or the model depends on time.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
    >>> rest = ss.steady_sliding(model, belt_speed=2.0)
    >>> print(f"x1 = {rest.state[0]:.4f}, stable: {rest.stable}")
    x1 = 0.1429, stable: True
    """
    flow = flow_of(model, belt_speed, drive_speed)
    if flow.forcing_period is not None:
        raise InputError("the model depends on time: it has no equilibrium")
    return equilibrium(flow, flow.state(guess, "guess"))


def equilibrium(flow: Flow, guess: Floats) -> SteadySliding:
    """Solve for the state by Newton's method; the eigenvalues are those of the last step."""
    z, size, last = flow.in_steady_sliding(guess), flow.size, np.inf
    for _ in range(NEWTON_STEPS):
        near = flow.linear(z)
        closing = near.closing * size / size[:, None]
        change = np.linalg.lstsq(closing, near.gap / size, rcond=1e-13)[0]
        z = z - size * change
        far = float(np.abs(change).max()) / max(1.0, float(np.abs(z / size).max()))
        if far < 1e-13 or (far < 1e-9 and far >= 0.5 * last):  # as far as it goes
            break
        last = far
    else:
        raise NoLimitCycleError("neither a cycle nor steady sliding found")
    return SteadySliding(
        z, np.asarray(near.eigenvalues[np.argsort(-near.eigenvalues.real)], dtype=np.complex128)
    )
