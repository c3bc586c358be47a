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
ROUNDS = 9  # of Newton's method
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
    return _positions(p, t)[0]


def slopes(p: Floats, t: Floats) -> Floats:
    """d x/d number of each event at its own times, (e, 6, n); its capture moves with them, but not to first order."""
    _, inside, past, cos, sin = _positions(p, t)
    rate, w, zeta, wd = (one[:, None] for one in _constants(p))
    a, b = (one[:, None] for one in _amplitudes(p, rate[:, 0], w[:, 0], zeta[:, 0], wd[:, 0]))
    n, bent = zeta * w, -w * zeta / np.sqrt(1 - zeta**2)  # bent = d wd/d zeta
    turned, part = b * cos - a * sin, a * cos + b * sin  # part = x - K in the slip
    out = np.empty((len(p), NUMBERS, t.shape[1]))
    out[:, S] = cos + n / wd * sin
    out[:, K] = 1 - out[:, S]
    out[:, RELEASE] = np.where(past == 0, n * part - wd * turned, -rate)
    out[:, RATE] = sin / wd + past
    out[:, LOG_W2] = 0.5 * (inside * (wd * turned - n * part) + (n * a / wd - b) * sin)
    out[:, ZETA] = inside * (bent * turned - w * part) + (w * a - b * bent) / wd * sin
    return out


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
    at = 0.5 * (low + high)
    for _ in range(ROUNDS):  # Newton's method, and halving where that leaves the bracket
        decay, cos, sin = np.exp(-n * at), np.cos(wd * at), np.sin(wd * at)
        speed = decay * (c * cos + d * sin)
        below = speed < rate
        low, high = np.where(below, at, low), np.where(below, high, at)
        steepness = decay * wd * (d * cos - c * sin) - n * speed
        newton = at - (speed - rate) / np.where(steepness == 0, np.inf, steepness)
        at = np.where((newton >= low) & (newton <= high), newton, 0.5 * (low + high))
    return at


def lost(p: Floats) -> Floats:
    """Slip against the belt in one event, (e,)."""
    end = duration(p)
    at = (p[:, RELEASE] + end)[:, None]
    return np.asarray(p[:, S] + p[:, RATE] * end - positions(p, at)[:, 0])


def arrest(p: Floats) -> Floats:
    """x at the capture, (e,)."""
    return np.asarray(p[:, S] + p[:, RATE] * duration(p) - lost(p))


def _positions(p: Floats, t: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """x, the time within the slip, the time outside it, and the slip's decaying cosine and sine, all (e, n)."""
    rate, w, zeta, wd = _constants(p)
    end = duration(p)[:, None]
    u = t - p[:, RELEASE, None]
    inside = np.clip(u, 0.0, end)
    past = np.minimum(u, 0.0) + np.maximum(u - end, 0.0)
    a, b = _amplitudes(p, rate, w, zeta, wd)
    decay = np.exp(-(zeta * w)[:, None] * inside)
    angle = wd[:, None] * inside
    cos, sin = decay * np.cos(angle), decay * np.sin(angle)
    x = p[:, K, None] + a[:, None] * cos + b[:, None] * sin + rate[:, None] * past
    return x, inside, past, cos, sin


def _constants(p: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    w = np.exp(0.5 * p[:, LOG_W2])
    zeta = np.clip(p[:, ZETA], -STEEPEST, STEEPEST)
    return p[:, RATE], w, zeta, w * np.sqrt(1 - zeta**2)


def _amplitudes(p: Floats, rate: Floats, w: Floats, zeta: Floats, wd: Floats) -> tuple[Floats, Floats]:
    a = p[:, S] - p[:, K]
    return a, (rate + zeta * w * a) / wd
