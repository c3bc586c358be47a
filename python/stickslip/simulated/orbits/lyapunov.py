"""Lyapunov exponents through transitions.

The derivatives of the flow over an interval carry saltation through every transition (Müller 1995); a triangular
factorisation after each interval keeps the tangent vectors apart (Benettin, Galgani, Giorgilli and Strelcyn 1980).
A stick phase forgets the block's speed: one tangent vector shrinks to nothing in a finite time and its exponent
is -infinity, which is what is reported. One that only shrinks fast is followed over shorter stretches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.arguments import explained
from stickslip.declared.model import Model
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, number
from stickslip.objects import Sampled
from stickslip.simulated.orbits.flow import Contact, Flags, Floats, Flow, modes_through
from stickslip.simulated.orbits.flow_of import flow_of

ALIGN = 20  # intervals in which the tangent vectors turn into place, not counted
BATCHES = 20  # for the error of a time average
NOTHING = 1e-12  # a tangent vector shrunk to this in one interval is rounding
SHOWS = 1e3  # of the simulation's tolerance, that may show in what a stick has wiped out
MOST_HALVINGS = 12  # of an interval


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum(Sampled):
    """Mean growth rates of small disturbances.

    Attributes
    ----------
    exponents : (d,)
        Greatest first; -inf for a direction that stick wipes out. An autonomous motion that does not come to
        rest has one exponent 0, along itself. Time is not a state: a rig moved from outside has no such 0.
        A hidden state that never had influence has none, nor has a translation of what no spring holds.
    standard_error : (d,)
        Of each exponent as a time average, from the scatter of 20 batch means; nan where it is -inf.
    t : (k,)
        Ends of the intervals.
    history : (k, d)
        The exponents as estimated up to then.
    state : (d,)
        Where the motion ended; `lyapunov(..., initial=state, transient=0)` goes on from there, if nothing but
        the state matters.
    states
        Names of the states; hidden ones of effects after the visible ones.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> found = ss.lyapunov(model, belt_speed=0.1, t_end=450, transient=50)
    >>> float(found.exponents[-1])  # of a direction that a stick wipes out
    -inf
    """

    exponents: Floats
    standard_error: Floats
    t: Floats
    history: Floats
    state: Floats
    states: tuple[str, ...]

    @property
    def chaotic(self) -> bool:
        """Is the greatest exponent positive by more than four standard errors, and by more than rounding?"""
        return bool(self.exponents[0] > max(4 * self.standard_error[0], 1e-8))

    @property
    def dimension(self) -> float:
        """Kaplan and Yorke's dimension of the attractor, time not counted as a state."""
        sums = np.cumsum(self.exponents)
        nothing = 0.1 / (self.t[-1] - self.t[0])  # a growth by less than a tenth in all is none
        k = int(np.sum(sums >= -nothing))
        if k == 0 or k == len(sums):
            return float(k)
        return float(
            k + (max(sums[k - 1], 0.0) / abs(self.exponents[k]) if np.isfinite(self.exponents[k]) else 0.0)
        )


@explained
def lyapunov(
    model: Model,
    *,
    belt_speed: float | str | Speed | None = None,
    drive_speed: float | str | Speed | None = None,
    initial: ArrayLike | None = None,
    t_end: float,
    transient: float = 0.0,
    interval: float | None = None,
    tolerance: float = 1e-11,
) -> LyapunovSpectrum:
    """Estimate the Lyapunov spectrum of a motion.

    Parameters
    ----------
    model, belt_speed, drive_speed
        The rig and what moves it.
    initial
        State (d,) to start from at t = 0, hidden states after the visible ones; at rest at the origin if absent
        (moving with the drive, springs slack).
    t_end
        When to stop.
    transient
        How long to wait for the motion to settle before averaging.
    interval
        Time between factorisations; a period of what moves the rig, or of the block's own frequency, if absent.
    tolerance
        Of the simulation, relative and absolute; the latter smaller for rigs whose own scale is below 1.

    Returns
    -------
    LyapunovSpectrum

    Raises
    ------
    InputError
        A number is out of bounds, or fewer than 40 intervals fit between `transient` and `t_end`.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> found = ss.lyapunov(model, belt_speed=0.1, t_end=450, transient=50)
    >>> found.chaotic
    False
    """
    flow = flow_of(model, belt_speed, drive_speed, number("tolerance", tolerance, above=0))
    natural = 2 * np.pi * flow.natural_time
    forcing = _forcing(flow)
    step = (forcing or natural) if interval is None else number("interval", interval, above=0)
    wait = number("transient", transient, least=0)
    end = number("t_end", t_end, above=0)
    count = int((end - wait) / step) - ALIGN
    if count < 2 * BATCHES:
        need = wait + (ALIGN + 2 * BATCHES) * step
        raise InputError(f"too short for an average; give at least {need:.6g}", key="t_end", value=end)
    z = flow.state(initial, "initial")
    contact: Contact = "auto"
    if wait > 0:
        run = flow.run(z, [wait])
        z, contact = flow.full(run)[-1], flow.contact(np.atleast_1d(run.mode[-1]))
    start, kept = z, np.ones(len(z), dtype=bool)
    growth, z, idle = _growth(flow, start, contact, wait, step, count, kept)
    if idle.any():  # followed once more without what has no influence
        growth, z, idle = _growth(flow, start, contact, wait, step, count, ~idle)
    return _spectrum(flow, growth, step, wait, z)


def _forcing(flow: Flow) -> float | None:
    """Return the forcing's period where there is one; exponents need none."""
    try:
        return flow.forcing_period
    except InputError:
        return None


def _growth(
    flow: Flow, z: Floats, contact: Contact, begin: float, step: float, count: int, kept: Flags
) -> tuple[Floats, Floats, Flags]:
    """Logarithms (count, d) of the tangent vectors' growth over each interval, the last state, and what was idle."""
    d = flow.basis(~kept).shape[1]
    q, growth, idle = np.eye(d), np.empty((count, d)), np.ones(len(z), dtype=bool)
    for k in range(-ALIGN, count):
        z, contact, q, logs = _stretch(flow, z, contact, q, begin + (k + ALIGN) * step, step, kept, idle)
        if k >= 0:
            growth[k] = logs
    return growth, z, idle


def _stretch(
    flow: Flow,
    z: Floats,
    contact: Contact,
    q: Floats,
    start: float,
    step: float,
    kept: Flags,
    idle: Flags,
    halvings: int = 0,
) -> tuple[Floats, Contact, Floats, Floats]:
    """State, contact, orthogonal tangent vectors and logarithms (d,) of their growth after `step`.

    What a stick wipes out is gone. Whatever else shrinks to rounding only shrinks fast, and is followed by halves.
    The tangent vectors are of the states `kept`; `idle` loses those that had influence.
    """
    run = flow.run(z, [start + step], seeds=flow.seeds(), contact=contact, start=start)
    jacobian = flow.jacobian(run)[-1]
    idle &= flow.idle(jacobian)
    basis = flow.basis(~kept)
    turned, r = np.linalg.qr(basis.T @ jacobian @ basis @ q)
    sizes = np.abs(np.diag(r))
    most = sizes.max(initial=0.0)
    lost = flow.wiped_out(modes_through(run, start + step))
    gone = np.zeros(len(sizes), dtype=bool)
    gone[np.argsort(sizes)[:lost]] = True
    gone &= sizes <= max(NOTHING, SHOWS * flow.tolerance) * most
    if halvings < MOST_HALVINGS and np.any(~gone & (sizes <= NOTHING * most)):
        logs = np.zeros(len(sizes))
        for half in (0, 1):
            z, contact, q, more = _stretch(
                flow, z, contact, q, start + half * step / 2, step / 2, kept, idle, halvings + 1
            )
            logs += more
        return z, contact, q, logs
    gone |= sizes == 0
    logs = np.where(gone, -np.inf, np.log(np.where(gone, 1.0, sizes)))
    return flow.full(run)[-1], flow.contact(np.atleast_1d(run.mode[-1])), turned, logs


def _spectrum(flow: Flow, growth: Floats, step: float, wait: float, z: Floats) -> LyapunovSpectrum:
    count = len(growth)
    elapsed: Floats = step * np.arange(1, count + 1, dtype=np.float64)
    history = np.cumsum(growth, axis=0) / elapsed[:, None]
    finite = np.isfinite(history[-1])
    usable = growth[count % BATCHES :][:, finite] / step
    means = usable.reshape(BATCHES, -1, usable.shape[1]).mean(axis=1)
    error = np.full(growth.shape[1], np.nan)
    error[finite] = means.std(axis=0, ddof=1) / np.sqrt(BATCHES)
    order = np.argsort(-history[-1], kind="stable")
    return LyapunovSpectrum(
        exponents=history[-1, order],
        standard_error=error[order],
        t=np.asarray(wait + ALIGN * step + elapsed, dtype=np.float64),
        history=history[:, order],
        state=z,
        states=flow.states,
    )
