"""The states of a simulation: names to columns, once. The order is the core's."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip import _core

COUNT = len(_core.STATES)
AT: Mapping[str, int] = {name: i for i, name in enumerate(_core.STATES)}
X1, X2, Y1, Y2 = (AT[name] for name in ("x1", "x2", "y1", "y2"))
# lagged slip speed, bristle, the belt's own speed, lagged reading, time stuck
W, Z, BELT, LAGGED, DWELL = (AT[name] for name in ("w", "z", "b", "m", "dwell"))
VISIBLE = (X1, X2, Y1, Y2)
HIDDEN: tuple[str, ...] = _core.STATES[len(VISIBLE) :]
RATE = {X1: X2, Y1: Y2}  # the state that is another's rate
