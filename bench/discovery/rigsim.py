"""Fixed-step simulator of the rig and of everything that may act on it, for drawing test cases.

Written apart from the package on purpose and imports none of it: classical Runge-Kutta of order 4 with a
small fixed step; a step in which a transition falls is shortened by bisection until it ends on the far side
of the transition. Slow, short, a different route. The mathematics is (2.1) with (4.1)-(4.3) in the reading
of the project's model page: reciprocal coupling ``s``, the block feels ``-T``, magnitudes ``R(u)``, ``u =
|v_w|``, ``v_w = x2 - v_b(t)``.

How the terms are read (forces in the bracket's units, divided by alpha1 for the block and alpha2 for the
angle body):

- block force ``+F_b``, angle-body force ``+F_a``; `spring_cubic_k2` puts ``-k (x1 + y1)^3`` on both;
- multiplicative contact terms (drift, seam, normal force, patches, warm-up, wander) scale the kinetic
  magnitude *and* both static limits, and with a bristle the R inside its equation; several of them multiply;
  a viscous contact is a force ``T + c v_w`` added after that scale; with a memory it uses the true v_w;
- `stribeck_peak` adds to R after the clamp at T_min; `static_aging` adds to both static limits, dwell
  counted from the last capture, zero at a crossing that does not stick;
- `friction_memory`: the branch goes by the sign of the true v_w, the magnitude is R(|w|), w = 0 while stuck;
- a stuck block has ``x2 = v_b(t)`` and ``x2' = v_b'(t)``: the belt supplies
  ``q = alpha1 (x1 + v_b') + eta1 (v_b + y2) + s y1 - F_b``; so does a drooping belt, whose ``tau b' = -k F -
  b`` with ``F = -T`` is then solved together with ``F = q``;
- `pivot_dry_friction` is set-valued (the angle body sticks) with ``pivot_eps = 0``, else ``f tanh(y2 /
  pivot_eps)``: it creeps;
- time in phases and drifts is counted from the first sample of the record; `belt_seam` uses the set-point
  ``v_b t``;
- readings: ``x1 channel = g(lag(x1 + c y1)) + r t`` with ``g(x) = x + q x^2``; `sensor_delay` reads y1 at
  ``t - delay``.
"""

# The compiler infers the types of what it compiles.
# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import math

import numpy as np
from numba import njit

_LAW = "alpha1 alpha2 beta3 eta1 eta12 s Ts_m A1 A2 t1 t2 u_m Tmin_m Ts_p Tmin_p u_p vb"
_LISTED = (
    "block_c block_cq k1_cubic k2_cubic k3_cubic gap_k gap_d load force_a force_w force_phi pivot_f "
    "pivot_eps nf_beta2 nf_eta2 "
    "peak_dT peak_vs aging_dT aging_tau memory_tau drift_r seam_a seam_L seam_phi bristle_k bristle_c "
    "ripple_a ripple_w ripple_phi droop_k droop_tau lag_tau crosstalk_c"
)
_UNLISTED = (
    "spring_quadratic patch_a patch_x0 patch_w stop_k stop_x detent_a detent_k detent_phi angle_cq "
    "angle_spring_q "
    "angle_cubic_c block_asym_c block_cubic_c hyst_k hyst_d load_x1 load_y1sq warm_a warm_tau viscous_c "
    "bump_a bump_u "
    "bump_w angle_force_a angle_force_w angle_force_phi stiff_a stiff_w stiff_phi belt_square_a "
    "belt_square_w "
    "belt_square_phi belt_warm_a belt_warm_tau tanh_k tanh_d wander_a angle_c maxwell_k maxwell_tau tones_a "
    "tones_w tones_phi load_y2sq viscous_cq belt_drift_r y1_lag_tau"
)
_LABORATORY = "field_a wobble_a wobble_w wobble_phi"
FIELDS = tuple((_LAW + " " + _LISTED + " " + _UNLISTED + " " + _LABORATORY).split())
"""Names of every number the simulator knows; all zero means that the term is absent."""
STATE = ("x1", "x2", "y1", "y2", "bristle", "memory", "belt", "lag", "hysteresis", "creep", "y1_lag")
SMOOTH = 2  # contact mode when a bristle replaces rigid stick
FIELD_STEP, FIELD_BEFORE = 0.02, 60.0  # of `wander` where it is a field along the belt
NUMBERS = np.dtype([(name, "f8") for name in FIELDS])


@njit(cache=True)
def belt_speed(t, s, p):
    """Belt speed and the part of its time derivative that does not come from droop."""
    v, a = p.vb, 0.0
    if p.ripple_a != 0.0:
        v += p.vb * p.ripple_a * math.sin(p.ripple_w * t + p.ripple_phi)
        a += p.vb * p.ripple_a * p.ripple_w * math.cos(p.ripple_w * t + p.ripple_phi)
    if p.belt_square_a != 0.0:  # a square wave with finite edges: the stuck block must follow it
        x = p.belt_square_w * t + p.belt_square_phi
        w = math.tanh(math.sin(x) / 0.15)
        v += p.vb * p.belt_square_a * w
        a += p.vb * p.belt_square_a * (1 - w * w) * math.cos(x) * p.belt_square_w / 0.15
    if p.belt_warm_a != 0.0:
        e = math.exp(-max(t, 0.0) / p.belt_warm_tau)
        v += p.vb * p.belt_warm_a * (1 - e)
        a += p.vb * p.belt_warm_a * e / p.belt_warm_tau
    if p.wobble_a != 0.0:  # three slow waves
        for k in range(3):
            w, phi = p.wobble_w * (1.0 + 0.83 * k), p.wobble_phi * (1 + k)
            v += p.vb * p.wobble_a * math.sin(w * t + phi)
            a += p.vb * p.wobble_a * w * math.cos(w * t + phi)
    v += p.vb * p.belt_drift_r * t
    a += p.vb * p.belt_drift_r
    return v + s[6], a


@njit(cache=True)
def scale(t, s, p, wander):
    """Factor on kinetic and static friction."""
    x1, y1 = s[0], s[2]
    g = (1.0 + p.drift_r * t) * (1.0 + p.load_x1 * x1) * (1.0 + p.load_y1sq * y1 * y1)
    g *= 1.0 + p.load_y2sq * s[3] * s[3]
    if p.seam_a != 0.0:
        g *= 1.0 + p.seam_a * math.sin(2 * math.pi * (p.vb * t - x1) / p.seam_L + p.seam_phi)
    if p.nf_beta2 != 0.0 or p.nf_eta2 != 0.0:
        g *= max(0.0, 1.0 + (p.nf_beta2 * y1 + p.nf_eta2 * s[3]) / p.Ts_m)
    if p.patch_a != 0.0:
        g *= 1.0 + p.patch_a * math.exp(-(((x1 - p.patch_x0) / p.patch_w) ** 2))
    if p.warm_a != 0.0:
        g *= 1.0 + p.warm_a * (1.0 - math.exp(-max(t, 0.0) / p.warm_tau))
    if p.field_a != 0.0:  # a field along the belt, every FIELD_STEP from FIELD_BEFORE before the record on
        place = (abs(p.vb) * t - x1 * (1.0 if p.vb > 0 else -1.0) + FIELD_BEFORE) / FIELD_STEP
        i = min(max(int(place), 0), wander.size - 2)
        g *= 1.0 + p.field_a * (wander[i] + (min(max(place - i, 0.0), 1.0)) * (wander[i + 1] - wander[i]))
    if p.wander_a != 0.0:  # knots one time unit apart
        i = min(max(int(t), 0), wander.size - 2)
        g *= 1.0 + p.wander_a * (wander[i] + (min(max(t - i, 0.0), 1.0)) * (wander[i + 1] - wander[i]))
    return g


@njit(cache=True)
def magnitude(u, sign, p):
    """R(u), (4.1)-(4.3) with magnitudes, plus what adds to it."""
    if sign < 0:
        r = (
            p.Ts_m
            - p.A1 * math.exp(min((u - p.u_m) / p.t1, 50.0))
            - p.A2 * math.exp(min((u - p.u_m) / p.t2, 50.0))
        )
        r = max(p.Tmin_m, r)
    else:
        r = max(p.Tmin_p, p.Ts_p - u * (p.Ts_p - p.Tmin_p) / p.u_p)
    if p.peak_dT != 0.0:
        r += p.peak_dT * math.exp(-((u / p.peak_vs) ** 2))
    if p.bump_a != 0.0:
        r += p.bump_a * math.exp(-(((u - p.bump_u) / p.bump_w) ** 2))
    return r


@njit(cache=True)
def forces(t, s, p):
    """Extra force on the block and on the angle body (set-valued pivot friction apart)."""
    x1, x2, y1, y2 = s[0], s[1], s[2], s[3]
    shared = -p.k2_cubic * (x1 + y1) ** 3
    fb = shared - p.block_c * x2 - p.block_cq * x2 * abs(x2) - p.k1_cubic * x1**3 + p.load
    fb += (
        -p.spring_quadratic * x1 * x1
        - p.block_asym_c * max(0.0, x2)
        - p.block_cubic_c * x2**3
        - p.hyst_k * s[8]
        - p.maxwell_k * s[9]
    )
    fa = (
        shared
        - p.k3_cubic * y1**3
        - p.angle_cq * y2 * abs(y2)
        - p.angle_spring_q * y1 * y1
        - p.angle_cubic_c * y2**3
        - p.angle_c * y2
    )
    if p.pivot_eps > 0.0:
        fa -= p.pivot_f * math.tanh(y2 / p.pivot_eps)
    if p.gap_k != 0.0:
        fa -= p.gap_k * (max(0.0, y1 - p.gap_d) + min(0.0, y1 + p.gap_d))
    if p.force_a != 0.0:
        fb += p.force_a * math.sin(p.force_w * t + p.force_phi)
    if p.stop_k != 0.0:
        fb -= p.stop_k * max(0.0, x1 - p.stop_x)
    if p.detent_a != 0.0:
        fb += p.detent_a * math.sin(p.detent_k * x1 + p.detent_phi)
    if p.stiff_a != 0.0:
        fb -= p.stiff_a * x1 * math.sin(p.stiff_w * t + p.stiff_phi)
    if p.tanh_k != 0.0:
        fb -= p.tanh_k * math.tanh(x1 / p.tanh_d)
    if p.tones_a != 0.0:  # two tones, the second half as strong
        fb += p.tones_a * math.sin(p.tones_w * t + p.tones_phi)
        fb += 0.5 * p.tones_a * math.sin(1.62 * p.tones_w * t + 2.0 * p.tones_phi)
    if p.angle_force_a != 0.0:
        fa += p.angle_force_a * math.sin(p.angle_force_w * t + p.angle_force_phi)
    return fb, fa


@njit(cache=True)
def held_force(t, s, p):
    """Force ``q`` of the belt on a stuck block, and its belt's ``b'``."""
    vb, acc = belt_speed(t, s, p)
    fb, _ = forces(t, s, p)
    q = p.alpha1 * (s[0] + acc) + p.eta1 * (vb + s[3]) + p.s * s[2] - fb
    if p.droop_k == 0.0:
        return q, 0.0
    q = (q - p.alpha1 * s[6] / p.droop_tau) / (1.0 + p.alpha1 * p.droop_k / p.droop_tau)
    return q, (-p.droop_k * q - s[6]) / p.droop_tau


@njit(cache=True)
def static_limits(t, s, since, p, wander):
    """Limits of ``q``: above the first the block slips with v_w < 0, below minus the second with v_w > 0."""
    g = scale(t, s, p, wander)
    extra = p.peak_dT
    if p.bump_a != 0.0:
        extra += p.bump_a * math.exp(-((p.bump_u / p.bump_w) ** 2))
    if p.aging_dT != 0.0:
        extra += p.aging_dT * (1.0 - math.exp(-max(t - since, 0.0) / p.aging_tau))
    return g * (p.Ts_m + extra), g * (p.Ts_p + extra)


@njit(cache=True)
def angle_load(t, s, p):
    """Sum of the forces on the angle body without pivot friction."""
    _, fa = forces(t, s, p)
    return -p.beta3 * s[2] - p.eta12 * s[3] - s[0] - p.eta1 * s[1] + fa


@njit(cache=True)
def derivative(t, s, mode, pivot, p, wander, ds):
    """Right-hand side in the given contact mode and pivot mode."""
    ds[:] = 0.0
    ds[0], ds[2] = s[1], s[3]
    vb, acc = belt_speed(t, s, p)
    v = s[1] - vb
    if mode == 0:
        _, db = held_force(t, s, p)
        ds[1] = acc + db
        ds[6] = db
    else:
        sign = mode if mode != SMOOTH else (-1 if v < 0 else 1)
        if mode == SMOOTH:
            r = scale(t, s, p, wander) * magnitude(abs(v), sign, p)
            ds[4] = v - p.bristle_k * abs(v) * s[4] / max(r, 1e-9)
            friction = p.bristle_k * s[4] + p.bristle_c * v
        else:
            u = abs(s[5]) if p.memory_tau > 0.0 else sign * v
            friction = sign * scale(t, s, p, wander) * magnitude(u, sign, p)
        friction += p.viscous_c * v + p.viscous_cq * v * abs(v)
        fb, _ = forces(t, s, p)
        ds[1] = -s[0] + (fb - p.eta1 * (s[1] + s[3]) - p.s * s[2] - friction) / p.alpha1
        if p.memory_tau > 0.0:
            ds[5] = (v - s[5]) / p.memory_tau
        if p.droop_k != 0.0:
            ds[6] = (p.droop_k * friction - s[6]) / p.droop_tau
    if p.pivot_f == 0.0 or p.pivot_eps > 0.0:
        ds[3] = angle_load(t, s, p) / p.alpha2
    elif pivot != 0:
        ds[3] = (angle_load(t, s, p) - p.pivot_f * pivot) / p.alpha2
    if p.lag_tau > 0.0:
        ds[7] = (s[0] + p.crosstalk_c * s[2] - s[7]) / p.lag_tau
    if p.hyst_k != 0.0:
        ds[8] = s[1] - abs(s[1]) * s[8] / p.hyst_d
    if p.maxwell_k != 0.0:
        ds[9] = s[1] - s[9] / p.maxwell_tau
    if p.y1_lag_tau > 0.0:
        ds[10] = (s[2] - s[10]) / p.y1_lag_tau


@njit(cache=True)
def step(t, s, h, mode, pivot, p, wander, k, tmp, out):
    """One classical Runge-Kutta step of length h into ``out``."""
    derivative(t, s, mode, pivot, p, wander, k[0])
    tmp[:] = s + 0.5 * h * k[0]
    derivative(t + 0.5 * h, tmp, mode, pivot, p, wander, k[1])
    tmp[:] = s + 0.5 * h * k[1]
    derivative(t + 0.5 * h, tmp, mode, pivot, p, wander, k[2])
    tmp[:] = s + h * k[2]
    derivative(t + h, tmp, mode, pivot, p, wander, k[3])
    out[:] = s + (h / 6.0) * (k[0] + 2 * k[1] + 2 * k[2] + k[3])


@njit(cache=True)
def crossed(t, s, mode, pivot, since, p, wander):
    """0 nothing, 1 the contact's transition, 2 the pivot's."""
    if mode == 0:
        q, _ = held_force(t, s, p)
        low, high = static_limits(t, s, since, p, wander)
        if q > low or q < -high:
            return 1
    elif mode != SMOOTH and (s[1] - belt_speed(t, s, p)[0]) * mode < 0.0:
        return 1
    if p.pivot_f > 0.0 and p.pivot_eps == 0.0:
        if pivot == 0:
            if abs(angle_load(t, s, p)) > p.pivot_f:
                return 2
        elif s[3] * pivot < 0.0:
            return 2
    return 0


@njit(cache=True)
def contact_mode(t, s, since, p, wander):
    """Mode of a block whose v_w is zero."""
    q, _ = held_force(t, s, p)
    low, high = static_limits(t, s, since, p, wander)
    return -1 if q > low else (1 if q < -high else 0)


@njit(cache=True)
def pivot_mode(t, s, p):
    """Mode of an angle body whose y2 is zero."""
    load = angle_load(t, s, p)
    return 0 if abs(load) <= p.pivot_f else (1 if load > 0 else -1)


@njit(cache=True)
def run(times, start, since, h_max, p, wander):
    """States and modes at ``times`` (increasing; the first is the start's time). ``since``: start of a
    first stick.
    """
    n, m = times.size, start.size
    states, modes = np.empty((n, m)), np.empty(n, dtype=np.int64)
    k, tmp, new, s = np.empty((4, m)), np.empty(m), np.empty(m), start.copy()
    t = times[0]
    v = s[1] - belt_speed(t, s, p)[0]
    mode, events = (-1 if v < 0 else 1), 0
    if p.bristle_k > 0.0:
        mode = SMOOTH
    elif abs(v) < 1e-12:
        mode = contact_mode(t, s, since, p, wander)
    pivot = (1 if s[3] > 0 else -1) if abs(s[3]) > 1e-12 else pivot_mode(t, s, p)
    states[0], modes[0] = s, mode
    for i in range(1, n):
        stuck_at, repeats = t, 0
        while t < times[i] - 1e-13:
            left = times[i] - t
            h = left / math.ceil(left / h_max)
            step(t, s, h, mode, pivot, p, wander, k, tmp, new)
            hit = crossed(t + h, new, mode, pivot, since, p, wander)
            if hit == 0 or repeats > 20:
                s[:] = new
                t += h
                repeats = 0
                continue
            low, high = 0.0, h
            while high - low > 1e-14:
                mid = 0.5 * (low + high)
                step(t, s, mid, mode, pivot, p, wander, k, tmp, new)
                if crossed(t + mid, new, mode, pivot, since, p, wander) == 0:
                    low = mid
                else:
                    high = mid
            step(t, s, high, mode, pivot, p, wander, k, tmp, new)
            hit = crossed(t + high, new, mode, pivot, since, p, wander)
            t += high
            s[:] = new
            repeats = repeats + 1 if t - stuck_at < 1e-10 else 0
            stuck_at = t
            if hit == 2:
                s[3] = 0.0
                pivot = pivot_mode(t, s, p)
                continue
            events += 1
            s[1] = belt_speed(t, s, p)[0]
            if mode == 0:
                mode = contact_mode(t, s, since, p, wander)
            else:
                since = t
                mode = contact_mode(t, s, since, p, wander)
                if mode == 0:
                    s[5] = 0.0
        states[i], modes[i] = s, mode
    return states, modes, events
