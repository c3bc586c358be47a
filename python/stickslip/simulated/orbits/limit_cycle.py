"""Periodic motions: Newton's method on the return map, with the exact monodromy; Floquet multipliers.

The section is x2 = 0 going down, where x1 is greatest. A block on a moving belt slips there, so a cycle crosses
it with or without a stick phase and through every sliding bifurcation. Of a rig of bodies or matrices it is where
the deflection at the first contact that a spring holds is greatest, seen from the drive if there is one. A rig moved
from outside is looked at once a period of what moves it.

With phi(T, z) the motion T after z, f its rate and M = d phi / d z, a cycle solves phi(T, z) - z = 0 and x2 = 0
(unknown z, T), or phi(T, z) - z = 0 with T given. M carries saltation through every transition; a stick phase
makes it singular, since where the block sticks its speed is forgotten.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stickslip.arguments import explained
from stickslip.declared.model import Model
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, StickslipError, number
from stickslip.simulated.orbits.cycle import LimitCycle, even
from stickslip.simulated.orbits.flow import Arc, Complexes, Contact, Flags, Floats, Flow, modes_through
from stickslip.simulated.orbits.flow_of import flow_of
from stickslip.simulated.orbits.settling import SAMPLES, no_cycle, settled
from stickslip.simulated.orbits.steady_sliding import NoLimitCycleError
from stickslip.simulated.trajectory import Transitions

NEWTON_STEPS = 30
CLOCK = (
    16 * np.finfo(float).eps
)  # of a time, what rounding leaves of it: a few events each off by an eps or two


@explained
def limit_cycle(
    model: Model,
    belt_speed: float | str | Speed | None = None,
    guess: ArrayLike | LimitCycle | None = None,
    *,
    drive_speed: float | str | Speed | None = None,
    period: float | None = None,
    settle: float | None = None,
    tol: float = 1e-11,
) -> LimitCycle:
    """Find a periodic motion and its Floquet multipliers.

    Parameters
    ----------
    model, belt_speed
        The rig on its belt, whose speed is a number or a formula of t that repeats; left out where nothing rubs on one.
    guess
        A cycle nearby; or a state (d,) to settle from, at rest at the origin if absent (moving with the drive, springs
        slack). Hidden states may be left out: they are 0, or as the law starts them. With `period`, the state is taken
        as a point of the cycle itself, and unstable cycles can be found.
    drive_speed
        Likewise of the drive that pulls at links of a rig of bodies.
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
    flow = flow_of(model, belt_speed, drive_speed)
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
        start, rough, turns, contact = settled(flow, flow.state(guess, "guess"), lasting)
    arc, steps = newton(flow, start, rough, turns, contact, wanted)
    if (
        flow.forcing_period is None and flow.section[0] @ arc.rate > 0
    ):  # it came to rest on the other turning point
        arc, more = newton(flow, _summit(flow, arc), arc.span, turns, contact, wanted)
        steps += more
    if flow.forcing_period is None and swing(flow, arc) < 1e-6 * (np.abs(flow.height) @ flow.size):
        no_cycle(flow, arc.end)
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
        z = flow.quotient @ flow.on_section(z)
    rough, last, arc = span, np.inf, flow.arc(z, span, contact=contact)
    for step in range(NEWTON_STEPS):
        error = flow.apart(arc.start, arc.end)
        tol = max(tol, CLOCK * arc.span * float(np.abs(arc.rate / flow.size).max()))
        if error <= tol and error >= 0.1 * last:  # as far as it goes
            return arc, step
        last = error
        change = _newton_step(flow, arc)
        arc = _damped(flow, arc, change, error, contact)
        if not 0.2 * rough < arc.span < 5 * rough:
            break
    if flow.apart(arc.start, arc.end) <= tol:
        return arc, NEWTON_STEPS
    raise NoLimitCycleError(
        f"no cycle found: Newton's method on the return map stops at a residual of {last:.1e}; "
        "give a nearer guess, or a longer settle"
    )


def _newton_step(flow: Flow, arc: Arc) -> Floats:
    """Change of (z, T) that closes the arc, to first order."""
    d, size = len(arc.start), flow.size
    gap = flow.quotient @ (arc.start - arc.end) / size
    closing = flow.quotient @ (arc.monodromy - np.eye(d)) * size / size[:, None]
    if flow.forcing_period is not None:
        return np.append(size * np.linalg.lstsq(closing, gap, rcond=1e-13)[0], 0.0)
    system = np.zeros((d + 1, d + 1))
    time = flow.natural_time
    row, level = flow.section
    unit = np.abs(row) @ size
    system[:d, :d], system[:d, d], system[d, :d] = (
        closing,
        time * (flow.quotient @ arc.rate) / size,
        row * size / unit,
    )
    solved = np.linalg.lstsq(system, np.append(gap, (level - row @ arc.start) / unit), rcond=1e-13)[0]
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
        left = flow.apart(tried.start, tried.end)
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
    lost = flow.wiped_out(modes_through(arc.run, arc.span))
    return LimitCycle(
        period=arc.span,
        state=arc.start,
        states=flow.states,
        transitions=cut,
        kinks=arc.run.kinks[arc.run.kinks <= arc.span],
        monodromy=arc.monodromy,
        multipliers=floquet(flow, arc, lost, flow.idle(arc.monodromy)),
        residual=flow.apart(arc.start, arc.end),
        iterations=steps,
        turns=turns,
        belt_speed=flow.belt_speed,
        model=flow.model,
        contact=contact,
        drive_speed=flow.drive_speed,
    )


def floquet(flow: Flow, arc: Arc, lost: int, idle: Flags) -> Complexes:
    """Floquet multipliers, greatest first; the `lost` smallest are known to be 0 (directions that stick forgets).

    Of an autonomous cycle those of the return map: with n the section's normal, (1 - f n / (n . f)) M on it.
    States that are `idle`, and translations along which nothing changes, are none.
    """
    m, rows = arc.monodromy, list[Floats]()
    if flow.forcing_period is None:
        row, _ = flow.section
        m = m - np.outer(arc.rate / (row @ arc.rate), row @ m)
        rows = [row]
    basis = flow.basis(idle, *rows)
    m = basis.T @ m @ basis
    values = np.linalg.eigvals(m).astype(np.complex128)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    for k in range(len(values) - min(lost, len(values)), len(values)):
        if abs(values[k]) < 1e-6:
            values[k] = 0.0
    return values


def _least_period(flow: Flow, arc: Arc, turns: int, contact: Contact, tol: float) -> tuple[Arc, int]:
    """Go down to the least period of an arc that goes round several times."""
    for divisor in range(turns, 1, -1):
        if turns % divisor:
            continue
        part = flow.arc(arc.start, arc.span / divisor, contact=contact)
        if flow.apart(part.start, part.end) < 1e-6:
            return newton(flow, arc.start, part.span, turns // divisor, contact, tol)[0], turns // divisor
    return arc, turns


def _summit(flow: Flow, arc: Arc) -> Floats:
    """State near the greatest x1 of a closed arc."""
    states = flow.full(flow.run(arc.start, even(arc.span, 8 * SAMPLES)))
    return np.asarray(states[np.argmax(flow.seen(states)[0])])


def swing(flow: Flow, arc: Arc) -> float:
    """How far what is greatest on the section moves on the arc."""
    run = flow.run(arc.start, even(arc.span, 33))
    return float(np.ptp(flow.seen(flow.full(run))[0]))
