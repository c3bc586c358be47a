"""Displacement, velocity and acceleration by a smoother that knows of stick and slip."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained
from stickslip.errors import InputError
from stickslip.measured.signals._input import Floats, finite, finite_vector, positive
from stickslip.measured.signals._pieces import PieceLayout
from stickslip.measured.signals._segments import (
    Record,
    best_jerk,
    first_layout,
    fit,
    instant_std,
    make_layout,
    prune,
    refine,
    window_length,
)
from stickslip.measured.signals._solve import SplineSolution, selected_inverse, variances
from stickslip.measured.signals.quality import noise_std, quantisation


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Estimates at the samples, and where the channel stuck.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times of the samples used.
    x, v, a : ndarray, shape (n,)
        Displacement, velocity, acceleration.
    x_std, v_std, a_std : ndarray, shape (n,)
        Their standard deviations, with what the doubt about the instants near by adds.
    mode : ndarray of int8, shape (n,), or None
        0 stick, -1 slip with ``v_w < 0``, +1 slip with ``v_w > 0``; None without a belt.
    sticks : ndarray, shape (k, 2)
        Capture and onset of every stick; the record's ends cut the first and the last.
    slips : ndarray, shape (m, 2)
        Begin and end of every slip in one direction.
    slip_direction : ndarray of int8, shape (m,)
        Sign of v_w in each slip.
    onsets, captures : ndarray
        Instants of onset of slip and of capture inside the record, reversals without stick left out.
    onset_std, capture_std : ndarray
        Standard deviations of these instants [time].
    noise : float
        Standard deviation of the noise that was given or estimated.
    jerk : float
        Spectral density of the third derivative that the evidence chose [x^2/time^5].
    min_dwell : float
        Sticks shorter than this may go unnoticed [time].

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import data, signals
    >>> t, x = data.stick_slip()  # s, m; the belt runs at 0.01 m/s
    >>> found = signals.smooth(t, x, belt_speed=0.01)
    >>> print(f"{np.mean(found.mode == 0):.0%} of the samples stick")
    75% of the samples stick
    >>> print(f"the first onset is known to {1e3 * found.onset_std[0]:.1f} ms")
    the first onset is known to 0.3 ms
    """

    t: Floats
    x: Floats
    v: Floats
    a: Floats
    x_std: Floats
    v_std: Floats
    a_std: Floats
    mode: NDArray[np.int8] | None
    sticks: Floats
    slips: Floats
    slip_direction: NDArray[np.int8]
    onsets: Floats
    captures: Floats
    onset_std: Floats
    capture_std: Floats
    noise: float
    jerk: float
    min_dwell: float
    _solution: SplineSolution = field(repr=False)
    _belt: _Belt = field(repr=False)

    def evaluate(self, t: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Displacement, velocity and acceleration at any times within the record.

        Parameters
        ----------
        t : array_like, shape (k,)

        Returns
        -------
        x, v, a : ndarray, shape (k,)

        Raises
        ------
        InputError
            If a time lies outside the record.
        """
        times = finite_vector(t, "t")
        if times.size and (times.min() < self.t[0] or times.max() > self.t[-1]):
            raise InputError(f"t must lie within the record, {self.t[0]:g} to {self.t[-1]:g}")
        x, v, a = (self._solution.at(times, order) for order in range(3))
        moved, speed, change = self._belt.at(times)
        return x + moved, v + speed, a + change


@dataclass(frozen=True, eq=False)
class _Belt:
    """Motion of the belt: displacement, speed and acceleration at any time."""

    start: float
    speed: float
    measured: scipy.interpolate.CubicSpline | None = None
    std: Floats | None = None

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        if self.measured is None:
            return self.speed * (t - self.start), np.full(t.shape, self.speed), np.zeros(t.shape)
        moved = self.measured.antiderivative()
        return np.asarray(moved(t)), np.asarray(self.measured(t)), np.asarray(self.measured(t, 1))


_ROUNDS = 8


@explained
def smooth(
    t: ArrayLike,
    x: ArrayLike,
    *,
    belt_speed: float | None = None,
    belt: ArrayLike | None = None,
    noise: float | None = None,
    stick_speed: float = 0.0,
    outliers: ArrayLike | None = None,
) -> Smoothed:
    """Smooth a channel without blurring onsets of slip and captures.

    Parameters
    ----------
    t : array_like, shape (n,)
        Increasing times, at any spacing; n >= 12.
    x : array_like, shape (n,)
        Displacement.
    belt_speed : float, optional
        Constant speed of the belt [unit of x / time].
    belt : array_like, shape (n,), optional
        Measured belt speed, noise and all; used instead of `belt_speed`.
        Without either the channel has no sticks (the angle body): one smoothing spline throughout.
    noise : float, optional
        Standard deviation of the white noise on `x`; by default `noise_std` and the rounding.
    stick_speed : float
        Standard deviation of the speed against the belt that still counts as stick: for a belt speed
        known only so well, or a contact that creeps. 0: sticks move exactly with the belt.
    outliers : array_like of bool, shape (n,), optional
        Samples to leave out, as `find_glitches` marks them.

    Returns
    -------
    Smoothed
        With the samples left out missing from its arrays.

    Raises
    ------
    InputError
        On arrays of different shapes, samples that are not finite, times that do not increase.

    Notes
    -----
    In the belt's frame a stick is a constant. A slip is a curve with a third derivative that is white
    noise (a quintic spline with a penalty on ``(x''')^2``) which leaves its stick and reaches the next
    one at zero speed against the belt; its acceleration may jump at either end. Sticks are first found
    where a window is constant to within its noise; then every instant is moved, to a fraction of the
    sampling interval, to where the evidence (likelihood with the curve integrated out) is greatest, as
    is the density of the third derivative. A slip whose speed against the belt changes sign is split
    there, and its acceleration may jump there too, as friction turns over at once.

    References
    ----------
    Wahba, J. R. Stat. Soc. B 40 (1978) 364: splines as estimates of an integrated Wiener process.
    Takahashi, Fagan, Chen, 8th PICA Conf. (1973) 63: the band of the inverse, for standard deviations.

    Examples
    --------
    >>> import numpy as np
    >>> from stickslip import data, signals
    >>> t, x = data.stick_slip()  # s, m; the belt runs at 0.01 m/s
    >>> found = signals.smooth(t, x, belt_speed=0.01)
    >>> print(f"the slips begin at {found.onsets[:3].round(3)} s")
    the slips begin at [0.4   0.832 1.264] s
    >>> print(f"greatest speed {np.abs(found.v).max():.4f} m/s")
    greatest speed 0.0518 m/s
    """
    times, values = _samples(t, x, outliers)
    if not (np.isfinite(stick_speed) and stick_speed >= 0.0):
        raise InputError(f"stick_speed must be a number >= 0, not {stick_speed}")
    sigma = _noise(times, values, noise)
    motion, has_belt = _belt(t, times, belt_speed, belt, outliers)
    moved, speed, _ = motion.at(times)
    dt = float(np.median(np.diff(times)))
    typical = float(np.median(np.abs(speed))) or float(np.ptp(values)) / (times[-1] - times[0])
    window = window_length(times.size, dt, sigma, typical)
    record = Record(times, values - moved, sigma, float(stick_speed), window)
    layout, jerk = _segment(record, has_belt)
    return _result(record, fit(record, layout, jerk), motion, jerk, has_belt)


def _samples(t: ArrayLike, x: ArrayLike, outliers: ArrayLike | None) -> tuple[Floats, Floats]:
    times, values = finite_vector(t, "t"), finite_vector(x, "x")
    if times.shape != values.shape:
        raise InputError(f"t and x must have one shape, not {times.shape} and {values.shape}")
    step = np.diff(times)
    if not (step > 0.0).all():
        at = int(np.argmin(step > 0.0)) + 1
        raise InputError(f"t must increase; t[{at}] = {times[at]} follows {times[at - 1]}")
    if outliers is not None:
        out = np.asarray(outliers, dtype=np.bool_)
        if out.shape != times.shape:
            raise InputError(f"outliers must have the shape of x, {times.shape}, not {out.shape}")
        times, values = times[~out], values[~out]
    if times.size < 12:
        raise InputError(f"x has {times.size} samples to use; at least 12 are needed")
    return times, values


def _noise(t: Floats, x: Floats, given: float | None) -> float:
    if given is not None:
        return positive(given, "noise")
    sigma = max(noise_std(x, t=t, cut=6.0), quantisation(x).noise)  # its tails count here
    return sigma if sigma > 0.0 else 1e-9 * (float(np.ptp(x)) or 1.0)


def _belt(
    t: ArrayLike, kept: Floats, belt_speed: float | None, belt: ArrayLike | None, outliers: ArrayLike | None
) -> tuple[_Belt, bool]:
    if belt is not None:
        quiet = smooth(t, belt, outliers=outliers)
        return _Belt(kept[0], 0.0, scipy.interpolate.CubicSpline(quiet.t, quiet.x), quiet.x_std), True
    if belt_speed is None:
        return _Belt(kept[0], 0.0), False
    return _Belt(kept[0], finite(belt_speed, "belt_speed")), True


def _segment(record: Record, has_belt: bool) -> tuple[PieceLayout, float]:
    nothing = np.zeros(0)
    if not has_belt:
        layout = make_layout(record.t, nothing, nothing)
        return layout, best_jerk(record, layout)
    layout = first_layout(record)
    if layout.intervals.size == 0:
        return layout, 1.0
    jerk = best_jerk(record, layout)
    coarse = record.window / 3.0
    for _ in range(_ROUNDS):  # blurred instants look like jerk, and jerk hides instants: in turn
        layout = refine(record, layout, jerk, coarse=coarse, fine=0.5)
        layout = prune(record, _reversals(record, layout, jerk), jerk)
        before, jerk, coarse = jerk, best_jerk(record, layout, jerk), max(2.0, record.window / 8.0)
        if abs(jerk / before - 1.0) < 0.2:
            break
    layout = refine(record, layout, jerk, coarse=1.0, fine=0.1)
    return layout, best_jerk(record, layout, jerk)


def _turns(record: Record, solution: SplineSolution) -> Floats:
    """Instants within slips at which the speed against the belt changes sign beyond doubt."""
    index, weight = solution.system.rows(record.t, 1)
    v = solution.at(record.t, 1)
    std = np.sqrt(variances(index, weight, selected_inverse(solution.factor)))
    slip = solution.system.place(record.t)
    sure = np.flatnonzero((np.abs(v) > 5.0 * std) & (slip >= 0))
    before, after = sure[:-1], sure[1:]
    ends, room = solution.system.slips[slip[before]], 3.0 * record.dt
    turn = (slip[before] == slip[after]) & (v[before] * v[after] < 0.0)
    turn &= (record.t[before] > ends[:, 0] + room) & (record.t[after] < ends[:, 1] - room)
    before, after = before[turn], after[turn]
    share = v[before] / (v[before] - v[after])
    return np.asarray(record.t[before] + share * (record.t[after] - record.t[before]))


def _reversals(record: Record, layout: PieceLayout, jerk: float) -> PieceLayout:
    """Let the acceleration jump wherever a slip turns over: the friction may."""
    when = _turns(record, fit(record, layout, jerk))
    capture, onset = np.append(layout.capture, when), np.append(layout.onset, when)
    order = np.argsort(capture, kind="stable")
    return make_layout(record.t, capture[order], onset[order])


def _slips(record: Record, solution: SplineSolution) -> tuple[Floats, NDArray[np.int8], NDArray[np.int8]]:
    """Slips cut where they turn over, their directions, and the mode at every sample."""
    slips, turns = solution.system.slips, _turns(record, solution)
    begin, end = np.sort(np.append(slips[:, 0], turns)), np.sort(np.append(slips[:, 1], turns))
    direction = np.sign(solution.at(end) - solution.at(begin)).astype(np.int8)
    inside = solution.system.place(record.t) >= 0
    part = np.clip(np.searchsorted(begin, record.t, side="right") - 1, 0, None)
    mode = np.where(inside, np.append(direction, 0)[part], 0).astype(np.int8)
    return np.column_stack([begin, end]), direction, mode


def _blur(
    record: Record, solution: SplineSolution, instants: Floats, std: Floats, side: float, spread: list[Floats]
) -> None:
    """Add what not knowing an instant exactly does to velocity and acceleration near it."""
    if instants.size == 0:
        return
    within = side * np.minimum(1e-6 * record.dt, 0.25 * np.min(np.ptp(solution.system.slips, axis=1)))
    edge = np.clip(instants + within, record.t[0], record.t[-1])
    jump = solution.at(edge, 2)
    for instant, doubt, change in zip(instants, std, jump, strict=True):
        near = slice(*np.searchsorted(record.t, [instant - 4.0 * doubt, instant + 4.0 * doubt]))
        off = (record.t[near] - instant) / doubt
        late = scipy.special.ndtr(off)
        spread[2][near] = np.hypot(spread[2][near], np.abs(change) * np.sqrt(late * (1.0 - late)))
        spread[1][near] = np.hypot(spread[1][near], np.abs(change) * doubt * np.exp(-0.25 * off**2))


def _result(record: Record, solution: SplineSolution, motion: _Belt, jerk: float, has_belt: bool) -> Smoothed:
    layout = solution.system.layout
    inverse = selected_inverse(solution.factor)
    moved, speed, change = motion.at(record.t)
    values, spread = [], []
    for order, belt in enumerate((moved, speed, change)):
        index, weight = solution.system.rows(record.t, order)
        values.append(solution.at(record.t, order) + belt)
        spread.append(np.sqrt(variances(index, weight, inverse)))
    if motion.std is not None:
        spread[1] = np.hypot(spread[1], motion.std)
    inside = layout.capture > layout.first, layout.onset < layout.last
    capture_std = instant_std(record, layout, jerk, "capture")
    onset_std = instant_std(record, layout, jerk, "onset")
    _blur(record, solution, layout.capture[inside[0]], capture_std[inside[0]], -1.0, spread)
    _blur(record, solution, layout.onset[inside[1]], onset_std[inside[1]], 1.0, spread)
    slips, direction, mode = _slips(record, solution)
    stuck = layout.onset > layout.capture
    return Smoothed(
        t=record.t,
        x=values[0],
        v=values[1],
        a=values[2],
        x_std=spread[0],
        v_std=spread[1],
        a_std=spread[2],
        mode=mode if has_belt else None,
        sticks=np.column_stack([layout.capture, layout.onset])[stuck],
        slips=slips,
        slip_direction=direction,
        onsets=layout.onset[stuck & inside[1]],
        captures=layout.capture[stuck & inside[0]],
        onset_std=onset_std[stuck & inside[1]],
        capture_std=capture_std[stuck & inside[0]],
        noise=record.sigma,
        jerk=jerk,
        min_dwell=record.window * record.dt,
        _solution=solution,
        _belt=motion,
    )
