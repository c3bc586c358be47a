"""States that a window begins with and that follow from its numbers: the block sticks, what lags has settled."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stickslip.simulated.states import BELT, LAGGED, X1, X2, Y1, Y2

Floats = NDArray[np.float64]
DERIVED = (X2, BELT, LAGGED)


def derived(
    values: Mapping[str, float], begun: Floats, belt_speed: float, belt: Floats, at: Floats
) -> Floats:
    """
    Return the states of `DERIVED`, (w, 3): speed, droop, lagged reading.

    Parameters
    ----------
    values : all numbers by name
    begun : (states, w) the states that are numbers of the windows
    belt_speed : of the run
    belt : (w,) relative speed of each window's own belt
    at : (w,) when the windows begin
    """
    x1, y1, y2 = begun[X1], begun[Y1], begun[Y2]
    speed = belt_speed * (1 + belt)
    if "belt_speed_ripple.a" in values:
        a, w, phi = (values[f"belt_speed_ripple.{k}"] for k in ("a", "w", "phi"))
        speed = speed * (1 + a * np.sin(w * at + phi))
    droop = np.zeros(len(belt))
    if "belt_load_droop.k" in values:
        k, tau = values["belt_load_droop.k"], values["belt_load_droop.tau"]
        stiff = values.get("alpha1", values.get("stiffness", 0.0))
        force = stiff * x1 + values.get("eta1", values.get("damping", 0.0)) * (belt_speed + y2) + y1
        droop = -k * (force - tau * stiff * belt_speed)
        speed = speed + droop
    tau, c = values.get("sensor_lag.tau", 0.0), values.get("sensor_crosstalk.c", 0.0)
    lagged = x1 + c * y1 - tau * (speed + c * y2)
    return np.stack([speed, droop, lagged], axis=1)
