"""The measurement chain: from simulated states to readings, with derivatives; the same for every hypothesis.

x1 reading: m + q m^2 + r t, m being x1 + c y1 or, where there is a lag, that lagged (the core's hidden state m).
y1 reading: y1 at t - delay; or, which has no name, lagged (y1_lag.tau). belt reading: the belt's own speed V.
Learned curves add g(variable) to a channel; formulas come last.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated, tabulated
from stickslip.declared.model import Model
from stickslip.fitted.formula_reading import READING, FormulaReading
from stickslip.simulated.states import AT, BELT, COUNT, LAGGED, RATE, X1, Y1, Y2
from stickslip.simulated.x1_sensor import X1Sensor, seen, seen_rate

Floats = NDArray[np.float64]
_CHANNEL = {"x1": 0, "y1": 1, "belt": 2}
Y1_LAG = "y1_lag.tau"  # of a lag of the y1 reading, which is on no list
NEARBY = 1e-5  # of tau: step of its derivative


@dataclass(frozen=True)
class ReadingCurve:
    """A smooth curve added to a channel's reading: natural cubic spline through unknown values at knots.

    `channel` is "x1", "y1" or "belt"; `variable` "x1", "x2", "y1", "y2" or "t". One that `recurs` is the periodic
    spline in (w t + phi)/(2 pi), its knots from 0 to 1; its first value is 0 unless it is given.
    """

    channel: str
    variable: str
    knots: tuple[float, ...]
    recurs: bool = False

    @property
    def name(self) -> str:
        """Prefix of its parameters."""
        return f"learned_{self.channel}_{self.variable}"

    def values(self, p: Mapping[str, float]) -> Floats:
        """Values at its knots, (k,), among parameters by name."""
        if self.recurs:
            first = p.get(f"{self.name}.value_0", 0.0)
            inner = (p[f"{self.name}.value_{i}"] for i in range(1, len(self.knots) - 1))
            return np.array([first, *inner, first])
        return np.array([p[f"{self.name}.value_{i}"] for i in range(len(self.knots))])

    def at(self, t: Floats, state: Floats, p: Mapping[str, float]) -> Floats:
        """What it depends on, (n,), at times and states (n, 9)."""
        if self.recurs:
            return np.asarray((p[f"{self.name}.w"] * t + p[f"{self.name}.phi"]) / (2 * np.pi) % 1.0)
        return t if self.variable == "t" else state[:, AT[self.variable]]

    def basis(self, x: Floats, derivative: int = 0) -> Floats:
        """Value of each knot's cardinal spline, (n, k); held constant outside."""
        if self.recurs:
            return np.asarray(_cardinal_turn(self.knots)(x, derivative))
        inside = np.clip(x, self.knots[0], self.knots[-1])
        out = np.asarray(_cardinal(self.knots)(inside, derivative))
        return out if derivative == 0 else np.where((x == inside)[:, None], out, 0.0)


@lru_cache(maxsize=64)
def _cardinal(knots: tuple[float, ...]) -> scipy.interpolate.CubicSpline:
    """The natural splines that are 1 at one knot and 0 at the others; a fit asks for them at every step."""
    return scipy.interpolate.CubicSpline(knots, np.eye(len(knots)), bc_type="natural")


@lru_cache(maxsize=64)
def _cardinal_turn(knots: tuple[float, ...]) -> scipy.interpolate.CubicSpline:
    """The periodic splines; the first is 1 at both ends, and the last is none."""
    ends = np.eye(len(knots))
    ends[-1] = ends[0]
    ends[:, -1] = 0.0
    return scipy.interpolate.CubicSpline(knots, ends, bc_type="periodic")


Added = ReadingCurve | FormulaReading  # what a model's channels have beside the effects of the catalogue


def curves_of(model: Model) -> tuple[ReadingCurve, ...]:
    """The curves that a model adds to its readings; their values are among its parameters."""
    terms = [one for one in model.effects if isinstance(one, Tabulated) and one.of_reading]
    return tuple(
        ReadingCurve(one.where[:2], one.variable, one.knots)
        if one.period is None
        else ReadingCurve(
            one.where[:2], one.variable, tuple(k / one.knots[-1] for k in one.knots), recurs=True
        )
        for one in terms
    )


def as_terms(learned: Sequence[ReadingCurve], values: Mapping[str, float]) -> tuple[Tabulated, ...]:
    """Curves on readings as a model holds them; `values` by name, `learned_x1_y1.value_0` and so on."""
    return tuple(_as_term(one, values) for one in learned)


def _as_term(one: ReadingCurve, values: Mapping[str, float]) -> Tabulated:
    where, numbers = f"{one.channel} channel", one.values(values)
    if not one.recurs:
        return tabulated(where, one.variable, one.knots, numbers)
    period = 2 * np.pi / values[f"{one.name}.w"]
    knots = (*(period * k for k in one.knots[:-1]), period)
    return tabulated(where, one.variable, knots, numbers, period=period, phi=values[f"{one.name}.phi"])


@dataclass
class Chain:
    """Readings (n, c) and their derivatives (n, c, p) at one window, `names` naming the p columns."""

    values: Floats
    slopes: Floats


Slopes = Mapping[int, Floats]  # of a state by its index, (n, k)


def no_slopes(n: int) -> Slopes:
    """Slopes without columns, for readings alone."""
    return dict.fromkeys(range(COUNT), np.empty((n, 0)))


@dataclass
class _ChainStates:
    """What the chain reads: times (n,), states (n, 9), their slopes, parameters by name; and the chain it fills."""

    t: Floats
    state: Floats
    slopes: Slopes
    p: Mapping[str, float]
    names: tuple[str, ...]
    out: Chain

    def add(self, channel: int, name: str, slope: Floats) -> None:
        """Add to the derivative of a channel with respect to a parameter, if that is asked for."""
        if name in self.names:
            self.out.slopes[:, channel, self.names.index(name)] += slope


def states_read(known: Collection[str], channels: int, learned: tuple[Added, ...] = ()) -> list[int]:
    """States whose sensitivities the chain of effects with the `known` parameters needs."""
    needed = {AT[one.variable] for one in learned if isinstance(one, ReadingCurve) and one.variable != "t"}
    needed |= {k for one in learned if isinstance(one, FormulaReading) for k in one.states}
    needed |= {LAGGED} if "sensor_lag.tau" in known else {X1}
    needed |= {Y1, Y2} if "sensor_delay.delay" in known or Y1_LAG in known else {Y1}
    return sorted(needed | ({BELT} if channels == 3 else set()))


def read(
    t: Floats,
    state: Floats,
    sensitivity: Slopes,
    names: tuple[str, ...],
    p: Mapping[str, float],
    belt_speed: float | Floats,
    channels: int,
    learned: tuple[Added, ...] = (),
    offset: NDArray[np.int64] | None = None,
) -> Chain:
    """Readings from states (n, 9) and the sensitivities (n, k) of those of them that `states_read` names.

    `names` names the sensitivities' columns; those of reading effects are filled in here, their columns in
    `sensitivity` must be zero (or what reaches them through the lag). Samples of several windows follow one another,
    each from its `offset` on, so that a delay does not look from one into the next. One channel is x1 alone. The belt's
    speed, and numbers that runs have for themselves, may be (n,).
    """
    out = Chain(np.empty((len(t), channels)), np.zeros((len(t), channels, len(names))))
    samples = _ChainStates(t, state, sensitivity, p, names, out)
    _read_x1(samples)
    if channels > 1:
        _read_y1(samples, np.array([0, len(t)]) if offset is None else offset)
    if channels == 3:
        _read_belt(samples, belt_speed)
    for one in learned:
        beside(out, one, t, state, sensitivity, names, p)
    return out


def beside(
    out: Chain,
    one: Added,
    t: Floats,
    state: Floats,
    sensitivity: Slopes,
    names: tuple[str, ...],
    p: Mapping[str, float],
) -> None:
    """Let a channel of a chain have what it has beside the effects of the catalogue: a curve, or a formula."""
    samples = _ChainStates(t, state, sensitivity, p, names, out)
    if isinstance(one, ReadingCurve):
        _add_curve(samples, one)
    else:
        _through_formula(samples, one)


def _through_formula(s: _ChainStates, one: FormulaReading) -> None:
    c, out = _CHANNEL[one.channel], s.out
    of = one.at(out.values[:, c].copy(), s.t, s.state, s.p)
    slopes = out.slopes[:, c] * one.slope(READING, of, s.t.shape)[:, None]
    for name in one.slopes:
        along = one.slope(name, of, s.t.shape)
        if name in AT:
            slopes += along[:, None] * s.slopes[AT[name]]
        elif (full := f"{one.effect.label}.{name}") in s.names:
            slopes[:, s.names.index(full)] += along
    out.values[:, c], out.slopes[:, c] = one.read(of, s.t.shape), slopes


def _read_x1(s: _ChainStates) -> None:
    """Crosstalk, the lag of what it makes, the curvature of that, drift."""
    c = s.p.get("sensor_crosstalk.c", 0.0)
    late = "sensor_lag.tau" in s.p
    slopes = s.slopes[LAGGED] if late else s.slopes[X1]
    if c and not late:
        slopes = slopes + c * s.slopes[Y1]
    sensor, m = X1Sensor.acting(s.p), seen(s.p, s.state)
    steepness = sensor.slope(m)
    s.out.values[:, 0] = sensor.of(m, s.t)
    s.out.slopes[:, 0] = slopes if (steepness == 1).all() else slopes * steepness[:, None]
    if not late:
        s.add(0, "sensor_crosstalk.c", s.state[:, Y1] * steepness)
    s.add(0, "sensor_gain.e", m)
    s.add(0, "sensor_nonlinearity.q", m**2)
    s.add(0, "sensor_drift.r", s.t)


def _read_y1(s: _ChainStates, offset: NDArray[np.int64]) -> None:
    if Y1_LAG in s.p:
        _lag_y1(s, offset)
        return
    if "sensor_delay.delay" not in s.p:
        s.out.values[:, 1] = s.state[:, Y1]
        s.out.slopes[:, 1] = s.slopes[Y1]
        return
    passed = np.empty(len(s.t))
    for a, b in itertools.pairwise(offset.tolist()):
        weights, rates = _late(s.t[a:b], s.p["sensor_delay.delay"])
        y1, y2 = s.state[a:b, Y1], s.state[a:b, Y2]
        s.out.values[a:b, 1] = weights.apply(y1, y2)
        s.out.slopes[a:b, 1] = weights.apply(s.slopes[Y1][a:b], s.slopes[Y2][a:b])
        passed[a:b] = rates.apply(y1, y2)
    s.add(1, "sensor_delay.delay", -passed)


def _lag_y1(s: _ChainStates, offset: NDArray[np.int64]) -> None:
    tau, step, passed = s.p[Y1_LAG], NEARBY * s.p[Y1_LAG], np.empty(len(s.t))
    for a, b in itertools.pairwise(offset.tolist()):
        t, y1, y2 = s.t[a:b], s.state[a:b, Y1], s.state[a:b, Y2]
        s.out.values[a:b, 1] = lagged(t, y1, y2, tau)
        s.out.slopes[a:b, 1] = lagged(t, s.slopes[Y1][a:b], s.slopes[Y2][a:b], tau)
        passed[a:b] = (lagged(t, y1, y2, tau + step) - lagged(t, y1, y2, tau - step)) / (2 * step)
    s.add(1, Y1_LAG, passed)


def lagged(t: Floats, y: Floats, rate: Floats, tau: float) -> Floats:
    """m of tau m' = y - m at the samples, y between them Hermite's cubic; (n,) or slopes (n, k).

    At the first sample m is what it is where y has been smooth for long: y - tau y' + tau^2 y'' - ..., to the third
    derivative.
    """
    h = np.diff(t)
    a = h / tau
    i0 = -np.expm1(-a)  # of u^n over the interval, seen through the lag
    i1 = 1 - i0 / a
    i2 = 1 - 2 * i1 / a
    i3 = 1 - 3 * i2 / a
    shape = (-1,) + (1,) * (y.ndim - 1)
    w = [
        c.reshape(shape)
        for c in (i0 - 3 * i2 + 2 * i3, (i1 - 2 * i2 + i3) * h, 3 * i2 - 2 * i3, (i3 - i2) * h)
    ]
    comes = w[0] * y[:-1] + w[1] * rate[:-1] + w[2] * y[1:] + w[3] * rate[1:]
    keeps = np.exp(-a)
    second = (rate[1] - rate[0]) / h[0]
    third = 2 * ((rate[2] - rate[1]) / h[1] - second) / (h[0] + h[1]) if len(t) > 2 else 0.0 * second
    out = np.empty_like(y)
    out[0] = y[0] - tau * rate[0] + tau**2 * (second - 0.5 * h[0] * third) - tau**3 * third
    for i in range(len(h)):
        out[i + 1] = keeps[i] * out[i] + comes[i]
    return out


@dataclass
class _Gather:
    """A linear rule on (y1, y2) at two neighbouring samples."""

    left: NDArray[np.int64]
    w: Floats  # (n, 4): y1 left, y2 left, y1 right, y2 right

    def apply(self, y1: Floats, y2: Floats) -> Floats:
        """On values (n,) or on slopes (n, k)."""
        w = self.w.reshape(self.w.shape + (1,) * (y1.ndim - 1))
        a, b = self.left, self.left + 1
        return np.asarray(w[:, 0] * y1[a] + w[:, 1] * y2[a] + w[:, 2] * y1[b] + w[:, 3] * y2[b])


def _late(t: Floats, delay: float) -> tuple[_Gather, _Gather]:
    """y1 and its rate at t - delay by Hermite's cubic (error h^4/384 y1''''), by Taylor beyond the ends."""
    at = t - delay
    left = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    h = t[left + 1] - t[left]
    s = (at - t[left]) / h
    w = np.stack(
        [(1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2 * h, s**2 * (3 - 2 * s), s**2 * (s - 1) * h], 1
    )
    zero = 6 * s * (s - 1) / h
    r = np.stack([zero, (1 - s) * (1 - 3 * s), -zero, s * (3 * s - 2)], 1)
    for ends, near, offset in ((at < t[0], 0, at - t[0]), (at > t[-1], 2, at - t[-1])):
        d, hh = offset[ends], h[ends]
        w[ends], r[ends] = 0.0, 0.0
        w[ends, near], w[ends, near + 1] = 1.0, d
        w[ends, 1] -= d**2 / (2 * hh)
        w[ends, 3] += d**2 / (2 * hh)
        r[ends, near + 1] = 1.0
        r[ends, 1] -= d / hh
        r[ends, 3] += d / hh
    return _Gather(left, w), _Gather(left, r)


def _read_belt(s: _ChainStates, v_b: float | Floats) -> None:
    s.out.values[:, 2] = v_b + s.state[:, BELT]
    s.out.slopes[:, 2] = s.slopes[BELT]
    if "belt_speed_ripple.a" not in s.p:
        return
    a, w, phi = (s.p[f"belt_speed_ripple.{key}"] for key in ("a", "w", "phi"))
    sine, cosine = np.sin(w * s.t + phi), np.cos(w * s.t + phi)
    s.out.values[:, 2] += v_b * a * sine
    for key, slope in (("a", sine), ("w", a * s.t * cosine), ("phi", a * cosine)):
        s.add(2, f"belt_speed_ripple.{key}", v_b * slope)


def _add_curve(s: _ChainStates, curve: ReadingCurve) -> None:
    channel = _CHANNEL[curve.channel]
    if channel >= s.out.values.shape[1]:
        return
    names = [f"{curve.name}.value_{i}" for i in range(len(curve.knots))]
    values = curve.values(s.p)
    x = curve.at(s.t, s.state, s.p)
    basis = curve.basis(x)
    s.out.values[:, channel] += basis @ values
    if curve.recurs:
        turning = curve.basis(x, 1) @ values / (2 * np.pi)
        s.add(channel, f"{curve.name}.w", s.t * turning)
        s.add(channel, f"{curve.name}.phi", turning)
    elif curve.variable != "t":
        rate = curve.basis(x, 1) @ values
        s.out.slopes[:, channel] += rate[:, None] * s.slopes[AT[curve.variable]]
    for i, name in enumerate(names):
        s.add(channel, name, basis[:, i])


def reading_rate(t: Floats, state: Floats, p: Mapping[str, float], learned: Sequence[Added] = ()) -> Floats:
    """d(x1 reading)/dt from the states of one simulation, for every effect and curve of the x1 channel.

    The portrait is drawn of readings, so the velocity must be theirs: that of a lagged m is (x1 + c y1 - m)/tau. The
    accelerations that a curve in a velocity asks for are differences of the velocities.

    Parameters
    ----------
    t : (n,) times within the run.
    state : (n, 9) states, hidden ones included.
    p : parameters by name, those of curves included.
    """
    sensor, m = X1Sensor.acting(p), seen(p, state)
    rate, reading = sensor.rate(m, seen_rate(p, state)), sensor.of(m, t)
    for one in learned:
        if one.channel != "x1":
            continue
        if isinstance(one, FormulaReading):
            of = one.at(reading, t, state, p)
            rate, reading = one.rate(rate, of, state), one.read(of, t.shape)
            continue
        reading = reading + one.basis(one.at(t, state, p)) @ one.values(p)
        rate = rate + (one.basis(one.at(t, state, p), 1) @ one.values(p)) * _moves(one, t, state, p)
    return np.asarray(rate)


def _moves(curve: ReadingCurve, t: Floats, state: Floats, p: Mapping[str, float]) -> Floats:
    """Rate of what a curve depends on, (n,)."""
    if curve.recurs:
        return np.full(len(t), p[f"{curve.name}.w"] / (2 * np.pi))
    if curve.variable == "t":
        return np.ones(len(t))
    at = AT[curve.variable]
    if at in RATE:
        return state[:, RATE[at]]
    return np.asarray(np.gradient(state[:, at], t)) if len(t) > 1 else np.zeros(len(t))
