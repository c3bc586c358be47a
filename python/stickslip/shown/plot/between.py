"""Curves between the samples of a simulation, which are few where the integrator's own steps are all there is."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.simulated.trajectory import Trajectory

Floats = NDArray[np.float64]
ENOUGH = 2000  # samples of a run that make a curve by themselves


def own_steps(run: Trajectory) -> bool:
    """Say whether samples are no farther apart than the integrator's steps: what lies between others is not known."""
    return len(run.t) > run.steps


def between(t: Floats, q: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
    """
    Return times, positions and velocities with as many in between as a curve takes.

    The cubic that has both positions and both velocities: its own velocity is continuous, and its integral right.

    Parameters
    ----------
    t : (n,) increasing times; of two that are the same the later one counts
    q, v : (n, k) positions and velocities
    """
    kept = np.append(np.diff(t) > 0, True)
    t, q, v = t[kept], q[kept], v[kept]
    each = -(-(ENOUGH - 1) // max(len(t) - 1, 1))
    if each < 2 or len(t) < 2:
        return t, q, v
    inner = np.arange(each) / each
    times = np.append((t[:-1, None] + np.diff(t)[:, None] * inner).ravel(), t[-1])
    curve = scipy.interpolate.CubicHermiteSpline(t, q, v)
    return times, curve(times), curve(times, 1)
