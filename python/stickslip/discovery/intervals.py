"""95 % intervals of the joint fit, from its Gauss-Newton information with the windows' states eliminated."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from stickslip.discovery.result import Interval
from stickslip.fitted.solve import Fit

Z = 1.959963985


def intervals(fit: Fit) -> Mapping[str, Interval]:
    """Interval of every shared unknown; None for limits that rest on the weak prior rather than on readings.

    Where chi-squared per reading is above 1 the intervals are widened by its root.
    """
    h = fit.engine.hypothesis
    _, precision = h.prior(len(fit.engine.data))
    covariance = fit.covariance
    scale = _widened(fit)
    out = {}
    for i, u in enumerate(h.shared):
        value = u.value(float(fit.vector[i]))
        variance = max(float(covariance[i, i]), 0.0)
        half = Z * math.sqrt(variance) * scale
        if variance * precision[i] > 0.3:
            out[u.name] = Interval(value, None, None)
            continue
        low, high = u.value(float(fit.vector[i]) - half), u.value(float(fit.vector[i]) + half)
        out[u.name] = Interval(value, low, high)
    return out


def combined(fit: Fit, value: float, slopes: Mapping[str, float]) -> Interval:
    """Interval of a value that changes by these slopes with the fitted coordinates of the shared unknowns."""
    g = np.array([slopes.get(u.name, 0.0) for u in fit.engine.hypothesis.shared])
    variance = float(g @ fit.covariance[: len(g), : len(g)] @ g)
    half = Z * math.sqrt(max(variance, 0.0)) * _widened(fit)
    return Interval(value, value - half, value + half)


def _widened(fit: Fit) -> float:
    return math.sqrt(max(fit.per_reading, 1.0))


def phases(fit: Fit, name: str) -> Mapping[str, float]:
    """phi by run of a periodic effect, in [0, 2 pi), for a positive amplitude."""
    h = fit.engine.hypothesis
    if f"{name}.phi" not in {u.name for u in h.own}:
        return {}
    turn = math.pi if h.values(fit.vector, 0).get(f"{name}.a", 1.0) < 0 else 0.0
    return {
        run.name: float(np.mod(h.values(fit.vector, r)[f"{name}.phi"] + turn, 2 * math.pi))
        for r, run in enumerate(fit.engine.data)
    }


def of_effect(fit: Fit, name: str) -> Mapping[str, Interval]:
    """Intervals of one effect's own numbers; a periodic one's amplitude is positive."""
    found = {k.partition(".")[2]: v for k, v in intervals(fit).items() if k.startswith(f"{name}.")}
    a = found.get("a")
    if a is not None and a.value < 0:
        low = None if a.high is None else -a.high
        found["a"] = Interval(-a.value, low, None if a.low is None else -a.low)
    return found
