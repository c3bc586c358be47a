"""Periodic motions: Newton's method on the return map, with the exact monodromy; Floquet multipliers.

The section is x2 = 0 going down, where x1 is greatest. A block on a moving belt slips there, so a cycle crosses
it with or without a stick phase and through every sliding bifurcation. A rig moved from outside is looked at
once a period of what moves it.

With phi(T, z) the motion T after z, f its rate and M = d phi / d z, a cycle solves phi(T, z) - z = 0 and x2 = 0
(unknown z, T), or phi(T, z) - z = 0 with T given. M carries saltation through every transition; a stick phase
makes it singular, since where the block sticks its speed is forgotten.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained
from stickslip.declared.model import Model
from stickslip.errors import InputError, StickslipError, number
from stickslip.simulated.orbits.cycle import LimitCycle, even
from stickslip.simulated.orbits.flow import Arc, Contact, Floats, Flow, wiped_out
from stickslip.simulated.orbits.steady_sliding import Complexes, NoLimitCycleError, equilibrium
from stickslip.simulated.trajectory import Transitions

NEWTON_STEPS = 30
LOOK_BACK = 40  # crossings of the section in which a repetition is looked for
CLOCK = (
    16 * np.finfo(float).eps
)  # of a time, what rounding leaves of it: a few events each off by an eps or two
SAMPLES = 48  # a natural period, when looking for crossings


@explained
def limit_cycle(
    model: Model,
    belt_speed: float,
    guess: ArrayLike | LimitCycle | None = None,
    *,
    period: float | None = None,
    settle: float | None = None,
    tol: float = 1e-11,
) -> LimitCycle:
    """Find a periodic motion and its Floquet multipliers.

    Parameters
    ----------
    model, belt_speed
        The rig on its belt.
    guess
        A cycle nearby; or a state (d,) to settle from, at rest at the origin if absent. With `period`, the
        state is taken as a point of the cycle itself, and unstable cycles can be found.
    period
        Rough period, of a guess that is already near the cycle.
    settle
        How long to simulate before looking for a repetition; 300 natural periods if absent.
    tol
        Greatest difference allowed between the state and that one period later, in the model's own scale: the
        deflection of the spring under the greatest static friction (or how far the belt goes in a natural unit of
        time, if that is more), and that over the natural unit of time for speeds. Of a very long period no less than
        what rounding of the time makes of the state.

    Returns
    -------
    LimitCycle

    Raises
    ------
    NoLimitCycleError
        The motion settles to steady sliding or to rest, or Newton's method does not converge.
    InputError
        A number out of bounds, or a model no motion of which repeats.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> cycle = ss.limit_cycle(model, belt_speed=0.1)
    >>> print(f"period {cycle.period:.6f}, stable: {cycle.stable}")
    period 10.475382, stable: True
    """
    flow = Flow(model, number("belt_speed", belt_speed))
    wanted = number("tol", tol, above=0)
    if isinstance(guess, LimitCycle):
        check_states(guess, flow)
        start, rough, turns, contact = guess.state, guess.period, guess.turns, guess.contact
    elif period is not None:
        start, rough = flow.state(guess, "guess"), number("period", period, above=0)
        forcing = flow.forcing_period
        turns, contact = (1 if forcing is None else max(1, round(rough / forcing))), "auto"
    else:
        lasting = 300 * 2 * np.pi * flow.natural_time if settle is None else number("settle", settle, above=0)
        start, rough, turns, contact = _settled(flow, flow.state(guess, "guess"), lasting)
    arc, steps = newton(flow, start, rough, turns, contact, wanted)
    if flow.forcing_period is None and arc.rate[1] > 0:  # it came to rest on the other turning point
        arc, more = newton(flow, _summit(flow, arc), arc.span, turns, contact, wanted)
        steps += more
    if flow.forcing_period is None and _swing(flow, arc) < 1e-6 * flow.size[0]:
        _no_cycle(flow, arc.end)
    arc, turns = _least_period(flow, arc, turns, contact, wanted)
    return cycle_of(flow, arc, steps, turns, contact)


def check_states(guess: LimitCycle, flow: Flow) -> None:
    """Refuse a cycle of a model that has other states."""
    if guess.states != flow.states:
        words = f"is a cycle of {', '.join(guess.states)}; the model's states are {', '.join(flow.states)}"
        raise InputError(words, key="guess")


def newton(flow: Flow, z: Floats, span: float, turns: int, contact: Contact, tol: float) -> tuple[Arc, int]:
    """Solve for a cycle from a state and a period nearby; the arc round it, and the number of steps."""
    forcing = flow.forcing_period
    if forcing is not None:
        span = turns * forcing
    else:
        z = z * (np.arange(len(z)) != 1)  # on the section
    rough, last, arc = span, np.inf, flow.arc(z, span, contact=contact)
    for step in range(NEWTON_STEPS):
        error = _apart(flow, arc)
        tol = max(tol, CLOCK * arc.span * float(np.abs(arc.rate / flow.size).max()))
        if error <= tol and error >= 0.1 * last:  # as far as it goes
            return arc, step
        last = error
        change = _newton_step(flow, arc)
        arc = _damped(flow, arc, change, error, contact)
        if not 0.2 * rough < arc.span < 5 * rough:
            break
    if _apart(flow, arc) <= tol:
        return arc, NEWTON_STEPS
    raise NoLimitCycleError(
        f"no cycle found: Newton's method on the return map stops at a residual of {last:.1e}; "
        "give a nearer guess, or a longer settle"
    )


def _apart(flow: Flow, arc: Arc) -> float:
    """How far the end of an arc is from its start, in the model's own scale."""
    return float(np.abs((arc.end - arc.start) / flow.size).max())


def _newton_step(flow: Flow, arc: Arc) -> Floats:
    """Change of (z, T) that closes the arc, to first order."""
    d, size = len(arc.start), flow.size
    gap, closing = (arc.start - arc.end) / size, arc.monodromy * size / size[:, None] - np.eye(len(size))
    if flow.forcing_period is not None:
        return np.append(size * np.linalg.lstsq(closing, gap, rcond=1e-13)[0], 0.0)
    system = np.zeros((d + 1, d + 1))
    time = flow.natural_time
    system[:d, :d], system[:d, d], system[d, 1] = closing, time * arc.rate / size, 1.0
    solved = np.linalg.lstsq(system, np.append(gap, -arc.start[1] / size[1]), rcond=1e-13)[0]
    return np.asarray(solved * np.append(size, time))


def _damped(flow: Flow, arc: Arc, change: Floats, error: float, contact: Contact) -> Arc:
    """Take the step, or a part of it where the whole makes things worse."""
    best = None
    for share in (1.0, 0.5, 0.2, 0.05):
        span = arc.span + share * change[-1]
        if span <= 0:
            continue
        try:
            tried = flow.arc(arc.start + share * change[:-1], span, contact=contact)
        except StickslipError:
            continue
        left = _apart(flow, tried)
        if best is None or left < best[0]:
            best = left, tried
        if left < error or error < 1e-9:
            break
    if best is None:
        raise NoLimitCycleError("no cycle found: Newton's method leaves the range of the model")
    return best[1]


def cycle_of(flow: Flow, arc: Arc, steps: int, turns: int, contact: Contact) -> LimitCycle:
    """Put together what is known of a closed arc."""
    tr, inside = arc.run.transitions, arc.within
    cut = Transitions(
        t=tr.t[inside],
        state=tr.state[inside],
        before=tr.before[inside],
        after=tr.after[inside],
        sensitivity=tr.sensitivity[inside],
        state_sensitivity=tr.state_sensitivity[inside],
    )
    sticks = contact == "stick" or bool(np.any(cut.after == 0))
    lost = wiped_out(flow, sticks)
    return LimitCycle(
        period=arc.span,
        state=arc.start,
        states=flow.states,
        transitions=cut,
        kinks=arc.run.kinks[arc.run.kinks <= arc.span],
        monodromy=arc.monodromy,
        multipliers=floquet(arc, flow.forcing_period is not None, lost, flow.idle(arc.monodromy)),
        residual=_apart(flow, arc),
        iterations=steps,
        turns=turns,
        belt_speed=flow.belt_speed,
        model=flow.model,
        contact=contact,
    )


def floquet(arc: Arc, forced: bool, lost: int, idle: NDArray[np.bool_]) -> Complexes:
    """Floquet multipliers, greatest first; the `lost` smallest are known to be 0 (directions that stick forgets).

    Of an autonomous cycle those of the return map: with n the section's normal, (1 - f n / (n . f)) M on it.
    States that are `idle` are none.
    """
    m, keep = arc.monodromy, ~idle
    if not forced:
        projected = m - np.outer(arc.rate / arc.rate[1], m[1])
        m, keep = projected, keep & (np.arange(len(m)) != 1)
    m = m[np.ix_(keep, keep)]
    values = np.linalg.eigvals(m).astype(np.complex128)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    for k in range(len(values) - min(lost, len(values)), len(values)):
        if abs(values[k]) < 1e-6:
            values[k] = 0.0
    return values


def _settled(flow: Flow, z: Floats, lasting: float) -> tuple[Floats, float, int, Contact]:
    """State on the section, period, turns and mode of what the motion settles to."""
    forcing = flow.forcing_period
    if forcing is not None:
        count = max(int(lasting / forcing), 2 * LOOK_BACK)
        run = flow.run(z, [forcing * k for k in range(count - LOOK_BACK, count + 1)])
        states = flow.full(run)
        turns = _repeats(states / flow.size)
        return states[-1], turns * forcing, turns, "stick" if run.mode[-1] == 0 else "auto"
    unit = 2 * np.pi * flow.natural_time
    if flow.belt_speed == 0:
        raise NoLimitCycleError("the belt stands still and nothing moves the rig: it comes to rest")
    for stretch in (1, 8, 64):  # a slow belt takes many natural periods to load the spring
        seen = even(3 * LOOK_BACK * unit * stretch, 3 * LOOK_BACK * SAMPLES * stretch + 1)
        tail = np.asarray(lasting * stretch + seen, dtype=np.float64)
        run = flow.run(z, tail)
        x2, x1 = run.state[:, 1], run.state[:, 0]
        down = np.flatnonzero((x2[:-1] > 0) & (x2[1:] <= 0))
        if len(down) >= 3 or not (run.mode == 0).any():
            break
    if len(down) < 3 and (run.mode == 0).any() and (times := _slow_crossings(flow, z, lasting)) is not None:
        states = flow.full(flow.run(z, times))
        turns = _repeats(states / flow.size)
        return states[-1], float(times[-1] - times[-1 - turns]), turns, "auto"
    if len(down) < 3 or np.ptp(x1) < 1e-7 * np.abs(x1).max():
        _no_cycle(flow, flow.full(run).mean(axis=0))
    down = down[-LOOK_BACK:]
    times = tail[down] + x2[down] / (x2[down] - x2[down + 1]) * unit / SAMPLES
    states = flow.full(flow.run(z, np.asarray(times, dtype=np.float64)))
    turns = _repeats(states / flow.size)
    return states[-1], float(times[-1] - times[-1 - turns]), turns, "auto"


def _slow_crossings(flow: Flow, z: Floats, lasting: float) -> Floats | None:
    """Crossings of the section where a stick lasts so long that only slips are looked at; None if there are too few."""
    unit = 2 * np.pi * flow.natural_time
    once = 2 * flow.size[0] / abs(flow.belt_speed)  # the spring, from limit to limit
    events = flow.run(z, [lasting + 2 * LOOK_BACK * (once + unit)]).transitions
    released = events.t[(events.before == 0) & (events.t > lasting)][:-1][-LOOK_BACK:]
    window = even(unit, SAMPLES + 1)
    if len(released) < 3 or np.diff(released).min() < 2 * unit:
        return None
    run = flow.run(z, np.concatenate([t + window for t in released]))
    x2 = run.state[:, 1].reshape(len(released), -1)
    first = np.argmax((x2[:, :-1] > 0) & (x2[:, 1:] <= 0), axis=1)
    rows = np.arange(len(released))
    before, after = x2[rows, first], x2[rows, first + 1]
    return np.asarray(released + window[first] + before / (before - after) * unit / SAMPLES)


def _repeats(states: Floats) -> int:
    """After how many returns the states (n, d), in the model's own scale, come back nearest to themselves."""
    most = min(16, (len(states) - 1) // 2)
    distance = [float(np.abs(states[n:] - states[:-n])[-most:].max()) for n in range(1, most + 1)]
    near = [n for n, gap in enumerate(distance, 1) if gap <= 1e-6]
    return near[0] if near else int(np.argmin(distance)) + 1


def _least_period(flow: Flow, arc: Arc, turns: int, contact: Contact, tol: float) -> tuple[Arc, int]:
    """Go down to the least period of an arc that goes round several times."""
    for divisor in range(turns, 1, -1):
        if turns % divisor:
            continue
        part = flow.arc(arc.start, arc.span / divisor, contact=contact)
        if _apart(flow, part) < 1e-6:
            return newton(flow, arc.start, part.span, turns // divisor, contact, tol)[0], turns // divisor
    return arc, turns


def _summit(flow: Flow, arc: Arc) -> Floats:
    """State near the greatest x1 of a closed arc."""
    states = flow.full(flow.run(arc.start, even(arc.span, 8 * SAMPLES)))
    return np.asarray(states[np.argmax(states[:, 0])])


def _swing(flow: Flow, arc: Arc) -> float:
    """How far x1 moves on the arc."""
    run = flow.run(arc.start, even(arc.span, 33))
    return float(np.ptp(run.state[:, 0]))


def _no_cycle(flow: Flow, z: Floats) -> None:
    """Say where the motion goes instead."""
    rest = equilibrium(flow, z)
    greatest = rest.eigenvalues[np.argmax(rest.eigenvalues.real)]
    raise NoLimitCycleError(
        f"the motion settles to steady sliding at x1 = {rest.state[0]:.6g}, which is "
        f"{'stable' if rest.stable else 'unstable'} (leading eigenvalue {greatest:.4g}); "
        "for another motion give a guess farther away",
        rest,
    )
