"""Friction force from measured signals: the equation of motion solved for T (section 4, Fig. 3)."""

from __future__ import annotations

import numpy as np
import scipy

from stickslip.declared.rig import AnyRig, BlockOnBelt, Rig, on_belt
from stickslip.fitted.identified import ForcePoints
from stickslip.measured.fit_window import Array
from stickslip.measured.sticks import Track


def friction_force(rig: AnyRig, x: tuple[Array, Array, Array], y: tuple[Array, Array] | None = None) -> Array:
    """T from displacement, velocity and acceleration of the block (and displacement, velocity of the legs).

    Parameters
    ----------
    rig : Rig or BlockOnBelt
    x : (x1, x2, x2') of (n,) arrays
    y : (y1, y2) of (n,) arrays, for the rig of (2.1)

    Returns
    -------
    (n,) array
        From the second line of (2.1): T = -[alpha1 (x1 + x2') + eta1 (x2 + y2) + s y1]. In a stick x2' = 0 and
        x2 = v_b make that -q. For the block on a belt T = -(mass x2' + stiffness x1 + damping x2).
    """
    x1, x2, a = x
    rig = on_belt(rig)
    if isinstance(rig, BlockOnBelt):
        return -(rig.mass * a + rig.stiffness * x1 + rig.damping * x2)
    if y is None:
        raise ValueError("the rig of (2.1) needs y1 and y2")
    s = 1.0 if rig.coupling == "reciprocal" else -1.0
    return -(rig.alpha1 * (x1 + a) + rig.eta1 * (x2 + y[1]) + s * y[0])


def force_points(
    rig: AnyRig, track: Track, readings: Array, *, noise: Array, period: float, run: int = 0
) -> ForcePoints:
    """T against v_w from one run's readings.

    Inside each slip, velocity and acceleration come from a local cubic that never reaches across a transition, so
    that neither capture nor release is smeared over the filter's length. In sticks the block moves as the belt.

    Parameters
    ----------
    track : Track
        Where the block sticks.
    readings : (n, c) array
        x1, and y1 for the rig of (2.1), in the rig's units.
    noise : (c,) array
        Standard deviation of each channel.
    period : float
        Natural period; the local cubic spans an eighth of it.
    run : int
        Number the points are marked with.

    Returns
    -------
    ForcePoints
        Without the samples next to a transition, where the mode is in doubt.
    """
    rig = on_belt(rig)
    dt = float(np.median(np.diff(track.t)))
    width = max(int(period / 8 / dt), 7) | 1
    readings = _bridged(track.t, readings)
    y = None
    if isinstance(rig, Rig):
        y = (
            scipy.signal.savgol_filter(readings[:, 1], width, 3),
            scipy.signal.savgol_filter(readings[:, 1], width, 3, deriv=1, delta=dt),
        )
    inertia, stiffness = (rig.alpha1, rig.alpha1) if isinstance(rig, Rig) else (rig.mass, rig.stiffness)
    index, blocks = [], []
    for s in track.segments:
        trim = max(track.width // 3, 2)
        part = np.arange(s.start + trim, s.stop - trim)
        if len(part) < (width if s.mode else 1):
            continue
        t, x = track.t[part], readings[part, 0]
        if s.mode:
            block = np.array([scipy.signal.savgol_filter(x, width, 3, deriv=k, delta=dt) for k in range(3)])
            std = noise[0] * _gain(len(part), width, dt, inertia, stiffness)
        else:
            block = np.array([track.x[part], np.full(len(t), track.belt_speed), np.zeros(len(t))])
            std = np.full(len(t), stiffness * noise[0] / np.sqrt(track.width))
        index.append(part)
        blocks.append(np.vstack([block, std]))
    if not index:
        return ForcePoints(*(np.zeros(0) for _ in range(5)))
    i, all_ = np.concatenate(index), np.hstack(blocks)
    T = friction_force(rig, (all_[0], all_[1], all_[2]), None if y is None else (y[0][i], y[1][i]))
    mode = track.mode[i].astype(float)
    v_w = np.where(mode == 0, 0.0, all_[1] - track.belt_speed)
    return ForcePoints(v_w, T, all_[3], mode, np.full(len(i), float(run)))


def _gain(n: int, width: int, dt: float, inertia: float, stiffness: float) -> Array:
    """Standard deviation of inertia x'' + stiffness x per unit of noise, at each of n samples of a slip."""
    offsets = np.arange(width) - width // 2
    fit = np.linalg.pinv(np.vander(offsets, 4, increasing=True))
    at = (
        np.clip(np.arange(n), 0, width // 2)
        - width // 2
        + np.clip(np.arange(n) - (n - 1 - width // 2), 0, None)
    )
    position = fit.T @ np.vander(at, 4, increasing=True).T
    curvature = (2 * fit[2][:, None] + 6 * fit[3][:, None] * at) / dt**2
    return np.asarray(np.linalg.norm(stiffness * position + inertia * curvature, axis=0), dtype=float)


def _bridged(t: Array, readings: Array) -> Array:
    """Missing readings interpolated: glitches were taken out before."""
    out = readings.copy()
    for x in out.T:
        bad = ~np.isfinite(x)
        x[bad] = np.interp(t[bad], t[~bad], x[~bad])
    return out


def joined(points: list[ForcePoints]) -> ForcePoints | None:
    """The points of several runs as one, or None without any."""
    if not points:
        return None
    fields = ("v_w", "T", "T_std", "mode", "run")
    return ForcePoints(*(np.concatenate([getattr(p, f) for p in points]) for f in fields))
