"""The slip speeds that a record shows a law at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.declared.model import Model
from stickslip.fitted.identified import BRANCHES, Branch
from stickslip.fitted.shooting import Simulator
from stickslip.measured.fit_window import Array, FitWindow


def covered_speeds(
    model: Model, windows: Sequence[FitWindow], simulator: Simulator
) -> dict[Branch, tuple[float, float] | None]:
    """Range of |v_w| on each branch while the readings' simulation slips."""
    speeds: dict[Branch, list[Array]] = {"minus": [], "plus": []}
    for w in windows:
        local = model.replace(**w.local) if w.local else model
        run = simulator(
            local, belt_speed=w.belt_speed, initial=tuple(w.initial), t_end=float(w.t[-1]), t_eval=w.t
        )
        v_w = run.state[:, 1] - w.belt_speed
        tiny = 1e-6 * (abs(w.belt_speed) + float(np.max(np.abs(v_w))))
        speeds["minus"].append(-v_w[v_w < -tiny])
        speeds["plus"].append(v_w[v_w > tiny])
    covered: dict[Branch, tuple[float, float] | None] = {}
    for branch in BRANCHES:
        u = np.concatenate(speeds[branch]) if speeds[branch] else np.array([])
        covered[branch] = (float(u.min()), float(u.max())) if u.size else None
    return covered
