"""Steady sliding: the block at rest, the belt slipping under it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained
from stickslip.declared.model import Model
from stickslip.errors import InputError, StickslipError, number
from stickslip.objects import Displayed
from stickslip.simulated.orbits.flow import Contact, Floats, Flow

Complexes = NDArray[np.complex128]

NEWTON_STEPS = 30


@dataclass(frozen=True, eq=False, repr=False)
class SteadySliding(Displayed):
    """The equilibrium in which the block rests and the belt slides under it.

    Attributes
    ----------
    state : (d,)
        The state, with x2 = y2 = 0.
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
def steady_sliding(model: Model, belt_speed: float, guess: ArrayLike | None = None) -> SteadySliding:
    """Find the equilibrium with the belt sliding under the block, and its eigenvalues.

    Parameters
    ----------
    model, belt_speed
        The rig on its belt; autonomous, the belt moving.
    guess
        State (d,) to start Newton's method from; the origin if absent.

    Returns
    -------
    SteadySliding
        The state (d,) and the eigenvalues of the motion near it.

    Raises
    ------
    NoLimitCycleError
        Newton's method does not converge to a point at which the block slips.
    InputError
        The belt stands still, or the model depends on time.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
    >>> rest = ss.steady_sliding(model, belt_speed=2.0)
    >>> print(f"x1 = {rest.state[0]:.4f}, stable: {rest.stable}")
    x1 = 0.1429, stable: True
    """
    flow = Flow(model, number("belt_speed", belt_speed))
    if flow.belt_speed == 0:
        raise InputError("steady sliding needs a moving belt", key="belt_speed", value=0.0)
    if flow.forcing_period is not None:
        raise InputError("the model depends on time: it has no equilibrium")
    return equilibrium(flow, flow.state(guess, "guess"))


def equilibrium(flow: Flow, guess: Floats) -> SteadySliding:
    """Solve phi(h, z) = z for a state at which the block slips; the flow's eigenvalues give the motion's."""
    span = 0.25 * flow.natural_time
    contact: Contact = "slip-" if flow.belt_speed > 0 else "slip+"
    z, names, size = guess.copy(), flow.states, flow.size
    for name in ("x2", "y2"):
        if name in names:
            z[names.index(name)] = 0.0
    for _ in range(NEWTON_STEPS):
        arc = flow.arc(z, span, contact=contact)
        gap, closing = (arc.end - arc.start) / size, arc.monodromy * size / size[:, None] - np.eye(len(z))
        z = z - size * np.linalg.lstsq(closing, gap, rcond=1e-13)[0]
        if np.abs(gap).max() < 1e-13 * max(1.0, float(np.abs(z / size).max())):
            break
    else:
        raise NoLimitCycleError("neither a cycle nor steady sliding found")
    kept = ~flow.idle(arc.monodromy)
    values = np.log(np.linalg.eigvals(arc.monodromy[np.ix_(kept, kept)]).astype(np.complex128)) / span
    return SteadySliding(z, np.asarray(values[np.argsort(-values.real)], dtype=np.complex128))
