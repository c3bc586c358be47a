"""Runs of a rig of bodies or matrices as the fit takes them: readings, their motion, and where contacts stick."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.bodies_model import law_of
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.rigs.general import Equations, GeneralRig
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError
from stickslip.fitted.bodies_motion import SensorReadings, most_likely_motion
from stickslip.fitted.bodies_sensors import followed, jumps, may_jump, placed_by_links
from stickslip.fitted.data import cleaned, rounding
from stickslip.measured import signals
from stickslip.measured.intervals import intervals
from stickslip.measured.recording import Recording
from stickslip.measured.sticks import tops_out

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
FEWEST = 60  # samples of a run
NARROW = 7  # samples of the narrowest polynomial that a velocity is taken from
SHARE = 6  # parts of the shortest natural period that the widest one spans at most
QUIET = 4.0  # standard deviations of a velocity's noise that count as rest
SLIPS = 0.2  # share of the fastest slip above which a contact slips for sure
AT_REST = 0.03  # share of the fastest slip within which a contact on the ground rests
RIDING = 0.25  # share of a belt's speed within which a contact on it rides
FASTEST = 0.98  # quantile of the slip speeds that counts as the fastest
PLACES = 200  # samples at which a recorded drive is held against its set-point


@dataclass(frozen=True)
class BodiesData:
    """
    One run, in SI.

    Parameters
    ----------
    name, role : of the recording
    t : (n,) times from the run's first sample
    channels : names of the readings: what sensors read, and the belt's speed
    reads : what each reads, as `GeneralRig.channel_units` names it
    readings, weight, noise : (n, c), (n, c) 1/noise, (c,)
    q, v : (n, coordinates) position and velocity, smoothed; of what is not read, as if in balance with the rest
    stuck : (n, contacts) where a contact sticks, as far as the readings show it
    seen : (contacts,) whether they do
    belt, drive : what is prescribed
    drawn : where the drive is at the first sample
    periods : the longest and the shortest natural period
    offsets : declared offset and its standard uncertainty by channel; exact ones are missing
    """

    name: str
    role: str
    t: Floats
    channels: tuple[str, ...]
    readings: Floats
    weight: Floats
    noise: Floats
    q: Floats
    v: Floats
    stuck: Mask
    seen: Mask
    belt: Speed
    drive: Speed
    drawn: float
    periods: tuple[float, float]
    reads: tuple[str, ...]
    offsets: Mapping[str, tuple[float, float]]
    declared: tuple[bool, ...] = ()  # whether a channel's noise is
    placed: tuple[bool, ...] = ()  # whether what is read says where a coordinate is: itself, or a force
    followed: float = 1.0  # the drive's way by the positions that follow it, over its way as set
    measured: bool = False  # whether the belt's speed is what a channel read

    @property
    def leaps(self) -> list[int]:
        """First samples after a measured belt's speed jumped between two: when in between it did, nothing says."""
        if not self.measured or self.belt.constant is not None:
            return []
        ends = np.searchsorted(self.t, np.array(self.belt.begins) - 0.25 * float(np.median(np.diff(self.t))))
        return [
            int(b) for a, b in zip(ends[:-1], ends[1:], strict=True) if b - a == 1 and 1 < b < len(self.t) - 1
        ]

    @property
    def belt_speed(self) -> float:
        """The prescribed speed that moves the rig, where it is a number; else that at the start."""
        one = self.drive if self.belt.constant == 0 else self.belt
        return float(one(0.0)) if one.constant is None else one.constant


def natural_periods(own: Equations) -> tuple[float, float]:
    """Return the longest and the shortest period of the rig without friction and damping.

    Raises
    ------
    InputError
        No spring acts.
    """
    squares = scipy.linalg.eigh(0.5 * (own.K + own.K.T), own.M, eigvals_only=True)
    squares = squares[squares > 1e-9 * max(float(squares[-1]), 1e-300)]
    if not len(squares):
        raise InputError("no spring acts, so that nothing sets a time by which runs are cut", key="rig")
    return 2 * math.pi / math.sqrt(squares[0]), 2 * math.pi / math.sqrt(squares[-1])


def prepare_bodies(
    rig: GeneralRig, runs: Sequence[Recording], friction: FrictionLaw | None = None
) -> list[BodiesData]:
    """
    Return the runs with their noise, from [noise] where it is given and from the readings where not.

    Parameters
    ----------
    rig, runs : what was recorded
    friction : about what it is; where a velocity is read alone, it says where the body is

    Raises
    ------
    InputError
        A run is too short, or no spring acts.
    """
    sensors = [*rig.state_names, *rig.equations.sensed]
    second = [name for name, one in runs[0].channels.items() if one.reads and name not in sensors]
    channels = tuple(
        n for n in (*sensors, *second, "belt") if all(n in r.coordinates and n not in r.taken for r in runs)
    )
    for run in runs:
        if len(run.t) < FEWEST:
            raise InputError(f"run '{run.name}' has {len(run.t)} samples; at least {FEWEST} are needed")
    usual = np.median([[_noise(run.coordinates[name], run.t) for name in channels] for run in runs], axis=0)
    out = []
    for run in runs:
        noise = np.array([run.noise.get(name, size) for name, size in zip(channels, usual, strict=True)])
        out.append(_prepared(rig.equations, run, channels, noise, friction))
    return out


def _noise(x: Floats, t: Floats) -> float:
    good = np.isfinite(x)
    # what was simulated has none: it is known to nine digits at least
    return max(float(signals.noise_std(x[good], t=t[good])), 1e-9 * float(np.ptp(x[good])), 1e-300)


def _prepared(
    own: Equations,
    run: Recording,
    channels: tuple[str, ...],
    noise: Floats,
    friction: FrictionLaw | None,
) -> BodiesData:
    t = run.t - run.t[0]
    readings = np.column_stack([run.coordinates[name] for name in channels])
    noise = np.hypot(noise, rounding(readings))
    readings, weight, _ = cleaned(t, readings, noise)
    told = {name: run.channels[name] for name in channels if name in run.channels}
    reads = tuple((told[name].reads if name in told else "") or name for name in channels)
    for c, quantity in enumerate(reads):
        if may_jump(own, quantity):
            weight[jumps(readings[:, c], noise[c]), c] = 0.0
    belt, drive = (run.speeds.get(key, Speed.of(0.0)) for key in ("belt_speed", "drive_speed"))
    periods, drawn = natural_periods(own), 0.0
    if "x_drive" in run.coordinates:
        at = np.unique(np.linspace(0, len(t) - 1, PLACES).astype(int))
        drawn = float(np.nanmedian(run.coordinates["x_drive"][at] - drive.way(t[at])))
    # of two sensors of one thing the better one comes last
    order = sorted(range(len(reads)), key=lambda c: -noise[c])
    read = {reads[c]: SensorReadings(readings[:, c], weight[:, c], float(noise[c])) for c in order}
    speed = np.asarray(drive(t)) + np.zeros(len(t))
    go = drawn + np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t))])
    ratio = followed(own, {name: one.values for name, one in read.items()}, go)
    law = partial(_expected, own, friction, np.asarray(belt(t)) + np.zeros(len(t)), speed)
    q, v, doubt, placed = _all_motion(own, t, read, ratio * go, speed, periods[1], law)
    stuck, seen = _stuck(own, t, v, doubt, belt, periods[1])
    offsets = {
        name: (run.offset(name), one.offset_uncertainty * abs(run.factor(name) / one.scale))
        for name, one in told.items()
        if one.offset_uncertainty
    }
    return BodiesData(
        run.name, run.role, t, channels, readings, weight, noise, q, v, stuck, seen, belt, drive, drawn, periods,
        reads, offsets,
        tuple(name in run.noise for name in channels), placed, ratio, "belt" in run.taken,
    )  # fmt: skip


def _all_motion(
    own: Equations,
    t: Floats,
    read: Mapping[str, SensorReadings],
    go: Floats,
    speed: Floats,
    shortest: float,
    law: Callable[[Floats], Floats],
) -> tuple[Floats, Floats, Floats, tuple[bool, ...]]:
    """Positions, velocities, and the noise of these: read, found from all that is, or in balance; which are placed."""
    values = {name: one.values for name, one in read.items()}
    sizes = {name: one.noise for name, one in read.items()}
    for name, (found, size) in placed_by_links(own, t, values, sizes, go).items():
        values[name], sizes[name] = found, size
    q, v, doubt = _motion(own, t, values, sizes, shortest / SHARE)
    lost = np.array([name not in values for name in own.names])
    rates = {f"v_{name}" for name, gone in zip(own.names, lost, strict=True) if gone}
    if lost.any() and any(name in own.sensed or name in rates for name in read):
        moved = most_likely_motion(own, t, read, go, speed, shortest / (2 * math.pi), law(v))
        q[:, lost], v[:, lost], doubt[lost] = (one[..., lost] for one in moved)
    elif lost.any():
        _balance(own, q, v, speed, go)
    forces = any(name in own.sensed and not name.startswith("a_") for name in read)
    return q, v, doubt, tuple((~lost | forces).tolist())


def _expected(own: Equations, friction: FrictionLaw | None, belt: Floats, drive: Floats, v: Floats) -> Floats:
    """
    Return about what friction at each contact is, (n, contacts): that of the law at the slip that is read.

    Where a contact sticks it is what it is in the slip that follows, as a stick's mean is near that. Where no slip is
    read, that of a body at rest on its belt, or dragged over the ground by its drive.
    """
    out = np.zeros((len(v), len(own.contacts)))
    if friction is None:
        return out
    for j, one in enumerate(own.contacts):
        slip = one.slip(v, belt)
        if not np.isfinite(slip).all():
            slip = -belt if one.against == "belt" else drive
        clear = np.flatnonzero(np.abs(slip) > SLIPS * np.quantile(np.abs(slip), FASTEST))
        if len(clear):
            following = clear[np.minimum(np.searchsorted(clear, np.arange(len(v))), len(clear) - 1)]
            out[:, j] = law_of(friction, one).force(slip[following])
    return out


def _motion(
    own: Equations, t: Floats, read: Mapping[str, Floats], noise: Mapping[str, float], longest: float
) -> tuple[Floats, Floats, Floats]:
    """Positions, velocities, and the noise of these; NaN where they are not read."""
    shape = (len(t), len(own.names))
    q, v, doubt = np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape[1], np.nan)
    dt = float(np.median(np.diff(t)))
    for i, name in enumerate(own.names):
        rate = f"v_{name}"
        if name in read:
            q[:, i], v[:, i], doubt[i] = smoothed(t, read[name], noise[name], longest)
        if rate in read:
            v[:, i], _, _ = smoothed(t, read[rate], noise[rate], NARROW * dt)
            doubt[i] = noise[rate] / math.sqrt(NARROW)
    return q, v, doubt


def smoothed(t: Floats, x: Floats, noise: float, longest: float) -> tuple[Floats, Floats, float]:
    """
    Return a reading and its rate by local quadratics (n,), and the noise of the rate.

    Parameters
    ----------
    t, x : (n,) times and readings
    noise : of a reading
    longest : time that a quadratic spans at most, if that is more than seven samples
    """
    dt = float(np.median(np.diff(t)))
    grid = np.arange(0.0, t[-1] + 0.5 * dt, dt)
    even = np.interp(grid, t, x)
    most = (len(grid) - 1) // 2 * 2 - 1

    def rates(width: int) -> tuple[Floats, float]:
        found = scipy.signal.savgol_filter(even, width, 2, deriv=1, delta=dt)
        return found, noise * math.sqrt(12 / width**3) / dt

    width = min(NARROW, most)
    v, doubt = rates(width)
    while (
        width + 2 <= most
        and width * dt < longest
        and QUIET * doubt > AT_REST * np.quantile(np.abs(v), FASTEST)
    ):
        width += 2
        v, doubt = rates(width)
    places = scipy.signal.savgol_filter(even, width, 2)
    return np.interp(t, grid, places), np.interp(t, grid, v), doubt


def _balance(own: Equations, q: Floats, v: Floats, speed: Floats, go: Floats) -> None:
    """Put what is not read where its springs would hold it, as long as all goes slowly."""
    every = np.arange(len(own.names))
    for states, constant, pulled in ((q, own.force, go), (v, 0 * own.force, speed)):
        lost = every[np.isnan(states[0])]
        known = every[~np.isnan(states[0])]
        if not len(lost):
            continue
        right = constant[lost] + np.outer(pulled, own.drive_stiffness[lost])
        right -= states[:, known] @ own.K[np.ix_(lost, known)].T
        inverse = np.linalg.pinv(own.K[np.ix_(lost, lost)])
        states[:, lost] = right @ inverse.T


def _stuck(
    own: Equations, t: Floats, v: Floats, doubt: Floats, belt: Speed, shortest: float
) -> tuple[Mask, Mask]:
    """
    Where each contact rests against what it rubs on, and whether its motion is read at all.

    A swing of the `shortest` period that comes near a belt's speed without reaching it is no stick.
    """
    stuck = np.zeros((len(t), len(own.contacts)), dtype=bool)
    seen = np.zeros(len(own.contacts), dtype=bool)
    speed = np.asarray(belt(t))
    for j, one in enumerate(own.contacts):
        over = one.direction != 0
        noise = math.sqrt(float(one.direction[over] ** 2 @ doubt[over] ** 2))
        if math.isnan(noise):
            continue
        seen[j] = True
        slip = one.slip(v, speed)
        fastest = float(np.quantile(np.abs(slip), FASTEST))
        band = AT_REST * fastest
        if one.against == "belt":
            band = max(band, min(RIDING * float(np.median(np.abs(speed))), 0.5 * fastest))
        band = max(band, QUIET * noise)
        stuck[:, j] = np.abs(slip) < band
        if one.against == "belt":
            for a, b in intervals(stuck[:, j]).tolist():
                ridden = abs(float(np.mean(speed[a : b + 1])))
                way = np.sign(speed[a])
                if ridden and tops_out(
                    1 + way * float(np.mean(slip[a : b + 1])) / ridden,
                    noise / ridden,
                    math.pi * float(t[b] - t[a]) / shortest,
                    band / ridden,
                ):
                    stuck[a : b + 1, j] = False
    return stuck, seen
