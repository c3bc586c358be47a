"""The residual of a fitted balance: its size against the noise, where it sits, its spectrum, and the arrays to draw."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.discovery.driven_slider.fit import Balance, Fit
from stickslip.discovery.driven_slider.result import ForceView
from stickslip.discovery.result import Part, Residual

Floats = NDArray[np.float64]

LAGS = 40
CLEAN = 1.1  # chi-squared per reading below which nothing is said to be left
PARTS = 4


def describe(balance: Balance, fit: Fit) -> Residual:
    """The residual against the noise, over all and by direction, speed, place and time."""
    w = fit.white
    chi2 = fit.per_reading
    error = float(np.sqrt(2 / len(w)))
    centred = w - w.mean()
    r = np.correlate(centred, centred, "full")[len(w) : len(w) + LAGS] / max(float(centred @ centred), 1e-300)
    whiteness = float(np.max(np.abs(r)) * np.sqrt(len(w)) / 1.96)
    parts = _parts(balance, w)
    worst = max(parts, key=lambda one: one.chi2)
    where = f"most of it at {worst.what} {worst.name} ({worst.chi2:.3g})"
    if chi2 < CLEAN:
        words = f"what is left is noise: chi-squared per reading is {chi2:.3g}"
    else:
        words = f"chi-squared per reading is {chi2:.3g} where the process noise leaves 1; {where}"
    return Residual(chi2, error, whiteness, chi2 < CLEAN, parts, words)


def _parts(balance: Balance, w: Floats) -> tuple[Part, ...]:
    x, v, t = (_rows(balance, name) for name in ("x", "v", "t"))
    groups: list[tuple[str, str, NDArray[np.bool_]]] = [
        ("direction", "x2 > 0", v > 0),
        ("direction", "x2 < 0", v < 0),
    ]
    for what, u, unit in (("speed", np.abs(v), "m/s"), ("place", x, "m"), ("time", t, "s")):
        edges = np.quantile(u, np.linspace(0, 1, PARTS + 1))
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            groups.append((what, f"{low:.3g} to {high:.3g} {unit}", (u >= low) & (u <= high)))
    out = []
    for what, name, chosen in groups:
        count = int(chosen.sum())
        if count > 1:
            power = float(np.mean(w[chosen] ** 2))
            out.append(Part(what, name, power, power * float(np.sqrt(2 / count)), count))
    return tuple(out)


def _rows(balance: Balance, name: str) -> Floats:
    """A quantity of the runs at the rows of the whitened balance (n',)."""
    order = balance.noise.order
    return np.concatenate([getattr(run, name)[balance.band.kept(len(run.t))][order:] for run in balance.runs])


def spectrum(balance: Balance, before: Fit, after: Fit) -> dict[str, Floats]:
    """Power of the whitened residuals over angular frequency, 1 for white noise."""
    rate = 1 / (balance.runs[0].dt * balance.band.step)
    size = int(min(512, len(before.white) // 4))
    f, was = scipy.signal.welch(before.white, fs=rate, nperseg=size)
    _, now = scipy.signal.welch(after.white, fs=rate, nperseg=size)
    return {"frequency": 2 * np.pi * f[1:], "before": was[1:] * rate / 2, "after": now[1:] * rate / 2}


def views(role: str, balance: Balance, before: Fit, after: Fit) -> tuple[ForceView, ...]:
    """The balances to draw of every run."""
    was, now = balance.unexplained(before), balance.unexplained(after)
    white_was, white_now = balance.predicted(before), balance.predicted(after)
    out, at, white_at, order = [], 0, 0, balance.noise.order
    for run, n in zip(balance.runs, balance.lengths, strict=True):
        kept = balance.band.kept(len(run.t))
        part, white = slice(at, at + n), slice(white_at, white_at + n - order)
        force = balance.force[part]
        friction = force - after.law.mass * balance.base[part, 0]
        out.append(
            ForceView(
                run.name, role, run.t[kept], run.x[kept], run.v[kept], force, friction, was[part], now[part],
                white_was[white], white_now[white],
            )
        )  # fmt: skip
        at, white_at = at + n, white_at + n - order
    return tuple(out)
