"""The yardstick of the tests: slow, short, obviously right, and no code shared with the core.

The equations are those of `reference_equations`. Between switchings they are analytic and integrated by
scipy's DOP853 at a tight tolerance. The switching functions, negative while a side lasts, are looked at
many times within every step, tangencies included, so that an even number of crossings is not lost. A
crossing is landed on by Henon's method: the switching function S becomes the independent variable,

    dz/dS = f / f_S,   dt/dS = 1 / f_S,

integrated from S < 0, the state before the crossing, to S = 0 with the sides frozen. Where f_S comes close
to zero (grazing) that is singular, and the root is bracketed in t instead.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq

from stickslip.declared.effect import Tabulated
from stickslip.declared.model import Model
from stickslip.simulated.reference.equations import Guard, Side, System

Floats = NDArray[np.float64]
Dense = Callable[[Any], Any]  # state (d,) at a time, (d, n) at times (n,)
Change = tuple[float, Floats, int, int]  # time, state, contact mode before and after

ON_SURFACE = 1e-12  # a switching function nearer to zero than this is on the surface
SAMPLES = np.linspace(0.0, 1.0, 9)  # looks at the switching functions within a step
FIRST_SAMPLES = np.unique(np.append(np.geomspace(1e-7, 1.0, 43), SAMPLES))  # and just after a switching
PILE_UP = 50  # switchings at one instant


@dataclass(frozen=True)
class ModeChanges:
    """Changes of contact mode: times (k,), states (k, d), modes before and after (k,) in {-1, 0, 1}."""

    t: Floats
    state: Floats
    before: NDArray[np.int64]
    after: NDArray[np.int64]


@dataclass(frozen=True)
class RunStatus:
    """Whether the run reached `t_end`, and the sentence to read if not."""

    ok: bool
    message: str


@dataclass(frozen=True)
class OdeStep:
    """One integration step: from `t`, `z` to `end`, and the sides it was computed with."""

    t: float
    z: Floats
    end: float
    side: Any  # what is frozen in it: a `Side`, or what another system has
    dense: Dense


@dataclass(frozen=True)
class Run:
    """A simulated run.

    Attributes
    ----------
    t, state, hidden, mode : (n,), (n, d), (n, h), (n,) arrays
        Times, rig states, the effects' hidden states in the order (w, z, b) of those present, contact modes.
        At a transition the mode is the one that follows.
    transitions : ModeChanges
    kinks : list of (t, name)
        Every other switching: "clamp", "memory", "gap", "drag", "pivot", "normal".
    status : RunStatus
    """

    t: Floats
    state: Floats
    hidden: Floats
    mode: NDArray[np.int64]
    transitions: ModeChanges
    kinks: list[tuple[float, str]]
    status: RunStatus
    system: System = field(repr=False)
    steps: list[OdeStep] = field(repr=False)

    def at(self, t: ArrayLike, interpolated: bool = False) -> Floats:
        """Full state (n, d + h) at times (n,): integrated afresh from the start of its step, or between its ends."""
        if interpolated:
            return np.array([s.dense(x) for x, s in self._find(t)])
        return np.array([advance(self.system, s.side, s.t, s.z, x) for x, s in self._find(t)])

    def mode_at(self, t: ArrayLike) -> NDArray[np.int64]:
        """Contact mode (n,) at the times `t` (n,)."""
        return np.array([s.side.contact for _, s in self._find(t)], np.int64)

    def _find(self, t: ArrayLike) -> list[tuple[float, OdeStep]]:
        times = np.atleast_1d(np.asarray(t, float))
        k = np.searchsorted([s.t for s in self.steps], times, side="right") - 1
        return [(float(x), self.steps[i]) for x, i in zip(times, np.maximum(k, 0), strict=True)]


def simulate(
    model: Model,
    *,
    belt_speed: float,
    initial: Sequence[float],
    t_end: float,
    tol: float = 1e-12,
    t_eval: ArrayLike | None = None,
    hidden: Mapping[str, float] | None = None,
    max_step: float = 0.1,
    max_transitions: int = 100_000,
) -> Run:
    """Integrate `model` from t = 0 to `t_end` with every switching located.

    Parameters
    ----------
    model : Model
    belt_speed : float
        v_b, nondimensional.
    initial : sequence of d floats
        (x1, x2, y1, y2), or (x1, x2) for a block on a belt. A start within 1e-12 of the belt's speed is at
        rest on the belt.
    t_end : float
    tol : float
        Relative and absolute tolerance of the integrator.
    t_eval : (n,) array, optional
        Times of the output; the integrator's own steps otherwise.
    hidden : mapping, optional
        Hidden states at t = 0: "w" (friction_memory), "z" (contact_compliance), "b" (belt_load_droop),
        "dwell" (static_aging, of a start in stick). Zero where not given.
    max_step : float
        Longest step; what happens twice within an eighth of it could be overlooked.
    max_transitions : int
        Number of switchings at which the run is given up.
    """
    system = System(model, belt_speed)
    given = dict(hidden or {})
    start = [*map(float, initial), *(float(given.get(name, 0.0)) for name in system.names[system.d :])]
    z, side = system.start(np.array(start), given.get("dwell", 0.0))
    steps, kinks, changes = list[OdeStep](), list[tuple[float, str]](), list[Change]()
    t, message, recent = 0.0, "", list[float]()
    while t < t_end and not message:
        steps_before = len(steps)
        hit = leg(system, side, t, z, t_end, tol, max_step, steps)
        if isinstance(hit, str):
            message = hit
            break
        if hit is None:
            t, z = t_end, steps[-1].dense(t_end)
            break
        name, t, z = hit
        before = side.contact
        z, side = system.switch(name, t, z, side)
        if name in ("rest", "slip-", "slip+"):
            changes.append((t, z[: system.d], before, side.contact))
        else:
            kinks.append((t, name.rstrip("+-")))
        recent = [*recent, t] if len(steps) == steps_before else [t]
        if len(recent) > PILE_UP:
            message = f"switchings pile up at t = {t!r} ({name})"
        elif len(changes) + len(kinks) >= max_transitions:
            message = f"gave up at t = {t!r} after {max_transitions} switchings"
    return _collect(system, steps, (t, z, side), changes, kinks, message, t_eval)


def _collect(
    system: System,
    steps: list[OdeStep],
    last: tuple[float, Floats, Side],
    changes: list[Change],
    kinks: list[tuple[float, str]],
    message: str,
    t_eval: ArrayLike | None,
) -> Run:
    """Gather the arrays of a finished run."""
    d, (t, z, side) = system.d, last
    steps = [*steps, OdeStep(t, z, t, side, lambda _: z)]
    transitions = ModeChanges(
        np.array([c[0] for c in changes]),
        np.array([c[1] for c in changes]).reshape(-1, d),
        np.array([c[2] for c in changes], np.int64),
        np.array([c[3] for c in changes], np.int64),
    )
    status = RunStatus(not message, message or "reached t_end")
    times, states = np.array([s.t for s in steps]), np.array([s.z for s in steps])
    modes = np.array([s.side.contact for s in steps], np.int64)
    run = Run(times, states[:, :d], states[:, d:], modes, transitions, kinks, status, system, steps)
    if t_eval is None:
        return run
    times = np.asarray(t_eval, float)
    states, modes = run.at(times), run.mode_at(times)
    return Run(times, states[:, :d], states[:, d:], modes, transitions, kinks, status, system, steps)


def leg(
    system: Any,
    side: Any,
    t: float,
    z: Floats,
    t_end: float,
    tol: float,
    max_step: float,
    out: list[OdeStep],
) -> tuple[str, float, Floats] | str | None:
    """Integrate with the sides frozen until one ends (name, t, z), the run does (None), or it fails (why)."""
    flow = partial(system.field, side=side)
    solver = DOP853(flow, t, z, t_end, rtol=tol, atol=tol, max_step=max_step)
    guards, samples = system.guards(side), FIRST_SAMPLES
    while solver.t < t_end:
        start = solver.y.copy()
        trouble = solver.step()
        if trouble:
            return f"the integrator gave up at t = {solver.t!r}: {trouble}"
        step = OdeStep(float(solver.t_old), start, float(solver.t), side, solver.dense_output())
        hit = _first_switching(system, guards, step, samples)
        if hit is not None:
            if hit[1] > step.t:
                out.append(OdeStep(step.t, start, hit[1], side, step.dense))
            return hit
        out.append(step)
        samples = SAMPLES
    return None


def _first_switching(
    system: Any, guards: dict[str, Guard], step: OdeStep, samples: Floats
) -> tuple[str, float, Floats] | None:
    """Find the earliest switching within the step, and land on it."""
    times = step.t + samples * (step.end - step.t)
    times[-1] = step.end
    states = step.dense(times)
    hits = []
    for name, guard in guards.items():
        found = _bracket(system, guard, step, times, states)
        if found is not None:
            t, z = _land(system, guard, step, *found)
            hits.append((t, name, z))
    if not hits:
        return None
    t, name, z = min(hits, key=lambda hit: hit[0])
    return name, t, z


def _bracket(
    system: Any, guard: Guard, step: OdeStep, times: Floats, states: Floats
) -> tuple[float, float] | None:
    """Find times around the first upward crossing of the switching function, or None."""

    def slope(t: float) -> float:
        return float(system.rate(guard, t, step.dense(t), step.side))

    s = guard(times, states)
    rise = system.rate(guard, times, states, step.side)
    first = 0
    if s[0] > -ON_SURFACE:  # it starts on the surface: what matters is the side it leaves to
        away = np.flatnonzero(np.abs(s) > ON_SURFACE)
        if away.size == 0:
            return None
        first = int(away[0])
        if s[first] > 0:
            return step.t, step.t
    for j in range(first + 1, len(times)):
        if s[j] > 0:
            return float(times[j - 1]), float(times[j])
        if rise[j - 1] > 0 > rise[j]:  # a summit between two looks: does it rise above zero?
            top = float(brentq(slope, times[j - 1], times[j], xtol=1e-15))
            if guard(top, step.dense(top)) > 0:
                return float(times[j - 1]), top
    return None


def _land(system: Any, guard: Guard, step: OdeStep, a: float, b: float) -> tuple[float, Floats]:
    """Time and state where the switching function vanishes in [a, b]."""
    if a == b:
        return step.t, step.z
    looks = np.linspace(a, b, 9)
    rise = system.rate(guard, looks, step.dense(looks), step.side)
    if rise.min() > 1e-3 * rise.max():
        landed = _henon(system, guard, step.side, a, advance(system, step.side, step.t, step.z, a))
        if landed is not None and a - ON_SURFACE <= landed[0] <= b + ON_SURFACE:
            return landed

    def value(t: float) -> float:
        return float(guard(t, step.dense(t)))

    t = b if value(a) * value(b) > 0 else float(brentq(value, a, b, xtol=1e-15))
    return t, advance(system, step.side, step.t, step.z, t)


def _henon(system: Any, guard: Guard, side: Any, t: float, z: Floats) -> tuple[float, Floats] | None:
    """Step in S from S(t, z) < 0 to 0: dz/dS = f / f_S, dt/dS = 1 / f_S; repeat until |S| is rounding."""

    def by_surface(_: float, tz: Floats) -> Floats:
        rise = system.rate(guard, tz[0], tz[1:], side)
        return np.asarray(np.append(1.0, system.field(tz[0], tz[1:], side)) / rise)

    tz = np.append(t, z)
    for _ in range(4):
        s = float(guard(tz[0], tz[1:]))
        if abs(s) <= 1e-15:
            break
        found = solve_ivp(by_surface, (s, 0.0), tz, method="DOP853", rtol=1e-13, atol=1e-15)
        if not found.success:
            return None
        tz = found.y[:, -1]
    return float(tz[0]), np.asarray(tz[1:])


def advance(system: Any, side: Any, t: float, z: Floats, end: float) -> Floats:
    """State at `end`, from `t`, `z`, sides frozen."""
    if end == t:
        return z
    flow = partial(system.field, side=side)
    found = solve_ivp(flow, (t, end), z, method="DOP853", rtol=1e-13, atol=1e-14)
    if not found.success:
        raise ArithmeticError(f"the integrator gave up between t = {t!r} and {end!r}: {found.message}")
    return np.asarray(found.y[:, -1])


def readings(model: Model, run: Run, t: ArrayLike, *, interpolated: bool = False) -> Floats:
    """Return what the sensors show at the increasing times `t` (n,): x1, y1 (n, 2), or x1 alone (n, 1).

    x1 reads g(m) + r t and the curves of its channel, with g(x) = (1 + e) x + q x^2 and tau m' = x1 + c y1 - m,
    m(0) = x1(0) + c y1(0) as after rest (`simulate` starts from its own `initial`, m = 0 if none is given); y1 reads
    y1(t - delay), and y1(0) before that (the catalogue's sensor effects; nonlinearity after lag, drift last).
    `interpolated` takes states from within the run's steps, many times as quick and as exact as the run's tolerance.
    """
    effects, times = {e.name: e.parameters for e in model.effects}, np.asarray(t, float)
    two, c = run.system.two, effects.get("sensor_crosstalk", {"c": 0.0})["c"]

    def shown(z: Floats) -> Floats:
        return np.asarray(z[:, 0] + c * z[:, 2] if two else z[:, 0])

    def states(at: Floats) -> Floats:
        return run.at(at, interpolated)

    now = states(times)
    x: Floats = shown(now)
    if "sensor_lag" in effects:
        x = _lagged(lambda at: shown(states(at)), run, times, effects["sensor_lag"]["tau"])
    gain = 1 + effects.get("sensor_gain", {"e": 0.0})["e"]
    q = effects.get("sensor_nonlinearity", {"q": 0.0})["q"]
    x = gain * x + q * x**2
    if p := effects.get("sensor_drift"):
        x = x + p["r"] * times
    x = x + _learned(model, "x1 channel", now, times)
    if not two:
        return x[:, None]
    late = effects.get("sensor_delay", {"delay": 0.0})["delay"]
    y = states(np.maximum(times - late, 0.0))[:, 2]
    return np.column_stack([x, y + _learned(model, "y1 channel", now, times)])


def _learned(model: Model, channel: str, z: Floats, times: Floats) -> Floats:
    """What the learned curves of a channel add, each of a state or of time."""
    out = np.zeros(len(times))
    for one in model.effects:
        if isinstance(one, Tabulated) and one.where == channel:
            names = model.rig.state_names
            out += one.curve(times if one.variable == "t" else z[:, names.index(one.variable)])
    return out


def _lagged(signal: Callable[[Floats], Floats], run: Run, times: Floats, tau: float) -> Floats:
    """Integrate exp(-(t - a)/tau) signal(a)/tau over the past, by Gauss's rule on every smooth piece."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    ends = np.unique(np.concatenate([[0.0], [s.t for s in run.steps if s.t < times[-1]], times]))
    m = [float(signal(np.zeros(1))[0])]
    for a, b in pairwise(ends):
        at = a + (b - a) * (nodes + 1) / 2
        kernel = np.exp(-(b - at) / tau) * weights * (b - a) / (2 * tau)
        m.append(m[-1] * np.exp(-(b - a) / tau) + float(kernel @ signal(at)))
    return np.array(m)[np.searchsorted(ends, times)]
