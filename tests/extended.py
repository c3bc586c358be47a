"""The plain rigs in extended precision (x87 long double), many lanes at once, along a known sequence of pieces.

Written apart from the core: Taylor series by their recurrences in numpy, every lane with its own parameters.
Each piece ends where its switching function vanishes, by Newton's method on the series from a given guess; which
pieces follow each other is taken from a run in double precision. Differences of lanes are derivatives good to
some 1e-12.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.rig import Rig

LD = np.longdouble
ORDER = 26
ENOUGH = np.finfo(LD).eps < 1e-18  # elsewhere long double may be double


@dataclass
class Lanes:
    """Parameters (lanes,) by name, the law, whether the rig has two degrees of freedom."""

    p: dict[str, np.ndarray]
    law: type
    two: bool
    coupling: float = 1.0


OFFSETS = (1, -1, 2, -2)


def lanes_of(model, v_b, names, steps):
    """Lanes 4k to 4k+3 have parameter `names[k]` moved by OFFSETS times `steps[k]`; the last lane is the base."""
    count = len(OFFSETS) * len(names) + 1
    values = {"belt_speed": v_b, **model.parameters}
    p = {name: np.full(count, LD(value)) for name, value in values.items()}
    law = model.friction
    for k, (name, step) in enumerate(zip(names, steps, strict=True)):
        if not name.startswith("initial."):
            p[name][4 * k : 4 * k + 4] += LD(step) * np.array(OFFSETS)
    two = isinstance(model.rig, Rig)
    if two:
        coupling = 1.0 if model.rig.coupling == "reciprocal" else -1.0
    else:
        p |= {"alpha1": p["mass"], "eta1": p["damping"]}
        coupling = 0.0
    for name in ("static", "kinetic", "scale", "decay", "constant", "quadratic"):
        if name in p and f"{name}_plus" not in p:
            p[f"{name}_plus"] = p[name]
    return Lanes(p, type(law), two, coupling)


def starts_of(initial, state_names, names, steps):
    z = np.repeat(np.array(initial, dtype=LD)[:, None], len(OFFSETS) * len(names) + 1, axis=1)
    for k, (name, step) in enumerate(zip(names, steps, strict=True)):
        if name.startswith("initial."):
            i = state_names.index(name.removeprefix("initial."))
            z[i, 4 * k : 4 * k + 4] += LD(step) * np.array(OFFSETS)
    return z


def differences(a, steps):
    """Derivatives (..., parameters) from lanes (..., lanes): central differences, the error in h^2 taken off."""
    up, down, up2, down2 = (a[..., i:-1:4] for i in range(4))
    return ((8 * (up - down) - (up2 - down2)) / (12 * np.array(steps, dtype=LD))).astype(float)


def static(lanes, sign):
    p = lanes.p
    if lanes.law is PaperFriction:
        return p["T_s_minus"] if sign < 0 else p["T_s_plus"]
    end = "" if sign < 0 else "_plus"
    if lanes.law is CoulombFriction:
        return p[f"static{end}"]
    return p[f"scale{end}"] + p[f"constant{end}"]


def kink(lanes, sign, guess=0.26):
    """Slip speed at which the paper's branch reaches its minimum."""
    p = lanes.p
    if sign > 0:
        return p["v_w_max"]
    u = np.full_like(p["T_s_minus"], LD(guess))
    for _ in range(60):
        near, far = _exponentials(p, u)
        u = u - (p["T_s_minus"] - near - far - p["T_min_minus"]) / (-near / p["t1"] - far / p["t2"])
    return u


def _exponentials(p, u):
    left = -p["v_w_min"] - u
    return p["A1"] * np.exp(-left / p["t1"]), p["A2"] * np.exp(-left / p["t2"])


def demand(lanes, x1, y1, y2):
    p, v_b = lanes.p, lanes.p["belt_speed"]
    if lanes.two:
        return p["alpha1"] * x1 + p["eta1"] * (v_b + y2) + LD(lanes.coupling) * y1
    return p["stiffness"] * x1 + p["damping"] * v_b


class Magnitude:
    """Coefficients of R(u(t)), one after the other, as those of u become known."""

    def __init__(self, lanes, sign, saturated, u, shape):
        self.lanes, self.sign, self.saturated, self.u = lanes, sign, saturated, u
        self.aux = [np.zeros(shape, dtype=LD) for _ in range(2)]
        self.end = "" if sign < 0 else "_plus"

    def __getitem__(self, k):
        p, law, u = self.lanes.p, self.lanes.law, self.u
        if law is CoulombFriction:
            return p[f"kinetic{self.end}"] * (k == 0)
        if law is HyperbolicFriction:
            return self._hyperbolic(k)
        if self.saturated:
            return (p["T_min_minus"] if self.sign < 0 else p["T_min_plus"]) * (k == 0)
        if self.sign > 0:
            return p["T_s_plus"] * (k == 0) - u[k] * (p["T_s_plus"] - p["T_min_plus"]) / p["v_w_max"]
        for e, t, first in zip(self.aux, ("t1", "t2"), _exponentials(p, u[0]), strict=True):
            j = np.arange(1, k + 1, dtype=LD)[:, None]
            e[k] = first if k == 0 else (j * u[1 : k + 1] * e[k - 1 :: -1][:k]).sum(axis=0) / (p[t] * LD(k))
        return p["T_s_minus"] * (k == 0) - self.aux[0][k] - self.aux[1][k]

    def _hyperbolic(self, k):
        p, u, r = self.lanes.p, self.u, self.aux[0]
        scale, decay, constant, quadratic = (
            p[f"{n}{self.end}"] for n in ("scale", "decay", "constant", "quadratic")
        )
        inner = scale * (k == 0) - decay * (u[1 : k + 1] * r[k - 1 :: -1][:k]).sum(axis=0) if k else scale
        r[k] = inner / (1 + decay * u[0])
        return r[k] + constant * (k == 0) + quadratic * (u[: k + 1] * u[k::-1]).sum(axis=0)


def series(lanes, mode, saturated, z):
    """Taylor coefficients (ORDER + 1, d, lanes) of the motion from z."""
    p, d = lanes.p, len(z)
    c = np.zeros((ORDER + 1, d, z.shape[1]), dtype=LD)
    c[0] = z
    u = np.zeros((ORDER + 1, z.shape[1]), dtype=LD)
    magnitude = Magnitude(lanes, mode, saturated, u, u.shape)
    if mode == 0:
        c[0, 1] = p["belt_speed"]
    for k in range(ORDER):
        n = LD(k + 1)
        x1, x2 = c[k, 0], c[k, 1]
        y1, y2 = (c[k, 2], c[k, 3]) if lanes.two else (LD(0), LD(0))
        c[k + 1, 0] = x2 / n
        if mode:
            u[k] = LD(mode) * (x2 - p["belt_speed"] * (k == 0))
            pull = p["alpha1"] * x1 if lanes.two else p["stiffness"] * x1
            pull = pull + p["eta1"] * (x2 + y2) + LD(lanes.coupling) * y1
            c[k + 1, 1] = -(pull + LD(mode) * magnitude[k]) / p["alpha1"] / n
        if lanes.two:
            c[k + 1, 2] = y2 / n
            c[k + 1, 3] = (-p["beta3"] * y1 - p["eta12"] * y2 - x1 - p["eta1"] * x2) / p["alpha2"] / n
    return c


def horner(c, h):
    total = np.zeros_like(c[0])
    for row in c[::-1]:
        total = total * h + row
    return total


def rate(c, h):
    n = np.arange(1, len(c), dtype=LD).reshape(-1, *[1] * (c.ndim - 1))
    return horner(c[1:] * n, h)


def advance(lanes, mode, saturated, z, span):
    """The state after `span` (lanes,), in steps that the series bears, and the last step's series and length."""
    left = np.array(span, dtype=LD)
    while True:
        c = series(lanes, mode, saturated, z)
        size = np.abs(c[-1]).max() + np.abs(c[-2]).max() + LD(1e-300)
        h = LD((1e-20 / float(size)) ** (1 / ORDER))
        if np.all(left <= h):
            return horner(c, left), c, left
        count = np.ceil(float(left.max() / h))
        z, left = horner(c, left / LD(count)), left - left / LD(count)


def switching(lanes, mode, event, z):
    """What vanishes at the end of a piece: contact, kink, or a static limit, from components of the motion."""
    if event == "kink":
        return LD(mode) * (z[1] - lanes.p["belt_speed"]) - kink(lanes, mode)
    if mode:
        return z[1] - lanes.p["belt_speed"]
    y1, y2 = (z[2], z[3]) if lanes.two else (LD(0), LD(0))
    return demand(lanes, z[0], y1, y2) - (static(lanes, -1) if event < 0 else -static(lanes, 1))


def follow(lanes, z, pieces, t_end):
    """Run along `pieces` (mode, saturated, event, guess of its time); times and states of events, the last state.

    Also returns the least rate at which a switching function of the base lane is crossed.
    """
    t = np.zeros(z.shape[1], dtype=LD)
    times, states, least = [], [], np.inf
    for mode, saturated, event, guess in pieces:
        end, _, _ = advance(lanes, mode, saturated, z, LD(guess) - t)
        t = np.full_like(t, LD(guess))
        for _ in range(8):
            c = series(lanes, mode, saturated, end)
            s = switching(lanes, mode, event, end)
            slope = _slope(lanes, mode, event, c)
            step = -s / slope
            end, t = horner(c, step), t + step
            if np.abs(step).max() < 1e-17:
                break
        least = min(least, float(np.abs(slope[-1])))
        if event == 0:  # sticks
            end[1] = lanes.p["belt_speed"]
        z = end
        times.append(t.copy())
        states.append(z.copy())
    mode, saturated = after(pieces[-1])
    last, _, _ = advance(lanes, mode, saturated, z, LD(t_end) - t)
    return np.array(times), np.array(states), last, least


def after(piece):
    mode, saturated, event, _ = piece
    return (mode, not saturated) if event == "kink" else (event, False)


def _slope(lanes, mode, event, c):
    """Rate of the switching function along the motion."""
    v = c[1]
    if event == "kink":
        return LD(mode) * v[1]
    if mode:
        return v[1]
    return (
        lanes.p["alpha1"] * v[0] + lanes.p["eta1"] * v[3] + LD(lanes.coupling) * v[2]
        if lanes.two
        else lanes.p["stiffness"] * v[0]
    )
