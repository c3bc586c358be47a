"""A run as a table of its events: how fast its sticks rise, where it breaks away, how its slips swing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.rig import BlockOnBelt
from stickslip.errors import InputError
from stickslip.fitted.block_events.cycle import LOG_W2, RATE, RELEASE, ZETA, K, S, arrest, lost
from stickslip.fitted.block_events.fit import SlipFits, SlipPrior, SlipWindows, fit
from stickslip.measured import signals
from stickslip.measured import sticks as segments
from stickslip.measured.case import Recording

Floats = NDArray[np.float64]
BEFORE, AFTER = 1.0, 0.5  # natural periods of stick kept around a slip
RESOLVED = 1e-9  # of the range of x: no fit and no simulation is nearer, so it counts as noise
MOST = 700  # samples of a window


@dataclass(frozen=True)
class BlockRun:
    """A recording made ready: x rises in its sticks (the belt's direction is turned if need be).

    `x` (n,) is NaN at glitches; `sign` undoes the turning; `noise` is the standard deviation of x, quantisation
    included, `step` the size of a quantum (0: none).
    """

    name: str
    source: str
    role: str
    rig: BlockOnBelt
    force_channel: bool
    belt_speed: float
    sign: float
    t: Floats
    x: Floats
    noise: float
    step: float
    glitches: float
    track: segments.Track


@dataclass(frozen=True)
class SlipEvents:
    """The slips of one run, fitted one by one, in time order; (k,) arrays but for `p` (k, 6).

    `dwell` is the time at rest before each; `travel` the belt's travel at the breakaway; `slip` the distance slid;
    `std` (k, 6) what the noise leaves of each number; `position` the block's own place on the belt.
    """

    p: Floats
    std: Floats
    rms: Floats
    t: Floats
    dwell: Floats
    travel: Floats
    slip: Floats
    arrest: Floats
    previous: Floats
    residual: Floats
    window: tuple[tuple[int, int], ...]

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True)
class Sticks:
    """How fast the sticks of one run rise; (k,) arrays. `rate` is over the set-point speed, `std` from the noise."""

    t: Floats
    x: Floats
    rate: Floats
    std: Floats


@dataclass(frozen=True)
class MeasuredBlock:
    """A run with its events."""

    run: BlockRun
    events: SlipEvents
    sticks: Sticks


def natural_rate(rig: BlockOnBelt) -> float:
    """sqrt(k/m) of the declared rig."""
    return float(np.sqrt(rig.stiffness / rig.mass))


def damping_ratio(rig: BlockOnBelt) -> float:
    """c/(2 sqrt(k m)) of the declared rig."""
    return float(rig.damping / (2 * np.sqrt(rig.stiffness * rig.mass)))


def prepare(recording: Recording, *, at_rest: bool = False) -> BlockRun:
    """Turn a recording into a run, its noise estimated where it is not declared.

    Raises
    ------
    InputError
        The belt stands still where that is not allowed for, or the record is too short.
    """
    rig = recording.rig
    if not isinstance(rig, BlockOnBelt):
        raise InputError("must be a block on a belt", key="rig")
    if recording.belt_speed == 0 and not at_rest:
        raise InputError(
            f"run '{recording.name}': the belt stands still; give the speed of the pull", key="belt_speed"
        )
    sign = float(np.sign(recording.belt_speed)) or 1.0
    t = recording.t - recording.t[0]
    x = sign * np.asarray(recording.x1, dtype=np.float64)
    good = np.isfinite(x)
    noise = recording.noise.get("x1") or float(signals.noise_std(x[good], t=t[good]))
    noise = max(noise, RESOLVED * float(np.ptp(x[good])))
    x = x.copy()
    x[np.flatnonzero(good)[signals.find_glitches(x[good]).mask]] = np.nan
    speed = abs(recording.belt_speed)
    track = segments.track(
        t, x, belt_speed=speed, noise=noise, period=2 * np.pi / natural_rate(rig), tolerance=segments.CREEP
    )
    steps = np.diff(np.unique(x[np.isfinite(x)]))
    step = float(np.min(steps)) if len(steps) and len(steps) < len(x) // 3 else 0.0
    return BlockRun(
        recording.name,
        str(recording.source),
        recording.role,
        rig,
        "spring_force" in recording.channels,
        speed,
        sign,
        t,
        x,
        noise,
        step if step > 1e-3 * noise else 0.0,
        float(np.mean(np.isnan(x))),
        track,
    )


def measure(run: BlockRun) -> MeasuredBlock:
    """Find the events of a run and fit each."""
    return MeasuredBlock(run, events(run), sticks(run))


def sticks(run: BlockRun) -> Sticks:
    """How fast the sticks rise, over the set-point; none on a belt that stands still."""
    if run.belt_speed == 0:
        return Sticks(*(np.zeros(0),) * 4)
    found = segments.rises(run.track, run.x, run.noise)
    return Sticks(found.t, found.x, found.speed / run.belt_speed, found.std / run.belt_speed)


def events(run: BlockRun) -> SlipEvents:
    """Slips with a stick on both sides, each fitted by itself."""
    bounds, starts = _windows(run)
    if not bounds:
        none = np.zeros(0)
        return SlipEvents(
            np.zeros((0, 6)), np.zeros((0, 6)), *(none,) * 7, residual=np.zeros((0, 0)), window=()
        )
    windows = cut(run, bounds)
    start = np.array(starts)
    size = np.maximum(start[:, S] - start[:, K], 5 * run.noise)
    w = natural_rate(run.rig)
    spread = np.empty_like(start)
    spread[:, [S, K]] = 100 * size[:, None]
    spread[:, RELEASE], spread[:, RATE], spread[:, LOG_W2], spread[:, ZETA] = 1 / w, run.belt_speed, 1.5, 0.3
    return _table(run, bounds, _best(windows, start, SlipPrior(start, spread)))


def _best(windows: SlipWindows, start: Floats, prior: SlipPrior) -> SlipFits:
    """The better of two starts of the frequency, event by event."""
    found = [fit(windows, _shifted(start, shift), prior) for shift in (0.0, 0.7)]
    first, second = ([float(np.nansum(np.log1p((r / 3) ** 2))) for r in one.residual] for one in found)
    take = np.array(second) < np.array(first)
    a, b = found
    return SlipFits(
        np.where(take[:, None], b.p, a.p),
        np.where(take[:, None, None], b.covariance, a.covariance),
        np.where(take, b.rms, a.rms),
        np.where(take[:, None], b.residual, a.residual),
    )


def _shifted(start: Floats, shift: float) -> Floats:
    out = start.copy()
    out[:, LOG_W2] += shift
    return out


def _windows(run: BlockRun) -> tuple[list[tuple[int, int]], list[list[float]]]:
    """Sample ranges of the events, and where the fit of each starts."""
    track, dt = run.track, float(np.median(np.diff(run.t)))
    w = natural_rate(run.rig)
    period = 2 * np.pi / w / dt
    bounds, starts = [], []
    for b, s, a in track.slips:
        if track.size(s) < segments.LEAST_SLIP * run.noise:
            continue
        low = max(b.middle, int(s.start - BEFORE * period))
        high = min(a.middle, int(s.stop + AFTER * period))
        if not 16 < high - low <= MOST:
            continue
        top, bottom = float(track.x[s.start]), float(track.x[s.stop])
        bounds.append((low, high))
        starts.append(
            [top, 0.5 * (top + bottom), float(run.t[s.start]) - 0.1 / w, run.belt_speed, 2 * np.log(w), 0.0]
        )
    return bounds, starts


def cut(run: BlockRun, bounds: Sequence[tuple[int, int]]) -> SlipWindows:
    """Readings of the events side by side."""
    longest = max(b - a for a, b in bounds)
    at = np.array([a for a, _ in bounds])[:, None] + np.arange(longest)
    beyond = at >= np.array([b for _, b in bounds])[:, None]
    at = np.minimum(at, len(run.t) - 1)
    x = run.x[at]
    bad = beyond | ~np.isfinite(x)
    return SlipWindows(run.t[at], np.where(bad, 0.0, x), np.where(bad, 0.0, 1 / run.noise))


def _table(run: BlockRun, bounds: Sequence[tuple[int, int]], found: SlipFits) -> SlipEvents:
    p = found.p
    variance = np.diagonal(found.covariance, axis1=1, axis2=2)
    std = np.sqrt(
        np.where(variance >= 0, variance, np.nan)
    )  # where readings say nothing rounding may be below 0
    slid, ends = lost(p), arrest(p)
    good = (slid > 0.5 * segments.LEAST_SLIP * run.noise) & (found.rms < 8) & (p[:, S] > p[:, K])
    good &= np.all(np.isfinite(p) & np.isfinite(std), axis=1)
    release = p[:, RELEASE]
    dwell, previous = _rests(run, release)
    chosen = [one for one, kept in zip(bounds, good, strict=True) if kept]
    return SlipEvents(
        p[good],
        std[good],
        found.rms[good],
        release[good],
        dwell[good],
        run.belt_speed * release[good],
        slid[good],
        ends[good],
        previous[good],
        found.residual[good],
        tuple(chosen),
    )


def _rests(run: BlockRun, release: Floats) -> tuple[Floats, Floats]:
    """Time at rest before each breakaway, and x where the rest began."""
    begun = np.array([s.start for s in run.track.sticks], dtype=np.int64)
    at = np.clip(np.searchsorted(run.t[begun], release) - 1, 0, len(begun) - 1)
    first = begun[at]
    return np.maximum(release - run.t[first], 1e-9), run.track.x[first]
