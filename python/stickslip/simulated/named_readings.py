"""What the sensors of a named rig read of a motion: x1, and y1 where there is one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated
from stickslip.declared.formula_effect import FormulaEffect
from stickslip.declared.model import Model
from stickslip.simulated.states import AT, Y1
from stickslip.simulated.x1_sensor import X1Sensor, seen

Floats = NDArray[np.float64]


def acted_on(model: Model) -> tuple[str, ...]:
    """Return the channels that effects of a model read otherwise than the state is."""
    found = set[str]()
    for one in model.effects:
        if isinstance(one, FormulaEffect):
            found |= {one.where} if one.acts == "reading" else set()
        elif one.where.endswith(" channel"):
            found.add(one.where.removesuffix(" channel"))
    return tuple(sorted(found))


def named_readings(
    model: Model, t: Floats, state: Floats, earlier: Callable[[Floats], Floats]
) -> dict[str, Floats]:
    """
    Return what is read of x1 and y1 by channel, (n,).

    Parameters
    ----------
    model : of a named rig, without effects by a formula
    t, state : (n,), (n, 9)
    earlier : y1 at other times, for a delay
    """
    names = [name for name in ("x1", "y1") if name in model.rig.state_names]
    if not model.effects:
        return {name: state[:, AT[name]] for name in names}
    p = model.parameters
    out = {"x1": X1Sensor.acting(p).of(seen(p, state), t)}
    if "y1" in names:
        late = p.get("sensor_delay.delay", 0.0)
        out["y1"] = earlier(t - late) if late else state[:, Y1].copy()
    for one in model.effects:
        if isinstance(one, Tabulated) and one.of_reading:
            out[one.where[:2]] += one.curve(t if one.variable == "t" else state[:, AT[one.variable]])
    return out
