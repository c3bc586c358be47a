"""What a motion settles to: how often it repeats, from where it crosses the section, or why it does not."""

from __future__ import annotations

import numpy as np

from stickslip.simulated.orbits.cycle import even
from stickslip.simulated.orbits.flow import Contact, Floats, Flow, Mode
from stickslip.simulated.orbits.steady_sliding import NoLimitCycleError, equilibrium
from stickslip.simulated.trajectory import Trajectory

LOOK_BACK = 40  # crossings of the section in which a repetition is looked for
SAMPLES = 48  # a natural period, when looking for crossings


def settled(flow: Flow, z: Floats, lasting: float) -> tuple[Floats, float, int, Contact]:
    """State on the section, period, turns and mode of what the motion settles to."""
    forcing = flow.forcing_period
    if forcing is not None:
        count = max(int(lasting / forcing), 2 * LOOK_BACK)
        run = flow.run(z, [forcing * k for k in range(count - LOOK_BACK, count + 1)])
        states = flow.full(run)
        turns = _repeats(flow, states)
        return states[-1], turns * forcing, turns, _held(run)
    unit = 2 * np.pi * flow.natural_time
    if not flow.moves:
        raise NoLimitCycleError("the belt stands still and nothing moves the rig: it comes to rest")
    for stretch in (1, 8, 64):  # a slow belt takes many natural periods to load the spring
        seen = even(3 * LOOK_BACK * unit * stretch, 3 * LOOK_BACK * SAMPLES * stretch + 1)
        tail = np.asarray(lasting * stretch + seen, dtype=np.float64)
        run = flow.run(z, tail)
        states = flow.full(run)
        x1, x2 = flow.seen(states)
        down = np.flatnonzero((x2[:-1] > 0) & (x2[1:] <= 0))
        if len(down) >= 3 or not (run.mode == 0).any():
            break
    if len(down) < 3 and (run.mode == 0).any() and (times := _slow_crossings(flow, z, lasting)) is not None:
        return _returns(flow, z, times)
    if (run.mode == 0).all() and flow.apart(states.min(axis=0), states.max(axis=0)) < 1e-9:
        raise NoLimitCycleError(
            "every contact comes to stick, and nothing moves any more but along with them"
        )
    if len(down) < 3 or np.ptp(x1) < 1e-7 * np.abs(x1).max():
        no_cycle(flow, states.mean(axis=0))
    down = down[-LOOK_BACK:]
    return _returns(flow, z, tail[down] + x2[down] / (x2[down] - x2[down + 1]) * unit / SAMPLES)


def _returns(flow: Flow, z: Floats, times: Floats) -> tuple[Floats, float, int, Contact]:
    """State, period, turns and mode, from the times at which the section is crossed."""
    run = flow.run(z, np.asarray(times, dtype=np.float64))
    states = flow.full(run)
    turns = _repeats(flow, states)
    return states[-1], float(times[-1] - times[-1 - turns]), turns, _held(run)


def _held(run: Trajectory) -> Contact:
    """Start that holds what sticks at the end of a run, and looks at the speeds of the rest."""
    each: tuple[Mode, ...] = tuple("stick" if mode == 0 else "auto" for mode in np.atleast_1d(run.mode[-1]))
    if "stick" not in each:
        return "auto"
    return each[0] if len(each) == 1 else each


def _slow_crossings(flow: Flow, z: Floats, lasting: float) -> Floats | None:
    """Crossings of the section where a stick lasts so long that only slips are looked at; None if there are too few."""
    unit, once = 2 * np.pi * flow.natural_time, flow.loading_time
    if not np.isfinite(once):
        return None
    events = flow.run(z, [lasting + 2 * LOOK_BACK * (once + unit)]).transitions
    let_go = np.array(
        [bool(np.any((a == 0) & (b != 0))) for a, b in zip(events.before, events.after, strict=True)]
    )
    released = events.t[let_go.astype(bool) & (events.t > lasting)][:-1][-LOOK_BACK:]
    window = even(unit, SAMPLES + 1)
    if len(released) < 3 or np.diff(released).min() < 2 * unit:
        return None
    run = flow.run(z, np.concatenate([t + window for t in released]))
    x2 = flow.seen(flow.full(run))[1].reshape(len(released), -1)
    crosses = (x2[:, :-1] > 0) & (x2[:, 1:] <= 0)
    rows = np.flatnonzero(crosses.any(axis=1))
    if len(rows) < 3:
        return None
    first = np.argmax(crosses, axis=1)[rows]
    before, after = x2[rows, first], x2[rows, first + 1]
    return np.asarray(released[rows] + window[first] + before / (before - after) * unit / SAMPLES)


def _repeats(flow: Flow, given: Floats) -> int:
    """After how many returns the states (n, d) come back nearest to themselves."""
    states = given @ flow.quotient.T / flow.size
    most = min(16, (len(states) - 1) // 2)
    distance = [float(np.abs(states[n:] - states[:-n])[-most:].max()) for n in range(1, most + 1)]
    near = [n for n, gap in enumerate(distance, 1) if gap <= 1e-6]
    return near[0] if near else int(np.argmin(distance)) + 1


def no_cycle(flow: Flow, z: Floats) -> None:
    """Say where the motion goes instead."""
    rest = equilibrium(flow, z)
    greatest = rest.eigenvalues[np.argmax(rest.eigenvalues.real)]
    raise NoLimitCycleError(
        f"the motion settles to steady sliding at {flow.states[0]} = {rest.state[0]:.6g}, which is "
        f"{'stable' if rest.stable else 'unstable'} (leading eigenvalue {greatest:.4g}); "
        "for another motion give a guess farther away",
        rest,
    )
