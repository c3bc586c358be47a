"""The residual of a fitted motion: its size against the noise, where it sits, its spectrum, and the arrays to draw."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.discovery.driven_slider.result import ForceView
from stickslip.discovery.result import Part, Residual
from stickslip.likelihoods.driven_slider.banded import BandedBalance
from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.likelihoods.driven_slider.policy import STEER

Floats = NDArray[np.float64]

PARTS = 4  # of speeds, places and times that are told apart


def describe(balance: Balance, fit: MotionFit) -> Residual:
    """The residual of a fit, in white units, against the noise: over all, by direction, speed, place and time."""
    w = fit.white
    chi2 = float(w @ w) / max(fit.count - fit.freedom, 1)
    error = float(np.sqrt(2 / max(fit.count, 1)))
    sure = balance.sure
    centred = np.where(sure, w - np.mean(w[sure]), 0.0) if fit.count else w
    r = [float(centred[k:] @ centred[: len(w) - k]) for k in range(2 * STEER.order)]
    whiteness = max(map(abs, r[1:])) / max(r[0], 1e-300) * np.sqrt(max(fit.count, 1)) / SIGMAS_95
    parts, clean = _parts(balance, w), chi2 < 1 + SIGMAS_95 * error
    worst = max(parts, key=lambda one: one.chi2, default=None)
    where = f"most of it at {worst.what} {worst.name} ({worst.chi2:.3g})" if worst else ""
    if clean:
        words = f"what is left is noise: chi-squared per reading is {chi2:.3g}"
    else:
        words = f"chi-squared per reading is {chi2:.3g} where the noise leaves 1; {where}"
    return Residual(chi2, error, float(whiteness), clean, parts, words)


def _parts(balance: Balance, w: Floats) -> tuple[Part, ...]:
    sure = balance.sure
    w = w[sure]
    x, v, t = (_rows(balance, name)[sure] for name in ("x", "v", "t"))
    if not w.size:
        return ()
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
    """A quantity of the runs at the white rows (n',)."""
    return np.concatenate([getattr(run, name)[STEER.order + 2 : -1] for run in balance.runs])


def spectrum(balance: Balance, before: Floats, after: Floats) -> dict[str, Floats]:
    """Power of white residuals over angular frequency, 1 for white noise."""
    rate = 1 / balance.runs[0].dt
    unit = rate / 2 / max(float(np.mean(balance.sure)), 1e-300)  # the other rows are 0
    size = int(min(512, len(before) // 4))
    f, was = scipy.signal.welch(before, fs=rate, nperseg=size)
    _, now = scipy.signal.welch(after, fs=rate, nperseg=size)
    return {"frequency": 2 * np.pi * f[1:], "before": was[1:] * unit, "after": now[1:] * unit}


def views(role: str, shown: BandedBalance, before: MotionFit, after: MotionFit) -> tuple[ForceView, ...]:
    """The balances to draw of every run."""
    was, now = shown.unexplained(before), shown.unexplained(after)
    out, at = [], 0
    for run, n in zip(shown.balance.runs, shown.lengths, strict=True):
        kept = shown.band.kept(len(run.t))
        part = slice(at, at + n)
        force = shown.force[part]
        friction = force - after.law.mass * shown.inertia[part]
        out.append(
            ForceView(run.name, role, run.t[kept], run.x[kept], run.v[kept], force, friction, was[part], now[part])
        )  # fmt: skip
        at += n
    return tuple(out)
