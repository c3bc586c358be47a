"""Events fitted to the readings, all at once: Levenberg-Marquardt on the closed form, robust against glitches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.block_events.cycle import LOG_W2, RATE, RELEASE, ZETA, K, S, positions, slopes

Floats = NDArray[np.float64]
ROUNDS = 40
TAIL = 3.0  # standard deviations from which a reading counts less


@dataclass(frozen=True)
class SlipWindows:
    """Events cut out of a run: (e, n) times and readings, weight 0 beyond an event's end and at glitches."""

    t: Floats
    x: Floats
    weight: Floats


@dataclass(frozen=True)
class SlipPrior:
    """What an event's numbers are expected to be, (e, 6): weak, it only holds what the readings do not say."""

    centre: Floats
    spread: Floats


@dataclass(frozen=True)
class SlipFits:
    """Numbers (e, 6), their covariances (e, 6, 6), and the robust rms of each event's residual over the noise."""

    p: Floats
    covariance: Floats
    rms: Floats
    residual: Floats


def fit(windows: SlipWindows, start: Floats, prior: SlipPrior, tail: float = TAIL) -> SlipFits:
    """Fit all events of a run.

    Parameters
    ----------
    windows : SlipWindows
        `weight` is 1/noise.
    start : (e, 6) array
    prior : SlipPrior
    tail : float
        Standard deviations from which a reading counts less; infinite for plain least squares.
    """
    p = start.copy()
    damping = np.full(len(p), 1e-2)
    r, robust = _residual(p, windows, tail)
    cost = _cost(r, p, prior, tail)
    for _ in range(ROUNDS):
        J = slopes(p, windows.t) * (windows.weight * robust)[:, None, :]
        normal = J @ J.transpose(0, 2, 1) + _diagonal(1 / prior.spread**2)
        slope = np.einsum("ejn,en->ej", J, r * robust) + (prior.centre - p) / prior.spread**2
        size = np.diagonal(normal, axis1=1, axis2=2)
        step = np.linalg.solve(normal + _diagonal(damping[:, None] * size), slope[:, :, None])[:, :, 0]
        trial = _bounded(p + step)
        r_new, robust_new = _residual(trial, windows, tail)
        new = _cost(r_new, trial, prior, tail)
        better = new < cost
        p = np.where(better[:, None], trial, p)
        r = np.where(better[:, None], r_new, r)
        robust = np.where(better[:, None], robust_new, robust)
        settled = np.max(np.where(better, (cost - new) / np.maximum(cost, 1.0), 0.0)) < 1e-6
        cost = np.where(better, new, cost)
        damping = np.clip(np.where(better, damping / 5, damping * 6), 1e-8, 1e8)
        if settled and bool(np.all(better | (damping > 1e3))):
            break
    J = slopes(p, windows.t) * (windows.weight * robust)[:, None, :]
    normal = J @ J.transpose(0, 2, 1) + _diagonal(1 / prior.spread**2)
    used = np.where(windows.weight > 0, r, np.nan)
    rms = np.nanmedian(np.abs(used), axis=1) / 0.6745
    covariance = np.linalg.inv(normal) * np.maximum(rms, 1.0)[:, None, None] ** 2
    return SlipFits(p, covariance, rms, used)


def _residual(p: Floats, windows: SlipWindows, tail: float) -> tuple[Floats, Floats]:
    r = (windows.x - positions(p, windows.t)) * windows.weight
    return r, 1 / np.sqrt(1 + (r / tail) ** 2)


def _cost(r: Floats, p: Floats, prior: SlipPrior, tail: float) -> Floats:
    """Minus twice the log of a density with heavy tails, whose weights are those of `_residual`."""
    tails = np.sum(r**2, axis=1) if np.isinf(tail) else tail**2 * np.sum(np.log1p((r / tail) ** 2), axis=1)
    return np.asarray(tails + np.sum(((p - prior.centre) / prior.spread) ** 2, axis=1))


def _bounded(p: Floats) -> Floats:
    out = p.copy()
    out[:, ZETA] = np.clip(p[:, ZETA], -0.65, 0.65)
    out[:, K] = np.minimum(p[:, K], p[:, S] - 1e-9)
    return out


def _diagonal(values: Floats) -> Floats:
    return np.asarray(values[:, :, None] * np.eye(values.shape[1]))


__all__ = ["LOG_W2", "RATE", "RELEASE", "SlipFits", "SlipPrior", "SlipWindows", "fit"]
