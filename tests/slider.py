"""A block on a belt under Coulomb friction, slip by slip in closed form (m = k = 1); no code of the package."""

import numpy as np


def coulomb_record(static, kinetic, v, dt):
    """Times, positions, and release and capture times, of slips with the levels given one by one.

    Stick: x = x0 + v t up to x = static. Slip: x - kinetic = A cos(t) + v sin(t), A = static - kinetic, until the
    velocity is v again, after 2 (pi - atan(A/v)).
    """
    x0, t0 = static[0] - 1.5 * v, 0.0
    pieces, releases, captures = [], [], []
    for s, k in zip(static, kinetic, strict=True):
        t1 = t0 + (s - x0) / v
        amplitude = s - k
        t2 = t1 + 2 * (np.pi - np.arctan(amplitude / v))
        pieces.append((t0, t1, t2, x0, s, k))
        releases.append(t1)
        captures.append(t2)
        x0, t0 = 2 * k - s, t2
    end = t0 + 1.0
    t = np.arange(0.0, end, dt)
    x = np.empty_like(t)
    for a, b, c, start, s, k in pieces:
        stick, slip = (t >= a) & (t < b), (t >= b) & (t < c)
        x[stick] = start + v * (t[stick] - a)
        x[slip] = k + (s - k) * np.cos(t[slip] - b) + v * np.sin(t[slip] - b)
    last = t >= t0
    x[last] = x0 + v * (t[last] - t0)
    return t, x, np.array(releases), np.array(captures)
