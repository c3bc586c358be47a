"""Stretches of a run from mid-stick to mid-stick, one breakaway and one slip whole in each; else of a cycle."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.fitted.data import Data, velocity_width
from stickslip.likelihoods.motion import WindowMotion
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.measured.intervals import intervals
from stickslip.measured.stick_speed import ridden_speed
from stickslip.measured.sticks import BROKEN, CREEP, SURE, passes_by, rides, velocity_noise

Floats = NDArray[np.float64]
LONG = 15.0  # radians of a stick's either end that a stretch holds
GLITCH = 5  # samples whose median knows nothing of one or two that stand out
SEEN = 3  # filters of a velocity that a stick between two slips must hold
SOONEST, LATEST = 0.002, 0.998  # quantiles of the readings that the way slipped lies between


@dataclass(frozen=True)
class Stretch:
    """
    Samples start <= i < stop of a run.

    Parameters
    ----------
    run, start, stop : where it is
    dwell : time that the block has stuck at its first sample
    rest : how long that stick lasts in all
    stuck : whether it begins in a stick
    """

    run: int
    start: int
    stop: int
    dwell: float
    rest: float
    stuck: bool = True


@dataclass(frozen=True)
class _Cut:
    """Where a stretch ends in a stick, and where the next begins."""

    end: int | None  # None where it does not stick at a force that it knows
    begin: int
    dwell: float
    rest: float


def stretches(data: Sequence[Data], policy: Policy = POLICY) -> list[Stretch]:
    """
    Return the stretches of all runs.

    A cycle without a clear stick ends none and begins none: a block that swings up to nearly the belt's speed passes
    it by. Sticks are sought at the belt's speed as declared, and at the rate at which the run rises most; the one that
    shows more is taken. In a run that never sticks every cycle from fastest slip to fastest slip is a stretch; between
    sticks a cycle may have two events in it, each with friction of its own.
    """
    every = [
        max(_stuck(number, run, policy), _stuck(number, ridden, policy), key=len)
        for number, (run, ridden) in enumerate(zip(data, _as_ridden(data), strict=True))
    ]
    return [one for number, some in enumerate(every) for one in some or _cycles(number, data[number], policy)]


def _as_ridden(data: Sequence[Data]) -> list[Data]:
    """
    Return the runs with the rate at which their sticks rise for the belt's speed.

    A set-point, a gain or a spring may be off by as much as sets a stick apart from a swing. A run whose own rate does
    not stand out rises as the others do.
    """
    shares = [_share(run) for run in data]
    known = [one for one in shares if one is not None]
    usual = float(np.median(known)) if known else 1.0
    told = [usual if one is None else one for one in shares]
    return [replace(run, belt_speed=one * run.belt_speed) for run, one in zip(data, told, strict=True)]


def _share(run: Data) -> float | None:
    """The rate at which the sticks of a run rise over its belt's speed; None where none stands out."""
    if not run.belt_speed or not len(run.slips):
        return None
    rate = ridden_speed(run.t, run.readings[:, 0], run.cycle)
    return rate / run.belt_speed if rate is not None and rate * run.belt_speed > 0 else None


def _stuck(number: int, run: Data, policy: Policy) -> list[Stretch]:
    """The stretches of a run from stick to stick."""
    slips = run.slips.tolist()
    cuts = [_middle(run, three, policy) for three in zip([0, *slips], slips, slips[1:], strict=False)]
    return [
        Stretch(number, one.begin, other.end, one.dwell, one.rest)
        for one, other in itertools.pairwise(cuts)
        if one is not None and other is not None and other.end is not None
    ]


def _cycles(number: int, run: Data, policy: Policy) -> list[Stretch]:
    """
    The cycles of a run from fastest slip to fastest slip, in which a swing stands out from the noise.

    Where swings have died away the next one that is seen may be far: no friction of one event lasts until then.
    """
    dt, noise = float(np.median(np.diff(run.t))), float(run.noise[0])
    sure = SURE * velocity_noise(velocity_width(run.t, noise, run.belt_speed), dt, noise)
    return [
        Stretch(number, a, b, 0.0, 0.0, stuck=False)
        for a, b in itertools.pairwise(run.slips.tolist())
        if b - a >= policy.fewest_stuck
        and run.t[b] - run.t[a] < 2 * run.cycle
        and np.ptp(run.v[a:b]) > 2 * sure
    ]


def _middle(run: Data, slips: tuple[int, int, int], policy: Policy) -> _Cut | None:
    """
    Return the middle of the longest stick between the last two of three slips; noise may break it for a sample or two.

    A block alone may stick at a force that it has just slipped at, where friction differs much: the first of the two
    events knows nothing of that, and ends before. Of a long stick the middle says no more: it is left out.
    """
    before, first, last = slips
    sticks = first + intervals(rides(_velocity(run, first, last), run.belt_speed), BROKEN)
    if not len(sticks):
        return None
    a, b = sticks[np.argmax(sticks[:, 1] - sticks[:, 0])].tolist()
    if not _clear(run, a, b, policy):
        return None
    clear = [(c, d) for c, d in sticks.tolist() if (c, d) == (a, b) or _clear(run, c, d, policy)]
    least = policy.fewest_stuck
    known = _passed(run, before, first, clear[0][0], last) if run.readings.shape[1] == 1 else last
    ends = [(c, min(d, max(known, c + least))) for c, d in clear if c + least <= known or d <= known]
    longest = max(ends, key=lambda one: one[1] - one[0], default=None)
    end = None if longest is None else (longest[0] + longest[1]) // 2
    begin = end if end is not None and a <= end else (a + b) // 2
    rest, dwell = float(run.t[b] - run.t[a]), float(run.t[begin] - run.t[a])
    # noise breaks a long one
    inside = np.concatenate([np.arange(c, d + 1) for c, d in clear])
    begun, over = float(run.t[inside[0]]), float(run.t[inside[-1]])
    soonest = int(inside[run.t[inside] <= begun + LONG][-1])
    latest = int(inside[run.t[inside] >= over - LONG][0])
    if latest > begin or (end is not None and soonest < end):
        begin = max(begin, latest)
        rest, dwell = over - begun, float(run.t[begin]) - begun
    return _Cut(None if end is None else min(end, soonest), begin, dwell, rest)


def _passed(run: Data, before: int, first: int, stick: int, last: int) -> int:
    """Return where in a stick the force passes what the event before has shown; the next slip where it does not."""
    # a glitch, known as such or not, shows no force
    force = scipy.signal.medfilt(np.sign(run.belt_speed) * run.readings[before : last + 1, 0], GLITCH)
    slip, stuck = first - before, stick - before
    lowest = int(np.argmin(force[: slip + 1]))
    beyond = np.flatnonzero(force[stuck:] > force[lowest : slip + 1].max())
    return stick + int(beyond[0]) if len(beyond) else last


def _clear(run: Data, a: int, b: int, policy: Policy) -> bool:
    """Whether samples at the belt's speed are a stick, and no swing that comes near that speed."""
    t, x = run.t[a : b + 1], run.readings[a : b + 1, 0]
    if len(t) < policy.fewest_stuck or 0.5 * (t[-1] - t[0]) <= math.acos(1 - CREEP):  # it just touches it
        return False
    return not passes_by(t, x, run.belt_speed, float(run.noise[0]), 2 * math.pi, CREEP)


def _velocity(run: Data, first: int, last: int) -> Floats:
    """Velocity between two samples, over as many readings as show a slow belt's above their noise."""
    dt = float(np.median(np.diff(run.t[first:last])))
    width = velocity_width(run.t, float(run.noise[0]), run.belt_speed)
    while SURE * velocity_noise(width, dt, float(run.noise[0])) > CREEP * abs(run.belt_speed):
        width += 2
        if width > (last - first) // SEEN:  # in so short a stick nothing is seen
            return run.v[first:last]
    if width == velocity_width(run.t, float(run.noise[0]), run.belt_speed):
        return run.v[first:last]
    return np.asarray(scipy.signal.savgol_filter(run.readings[first:last, 0], width, 1, deriv=1, delta=dt))


def timed(every: Sequence[Stretch], motions: Sequence[WindowMotion | None]) -> list[Stretch]:
    """
    Return stretches with their sticks as long as a model has them that was fitted.

    A velocity near the belt's is no stick yet: a slip that ends gently has it for long, and so has one that begins.

    Parameters
    ----------
    every, motions : the stretches, and how each moves; None where that is not known
    """
    began = {
        (one.run, one.stop): _between(m, int(slips[-1]))
        for one, m in zip(every, motions, strict=True)
        if m is not None and len(slips := np.flatnonzero(m.mode)) and slips[-1] + 1 < len(m.t)
    }
    known = [
        float(m.t[0]) - began[one.run, one.start] if m is not None and (one.run, one.start) in began else None
        for one, m in zip(every, motions, strict=True)
    ]
    # the first of a run has none before it: the readings are as far off there as at the others
    off: dict[int, list[float]] = {}
    for one, dwell in zip(every, known, strict=True):
        if dwell is not None:
            off.setdefault(one.run, []).append(dwell - one.dwell)
    out = []
    for one, m, dwell in zip(every, motions, known, strict=True):
        if dwell is None:
            dwell = max(one.dwell + float(np.median(off.get(one.run, [0.0]))), 0.0)
        ends = one.rest - one.dwell
        if m is not None and m.mode[0] == 0 and m.mode.any():
            ends = _between(m, int(np.flatnonzero(m.mode)[0]) - 1) - float(m.t[0])
        out.append(replace(one, dwell=dwell, rest=dwell + ends) if one.stuck else one)
    return out


def _between(motion: WindowMotion, k: int) -> float:
    return 0.5 * float(motion.t[k] + motion.t[k + 1])


def knots(run: Data, policy: Policy = POLICY) -> NDArray[np.float64]:
    """Return the places of x1 that a window's friction has numbers at, (k,)."""
    good = run.readings[run.weight[:, 0] > 0, 0]
    low, high = np.quantile(good, [SOONEST, LATEST])
    return np.linspace(low, high, policy.knots)


def slipped(places: Floats, run: Data) -> Floats:
    """Return the way slipped from the breakaway on at places of x1, 0 to 1."""
    along = places - places[0] if run.belt_speed < 0 else places[-1] - places
    return np.asarray(along / (places[-1] - places[0]))


def lasts(run: Data, index: int, stretches: Sequence[Stretch]) -> float:
    """Return how long a window of the run of that index lasts; the whole run where it has none."""
    each = [run.t[w.stop - 1] - run.t[w.start] for w in stretches if w.run == index]
    return float(np.median(each) if each else run.t[-1] - run.t[0])
