"""The motion of a rig of bodies from whatever sensors read, where they do not read every coordinate.

The most likely positions, velocities and accelerations at the samples, of the readings, of the equations of motion as
well as constants are usually known, of friction that is not read, about that of the declared law and as uncertain as
the forces that are read are large, and of accelerations that change by as much once in a radian of the shortest natural
period: a least-squares problem whose matrix is banded.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.rigs.general import Equations
from stickslip.declared.uncertainty import MASS

Floats = NDArray[np.float64]
WHITE = np.array(
    [[1 / 20, 1 / 8, 1 / 6], [1 / 8, 1 / 3, 1 / 2], [1 / 6, 1 / 2, 1.0]]
)  # covariance that white jerk leaves
LEAST = 1e-3  # share of the largest force below which a coordinate is taken to be told of by none
FINEST = 64  # samples a radian; more say no more of what starts a fit
RIDGE = 1e-12  # of the scaled unknowns, which are about 1


@dataclass(frozen=True)
class SensorReadings:
    """One sensor: values (n,), weights 1/noise (n,), 0 where there is none, and the noise."""

    values: Floats
    weight: Floats
    noise: float


def most_likely_motion(
    own: Equations,
    t: Floats,
    read: Mapping[str, SensorReadings],
    go: Floats,
    speed: Floats,
    radian: float,
    friction: Floats,
) -> tuple[Floats, Floats, Floats]:
    """
    Return positions and velocities (n, coordinates), and how well the velocities are known, (coordinates,).

    Parameters
    ----------
    own : the rig
    t : (n,) times
    read : sensors by what they read
    go, speed : (n,) way and speed of the drive
    radian : of the shortest natural period, a time
    friction : (n, contacts) about what that is which is not read
    """
    count = int(radian / FINEST / float(np.median(np.diff(t))))
    if count > 1:  # samples so near each other that the matrix would be singular to rounding
        few, kept = _means(t, read, count)
        go, speed = (np.interp(few, t, x) for x in (go, speed))
        q, v, doubt = most_likely_motion(own, few, kept, go, speed, radian, _between(few, t, friction))
        return _between(t, few, q), _between(t, few, v), doubt
    n = len(own.names)
    force = _forces(own, read)
    jump = force / np.diag(own.M)
    units = np.concatenate([jump * radian**2, jump * radian, jump])  # in which the unknowns are about 1
    dt = np.maximum(np.diff(t), 1e-300)
    rows, values, weight = _observed(own, t, read, go, speed, force, units, friction)
    steps, before = _steps(n, dt, jump, radian, units)
    normal = np.tensordot(weight**2, rows[:, :, None] * rows[:, None, :], 1) + RIDGE * np.eye(3 * n)
    right = (weight**2 * values) @ rows
    normal[1:] += np.einsum("kri,krj->kij", steps, steps)
    normal[:-1] += np.einsum("kri,krj->kij", before, before)
    free = scipy.linalg.null_space(rows[:, :n])  # where nothing is read and no spring pulls: from 0 on
    normal[0, :n, :n] += normal[0].diagonal()[:n].max() * free @ free.T
    across = np.einsum("kri,krj->kij", steps, before)  # rows of a sample, columns of the one before
    root = scipy.linalg.cholesky_banded(_banded(normal, across), lower=True)
    x = scipy.linalg.cho_solve_banded((root, True), right.ravel()).reshape(len(t), 3 * n) * units
    doubt = np.empty(n)
    for i in range(n):
        unit = np.zeros(right.size)
        place = (len(t) // 2) * 3 * n + n + i
        unit[place] = 1.0
        doubt[i] = np.sqrt(scipy.linalg.cho_solve_banded((root, True), unit)[place]) * units[n + i]
    return x[:, :n], x[:, n : 2 * n], doubt


def _between(t: Floats, few: Floats, x: Floats) -> Floats:
    """Values (n, k) at times, from those at others."""
    return np.column_stack([np.interp(t, few, one) for one in x.T]) if x.size else np.zeros((len(t), 0))


def _means(
    t: Floats, read: Mapping[str, SensorReadings], count: int
) -> tuple[Floats, dict[str, SensorReadings]]:
    """Times and readings of so many samples each, weighted means."""
    starts = np.arange(0, len(t) - count + 1, count)
    sizes = np.diff(np.append(starts, len(t)))
    out = {}
    for name, one in read.items():
        squares = one.weight**2
        total = np.add.reduceat(squares, starts)
        plain = np.add.reduceat(one.values, starts) / sizes
        mean = np.add.reduceat(squares * one.values, starts) / np.where(total > 0, total, 1.0)
        out[name] = SensorReadings(
            np.where(total > 0, mean, plain), np.sqrt(total), one.noise / np.sqrt(count)
        )
    return np.add.reduceat(t, starts) / sizes, out


def _forces(own: Equations, read: Mapping[str, SensorReadings]) -> Floats:
    """How large forces on each coordinate are, by the sensors that tell of any; of the others as of the largest."""
    spreads = {name: float(np.std(scipy.signal.detrend(one.values))) for name, one in read.items()}
    rate = np.sqrt(np.diag(own.M) * np.abs(np.diag(own.K)))
    size = np.zeros(len(own.names))
    for i, name in enumerate(own.names):
        by = {name: own.K[i, i], f"v_{name}": rate[i], f"a_{name}": own.M[i, i]}
        size[i] = max(force * spreads.get(channel, 0.0) for channel, force in by.items())
    links = [(f"F_{one.name}", one.row) for one in own.links]
    for channel, row in (*links, *((f"T_{one.name}", one.direction) for one in own.contacts)):
        size = np.maximum(size, np.abs(row) * spreads.get(channel, 0.0))
    top = float(size.max()) or 1.0
    return np.where(size > LEAST * top, size, top)


def _observed(
    own: Equations,
    t: Floats,
    read: Mapping[str, SensorReadings],
    go: Floats,
    speed: Floats,
    force: Floats,
    units: Floats,
    friction: Floats,
) -> tuple[Floats, Floats, Floats]:
    """Rows over the scaled unknowns, (rows, 3 coordinates), what they are, and the weights of that, (n, rows) each."""
    n, eye = len(own.names), np.eye(3 * len(own.names))
    rows: list[tuple[Floats, Floats, Floats]] = []  # row, values and weights
    for i, name in enumerate(own.names):
        for k, channel in enumerate((name, f"v_{name}", f"a_{name}")):
            if channel in read:
                rows.append((eye[k * n + i], read[channel].values, read[channel].weight))
    for one in own.links:
        if f"F_{one.name}" in read:
            of, sensor = one.weights, read[f"F_{one.name}"]
            row = np.concatenate([of[: 2 * n], np.zeros(n)])
            rows.append((row, sensor.values - of[2 * n] * go - of[2 * n + 1] * speed - of[-1], sensor.weight))
    # M q'' + C q' + K q + what friction is read = what pulls; then friction that is not read, about 0
    moved = np.concatenate([own.K, own.C, own.M], axis=1)
    pulled = own.force + np.outer(go, own.drive_stiffness) + np.outer(speed, own.drive_damping)
    told = [j for j, one in enumerate(own.contacts) if f"T_{one.name}" in read]
    hidden = [j for j in range(len(own.contacts)) if j not in told]
    noise = np.full((len(t), n), (MASS * force) ** 2)
    for j in told:
        sensor, along = read[f"T_{own.contacts[j].name}"], own.directions[j]
        pulled = pulled - np.outer(sensor.values, along)
        good = sensor.weight > 0  # a reading beside a jump may be off by the whole of it
        noise += np.outer(
            np.where(good, 1 / np.where(good, sensor.weight, 1.0) ** 2, np.var(sensor.values)), along**2
        )
    free = scipy.linalg.null_space(own.directions[hidden]).T if hidden else np.eye(n)
    pulled = pulled - friction[:, hidden] @ own.directions[hidden]
    for turn in free:
        rows.append((turn @ moved, pulled @ turn, 1 / np.sqrt(noise @ turn**2)))
    if hidden:
        rows += [(moved[i], pulled[:, i], np.full(len(t), 1 / force[i])) for i in range(n)]
    values, weight = (np.array([one[k] for one in rows]).T for k in (1, 2))
    return np.array([row for row, _, _ in rows]) * units, values, weight


def _steps(n: int, dt: Floats, jump: Floats, radian: float, units: Floats) -> tuple[Floats, Floats]:
    """Rows over a sample's unknowns, and over those of the one before, which white jerk moves on, (n - 1, ...)."""
    count = len(dt)
    on, before = np.zeros((count, 3 * n, 3 * n)), np.zeros((count, 3 * n, 3 * n))
    powers = np.stack([dt**2, dt, np.ones(count)], axis=1)  # of the root of the covariance, beside dt^(1/2)
    white = np.linalg.inv(np.linalg.cholesky(WHITE))
    flow = np.zeros((count, 3, 3))
    flow[:, [0, 1, 2], [0, 1, 2]] = 1.0
    flow[:, 0, 1] = flow[:, 1, 2] = dt
    flow[:, 0, 2] = 0.5 * dt**2
    for i in range(n):
        places = [i, n + i, 2 * n + i]
        size = jump[i] / np.sqrt(radian) * np.sqrt(dt)  # of what jerk adds to the acceleration
        whiten = white[None] / (size[:, None] * powers)[:, None, :]
        on[np.ix_(range(count), places, places)] = whiten * units[places]
        before[np.ix_(range(count), places, places)] = -(whiten @ flow) * units[places]
    return on, before


def _banded(normal: Floats, across: Floats) -> Floats:
    """The lower bands of a block-tridiagonal matrix, (2 b, n b)."""
    count, b = normal.shape[:2]
    out = np.zeros((2 * b, count * b))
    for i in range(b):
        for j in range(b):
            if i >= j:
                out[i - j, j::b] = normal[:, i, j]
            out[b + i - j, j : (count - 1) * b : b] += across[:, i, j]
    return out
