"""Where the record is cut, and the states its windows start from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.effect_terms import Before
from stickslip.declared.model import Model
from stickslip.fitted.data import Data
from stickslip.fitted.readings import Y1_LAG, ReadingCurve, curves_of
from stickslip.fitted.window import AUTO, SLIPPING, STICK, Window
from stickslip.measured.sticks import rides
from stickslip.simulated.states import AT, COUNT, DWELL, VISIBLE, X1, X2, Y1, Y2
from stickslip.simulated.x1_sensor import X1Sensor

Floats = NDArray[np.float64]
LEAST = 0.1  # slope of a curved reading that a rate is divided by
FEWEST = 3  # slips of a record whose beginning may be left out
EARLY = 0.2  # share of it that may be


def cut(data: Sequence[Data], model: Model, cycles: float, *, early: float = EARLY) -> list[Window]:
    """Windows about `cycles` long, starting where the block slips fastest.

    What comes before the first slip is left out, unless it is more of the record than `early`: how the block has come
    to where the record begins, and for how long it has stuck there, is not known, and a window that begins wrongly
    misleads a fit.
    """
    out = []
    for number, run in enumerate(data):
        starts = [_first(run, early)]
        for at in run.slips:
            if run.t[at] - run.t[starts[-1]] >= (cycles - 0.5) * run.cycle:
                starts.append(int(at))
        if len(starts) > 1 and run.t[-1] - run.t[starts[-1]] < 0.4 * run.cycle:
            starts.pop()
        ends = [*starts[1:], len(run.t)]
        out += [start_window(run, number, model, a, b) for a, b in zip(starts, ends, strict=True)]
    return out


def _first(run: Data, early: float) -> int:
    """Sample at which the first window starts."""
    if len(run.slips) < FEWEST:
        return 0
    at = int(run.slips[0])
    return at if run.t[at] - run.t[0] <= early * (run.t[-1] - run.t[0]) else 0


def start_window(run: Data, number: int, model: Model, start: int, stop: int) -> Window:
    """A window with its state from the readings around its start."""
    state = np.zeros(COUNT)
    state[list(VISIBLE)] = behind(
        model.parameters, curves_of(model), float(run.t[start]), run.local_state(start)
    )
    contact, free = AUTO, VISIBLE
    window = Window(number, start, stop, state, free, state, np.full(COUNT, np.inf), contact)
    return with_hidden(window, model, run)


def behind(p: Mapping[str, float], curves: Sequence[ReadingCurve], t: float, read: Floats) -> Floats:
    """x1, x2, y1, y2 behind readings and their rates (4,), as far as they tell: a lag is taken for settled.

    The model's own numbers undo what its sensors add; past the fold of a curvature the reading at the fold is taken.
    """
    x1, x2, y1, y2 = read
    along = {"x1": (x1, x2), "x2": (x2, 0.0), "y1": (y1, y2), "y2": (y2, 0.0), "t": (t, 1.0)}
    for one in curves:
        at, moves = along[one.variable]
        added, rate = ((one.basis(np.array([at]), k) @ one.values(p))[0] for k in (0, 1))
        if one.channel == "x1":
            x1, x2 = x1 - added, x2 - rate * moves
        elif one.channel == "y1":
            y1, y2 = y1 - added, y2 - rate * moves
    late = p.get("sensor_delay.delay", 0.0) + p.get(Y1_LAG, 0.0)
    y1 += late * y2
    sensor = X1Sensor.acting(p)
    x1 = float(sensor.undone(x1, t))
    x2 = (x2 - sensor.drift) / max(float(sensor.slope(x1)), LEAST * sensor.gain)
    c = p.get("sensor_crosstalk.c", 0.0)
    return np.array([x1 + p.get("sensor_lag.tau", 0.0) * x2 - c * y1, x2 - c * y2, y1, y2])


def with_hidden(window: Window, model: Model, run: Data) -> Window:
    """The window with the hidden states that the model's effects need, started and loosely held."""
    names = {one.name: one for one in model.effects}
    state, centre = window.state.copy(), window.state.copy()
    spread = np.full(COUNT, np.inf)
    free = [k for k in window.free if k in VISIBLE]
    v = float(state[X2]) - run.belt_speed
    c = names["sensor_crosstalk"].parameters["c"] if "sensor_crosstalk" in names else 0.0
    before = Before(v, run.belt_speed, model.friction, state[X1] + c * state[Y1], state[X2] + c * state[Y2])
    for name, kind in CATALOGUE.items():
        if name in names and (start := kind.behaves.hidden_start):
            at = AT[kind.hidden[0]]
            state[at], spread[at] = start(names[name].parameters, before)
            free.append(at)
    contact = window.contact
    # how long the block has stuck before the record is not recorded
    stuck = bool(rides(state[X2 : X2 + 1], run.belt_speed)) and window.contact != SLIPPING
    if "static_aging" in names and stuck:
        contact = STICK
        state[DWELL], spread[DWELL] = 0.4 * run.cycle, 0.5 * run.cycle
        free = [X1, Y1, Y2, *(k for k in free if k not in VISIBLE), DWELL]
    centre[list(free)] = state[list(free)]
    return Window(window.run, window.start, window.stop, state, tuple(free), centre, spread, contact)


def slipping(window: Window, run: Data) -> Window | None:
    """A window that starts in stick, started in slip instead; None of any other."""
    if window.contact != STICK:
        return None
    state, spread = window.state.copy(), window.spread.copy()
    state[X2], state[DWELL], spread[DWELL] = run.local_state(window.start)[X2], 0.0, np.inf
    free = (*VISIBLE, *(k for k in window.free if k not in (*VISIBLE, DWELL)))
    return replace(window, state=state, spread=spread, free=free, contact=SLIPPING)
