"""One event in closed form: a stick, the slip behind it, and the stick that follows, many events at a time.

Readings are spring deflections x. In the sticks x rises at a rate r. The slip obeys
x'' = -w^2 (x - K) - 2 zeta w x', from x = S with x' = r at the breakaway, until x' is r again: Coulomb friction of
level k K in the slip and k S at the breakaway, on a spring and mass with w^2 = k/m. The numbers of one event are
(S, K, breakaway time, r, ln w^2, zeta); a sensor's gain scales S, K and r alike and changes nothing else.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
S, K, RELEASE, RATE, LOG_W2, ZETA = range(6)
NUMBERS = 6
STEEPEST = 0.7  # largest |zeta|
TURNS = np.linspace(0.2, 1.0, 33)  # of a period: where the end of a slip is looked for


def positions(p: Floats, t: Floats) -> Floats:
    """x of each event at its own times.

    Parameters
    ----------
    p : (e, 6) numbers of the events.
    t : (e, n) times.

    Returns
    -------
    (e, n) array
    """
    rate, w, zeta, wd = _constants(p)
    end = duration(p)
    u = t - p[:, RELEASE, None]
    inside = np.clip(u, 0.0, end[:, None])
    a, b = _amplitudes(p, rate, w, zeta, wd)
    decay = np.exp(-(zeta * w)[:, None] * inside)
    angle = wd[:, None] * inside
    x = p[:, K, None] + decay * (a[:, None] * np.cos(angle) + b[:, None] * np.sin(angle))
    return np.asarray(x + rate[:, None] * (np.minimum(u, 0.0) + np.maximum(u - end[:, None], 0.0)))


def duration(p: Floats) -> Floats:
    """Time from breakaway to capture, (e,): the first return of x' to the rate of the sticks."""
    rate, w, zeta, wd = _constants(p)
    a, b = _amplitudes(p, rate, w, zeta, wd)
    n = zeta * w
    # x' = exp(-n u) (c cos + d sin), which is r at u = 0 and falls below it
    c, d = b * wd - n * a, -(a * wd + n * b)
    grid = 2 * np.pi / wd[:, None] * TURNS
    speed = np.exp(-n[:, None] * grid) * (
        c[:, None] * np.cos(wd[:, None] * grid) + d[:, None] * np.sin(wd[:, None] * grid)
    )
    back = speed >= rate[:, None]
    first = np.where(back.any(axis=1), np.argmax(back, axis=1), len(TURNS) - 1)
    high = np.take_along_axis(grid, first[:, None], axis=1)[:, 0]
    low = np.where(first > 0, np.take_along_axis(grid, np.maximum(first - 1, 0)[:, None], axis=1)[:, 0], 0.0)
    for _ in range(36):
        middle = 0.5 * (low + high)
        speed = np.exp(-n * middle) * (c * np.cos(wd * middle) + d * np.sin(wd * middle))
        below = speed < rate
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray(0.5 * (low + high))


def lost(p: Floats) -> Floats:
    """Slip against the belt in one event, (e,)."""
    end = duration(p)
    at = (p[:, RELEASE] + end)[:, None]
    return np.asarray(p[:, S] + p[:, RATE] * end - positions(p, at)[:, 0])


def arrest(p: Floats) -> Floats:
    """x at the capture, (e,)."""
    return np.asarray(p[:, S] + p[:, RATE] * duration(p) - lost(p))


def _constants(p: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    w = np.exp(0.5 * p[:, LOG_W2])
    zeta = np.clip(p[:, ZETA], -STEEPEST, STEEPEST)
    return p[:, RATE], w, zeta, w * np.sqrt(1 - zeta**2)


def _amplitudes(p: Floats, rate: Floats, w: Floats, zeta: Floats, wd: Floats) -> tuple[Floats, Floats]:
    a = p[:, S] - p[:, K]
    return a, (rate + zeta * w * a) / wd
