"""Friction force from measured signals: the equation of motion solved for T (section 4, Fig. 3)."""

from __future__ import annotations

import numpy as np

from stickslip import signals
from stickslip.identified import ForcePoints
from stickslip.rig import AnyRig, BlockOnBelt, Rig
from stickslip.shooting import Array


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
    if isinstance(rig, BlockOnBelt):
        return -(rig.mass * a + rig.stiffness * x1 + rig.damping * x2)
    if y is None:
        raise ValueError("the rig of (2.1) needs y1 and y2")
    s = 1.0 if rig.coupling == "reciprocal" else -1.0
    return -(rig.alpha1 * (x1 + a) + rig.eta1 * (x2 + y[1]) + s * y[0])


def force_points(
    rig: AnyRig,
    t: Array,
    readings: Array,
    *,
    belt_speed: float,
    noise: Array,
    run: int = 0,
    stick_speed: float = 0.0,
) -> ForcePoints:
    """T against v_w from one run's readings.

    Velocity and acceleration come from the smoother that respects sticks and slip onsets, so that neither
    capture nor release is smeared over the filter's length.

    Parameters
    ----------
    t : (n,) array
    readings : (n, c) array
        x1, and y1 for the rig of (2.1), in the rig's units.
    belt_speed : float
    noise : (c,) array
        Standard deviation of each channel.
    run : int
        Number the points are marked with.
    stick_speed : float
        |v_w| tolerated in a stick (creep, a belt that is not exactly at its speed).

    Returns
    -------
    ForcePoints
    """
    block = signals.smooth(t, readings[:, 0], belt_speed=belt_speed, noise=noise[0], stick_speed=stick_speed)
    mode = np.zeros(len(t)) if block.mode is None else block.mode.astype(float)
    x = (block.x, block.v, block.a)
    if isinstance(rig, Rig):
        legs = signals.smooth(t, readings[:, 1], noise=noise[1])
        T = friction_force(rig, x, (legs.x, legs.v))
        variance = (rig.alpha1 * block.x_std) ** 2 + (rig.alpha1 * block.a_std) ** 2 + legs.x_std**2
    else:
        T = friction_force(rig, x)
        variance = (rig.stiffness * block.x_std) ** 2 + (rig.mass * block.a_std) ** 2
    v_w = np.where(mode == 0, 0.0, block.v - belt_speed)
    return ForcePoints(v_w, T, np.sqrt(variance), mode, np.full(len(t), float(run)))


def joined(points: list[ForcePoints]) -> ForcePoints | None:
    """The points of several runs as one, or None without any."""
    if not points:
        return None
    fields = ("v_w", "T", "T_std", "mode", "run")
    return ForcePoints(*(np.concatenate([getattr(p, f) for p in points]) for f in fields))
