"""States that a window begins with and that follow from its numbers and from the readings before it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.signal
from numpy.typing import NDArray

from stickslip.fitted.data import Data
from stickslip.likelihoods.stretches import Stretch
from stickslip.simulated.states import BELT, LAGGED, X1, X2, Y1, Y2, W, Z

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class WindowPasts:
    """
    What the readings tell of the time before windows begin.

    Parameters
    ----------
    read : (w, 2) x1 and y1 where the stick began that each window begins in
    behind : (w, 2) what a lag makes of all readings up to there
    since : (w,) for how long the block has stuck
    """

    read: Floats
    behind: Floats
    since: Floats


DOUBLE = 1e-12  # that two exponentials differ by, where they would be one
DERIVED = (X2, BELT, LAGGED, Z, W)
OF_EFFECTS = {
    BELT: "belt_load_droop.k",
    LAGGED: "sensor_lag.tau",
    Z: "contact_compliance.k",
    W: "friction_memory.tau",
}


def acting(values: Mapping[str, float]) -> list[int]:
    """Return the places in `DERIVED` of the states that a model with these numbers has."""
    return [i for i, state in enumerate(DERIVED) if OF_EFFECTS.get(state) in (None, *values)]


def simple(values: Mapping[str, float]) -> bool:
    """Return whether all that is derived is the speed of a belt that is even."""
    return acting(values) == [0] and "belt_speed_ripple.a" not in values


def lagged(t: Floats, x: Floats, tau: float) -> Floats:
    """
    Return what a first-order lag makes of readings that are straight in between, settled at the first.

    Parameters
    ----------
    t, x : (n,), (n, c) times and readings
    tau : time constant
    """
    step = float(np.median(np.diff(t)))
    grid = np.arange(t[0], t[-1] + step, step)
    a = math.exp(-step / tau)
    share = tau / step * (1.0 - a)
    out = np.empty_like(x)
    for c in range(x.shape[1]):
        even = np.interp(grid, t, x[:, c]) - x[0, c]
        made, _ = scipy.signal.lfilter([1.0 - share, share - a], [1.0, -a], even, zi=np.zeros(1))
        out[:, c] = x[0, c] + np.interp(t, grid, made)
    return out


def past_of(data: Sequence[Data], places: Sequence[Stretch], tau: float) -> WindowPasts:
    """
    Return what the readings tell of a lag before windows begin.

    Parameters
    ----------
    data, places : the runs, and the windows
    tau : time constant of the lag
    """
    runs = np.array([one.run for one in places])
    read, behind = np.zeros((len(places), 2)), np.zeros((len(places), 2))
    for r in np.unique(runs):
        run, here = data[r], np.flatnonzero(runs == r)
        began = [run.t[one.start] - one.dwell for one in places if one.run == r]
        rows = np.searchsorted(run.t, began)
        every = np.zeros((len(run.t), 2))
        every[:, : min(run.readings.shape[1], 2)] = run.readings[:, :2]
        read[here], behind[here] = every[rows], lagged(run.t, every, tau)[rows]
    return WindowPasts(read, behind, np.array([one.dwell for one in places]))


def derived(
    values: Mapping[str, float],
    begun: Floats,
    belt_speed: float | Floats,
    belt: Floats,
    at: Floats,
    past: Callable[[float], WindowPasts],
) -> Floats:
    """
    Return the states of `DERIVED`, (w, 5): speed of what sticks, droop, lagged reading, bristle, lagged slip.

    A belt droops under the force that it has carried: since the block sticks that of the springs, and before what the
    readings tell, inertia included. A bristle carries what bends it. Where a window begins in a slip that is fastest
    there: a lag is behind by its time constant, and a lagged slip is the slip.

    Parameters
    ----------
    values : all numbers by name
    begun : (states, w) the states that are numbers of the windows; x2 is that of a slip, beyond what sticks
    belt_speed : of the run, or (w,)
    belt : (w,) relative speed of each window's own belt
    at : (w,) when the windows begin
    past : of a lag with some time constant
    """
    x1, y1, y2, slip = begun[X1], begun[Y1], begun[Y2], begun[X2]
    mass, stiff = (values.get("alpha1", 0.0) + values.get(name, 0.0) for name in ("mass", "stiffness"))
    mass, stiff = (
        one * (1 + values.get(f"{name}.e", 0.0))
        for name, one in (("rig_mass", mass), ("rig_stiffness", stiff))
    )
    damping = values.get("eta1", values.get("damping", 0.0))
    speed = belt_speed * (1 + belt)
    if "belt_speed_ripple.a" in values:
        a, w, phi = (values[f"belt_speed_ripple.{k}"] for k in ("a", "w", "phi"))
        speed = speed * (1 + a * np.sin(w * at + phi))
    droop = np.zeros(len(belt))
    if "belt_load_droop.k" in values:
        k, tau = values["belt_load_droop.k"], values["belt_load_droop.tau"]
        before = past(tau)
        rate = (before.read - before.behind) / tau
        slow = stiff * before.behind[:, 0] + damping * rate.sum(axis=1) + before.behind[:, 1]
        slow += mass * (speed - rate[:, 0]) / tau
        began = -k * slow / (1 + k * mass / tau)  # the block has the speed of the belt as it is
        held = stiff * x1 + damping * y2 + y1
        droop = _rode(k, tau + k * mass, stiff, damping, speed, speed + began, held, before.since) - speed
        speed = speed + droop
    bristle = np.zeros(len(belt))
    if "contact_compliance.k" in values:
        k, c = values["contact_compliance.k"], values["contact_compliance.c"]
        creep = -(stiff * speed + y2) / k
        bristle = -(stiff * x1 + damping * (speed + y2) + y1 + c * creep) / k
        speed = speed + creep
    tau, c = values.get("sensor_lag.tau", 0.0), values.get("sensor_crosstalk.c", 0.0)
    behind_x1 = x1 + c * y1 - tau * (speed + slip + c * y2)
    return np.stack([speed, droop, behind_x1, bristle, slip], axis=1)


def _rode(
    k: float,
    tau: float,
    stiff: float,
    damping: float,
    even: Floats,
    began: Floats,
    held: Floats,
    since: Floats,
) -> Floats:
    """
    Return the speed of a belt that has drooped since a block began to ride it, (w,).

    That speed is u with tau u' = even - u - k F and F' = stiff u + damping u', so that it is a sum of two exponentials.
    How the stick began tells one of them, the force there is now the other.

    Parameters
    ----------
    k, tau : compliance of the belt's drive, and its time constant with what rides the belt
    stiff, damping : of what holds the block
    even, began : (w,) the belt's speed without a load, and where the stick began
    held : (w,) the force that there is now, less that of damping
    since : (w,) how long the block has stuck
    """
    root = np.sqrt(complex((1 + k * damping) ** 2 - 4 * tau * k * stiff) + DOUBLE)
    slow, fast = ((root * sign - 1 - k * damping) / (2 * tau) for sign in (1, -1))
    # back from now to where it began, over what grows fastest on that way
    gone, ratio = np.exp(fast * since), np.exp((fast - slow) * since)
    of_speed, of_slope = (fast * ratio - slow) / (fast - slow), (1 - ratio) / (fast - slow)
    found = (began * gone + of_slope * (k * held - even) / tau) / (
        of_speed - of_slope * (1 + k * damping) / tau
    )
    return np.asarray(found.real)
