"""Process noise of a record: what the most flexible balance leaves, its colour and its size.

The flexible balance holds no physics: free curves of velocity and position, drifts, the drive's derivatives, and every
sinusoid of position or time that stands out. What it leaves is taken for noise, so that the noise is rather over- than
underestimated.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.discovery.driven_slider.dictionary import Dictionary
from stickslip.discovery.driven_slider.fit import Balance
from stickslip.discovery.driven_slider.motion import Motion, stacked
from stickslip.discovery.driven_slider.noise import Noise, autoregression

Floats = NDArray[np.float64]

KNOTS = 10
MOST_WAVES = 16
ROUNDS = 2
STANDS_OUT = 30.0  # fall of chi-squared at which a sinusoid is not noise


def hats(u: Floats, knots: Floats) -> Floats:
    """Values (n, k) of the linear splines that are 1 at one knot and 0 at the others."""
    return np.column_stack([np.interp(u, knots, row) for row in np.eye(len(knots))])


def flexible(run: Motion, fastest: float, low: float, high: float) -> Floats:
    """Columns (n, m) of curves, drifts and derivatives."""
    s = run.sign
    speeds = fastest * np.linspace(0.0, 1.0, KNOTS) ** 2
    curve = hats(np.abs(run.v), speeds)
    place = hats(run.x, np.linspace(low, high, KNOTS))[:, 1:]
    first = np.gradient(run.drive, run.dt)
    other = [run.t, s * run.t, run.t * run.drive, run.drive * np.abs(run.drive), first]
    other += [np.gradient(first, run.dt), run.v, run.a]
    return np.column_stack(
        [curve * (s > 0)[:, None], curve * (s < 0)[:, None], place, place * s[:, None], *other]
    )


def process_noise(balance: Balance, dictionary: Dictionary) -> Floats:
    """Set the balance's noise and whiten the dictionary; return the residual (n,) taken for noise, in N."""
    runs = balance.runs
    fastest = max(float(np.max(np.abs(run.v))) for run in runs)
    low, high = min(float(run.x.min()) for run in runs), max(float(run.x.max()) for run in runs)
    extra = stacked(runs, balance.band, lambda run: flexible(run, fastest, low, high))
    fit = balance.fit(extra=_scaled(extra))
    waves = np.isin(
        [one.choice.name for one in dictionary.entries],
        ["position_ripple", "friction_ripple", "drive_ripple", "harmonic_forcing"],
    )
    for _ in range(ROUNDS):
        _take(balance, extra, fit.freedom)
        dictionary.whiten()
        fit = balance.fit(extra=_scaled(extra))
        scorer = dictionary.scorer(balance.whitened(np.column_stack([balance.base, balance.free, extra])))
        for _ in range(MOST_WAVES // ROUNDS):
            gains = scorer.gains(fit.white)
            best = int(np.argmax(np.where(waves, gains, -np.inf)))
            if gains[best] < STANDS_OUT:
                break
            entry = dictionary.entries[best]
            new = dictionary.filtered[:, entry.first : entry.first + entry.width].astype(np.float64)
            extra = np.column_stack([extra, new])
            scorer.add(balance.whitened(new))
            fit = balance.fit(extra=_scaled(extra))
    residual = _take(balance, extra, fit.freedom)
    dictionary.whiten()
    return residual


def _take(balance: Balance, extra: Floats, freedom: int) -> Floats:
    """Set the balance's noise to the colour of what plain least squares leave, and return that (n,).

    Plain, since a fit in white units may leave slow residuals of any size that the next colour would take for noise.
    """
    balance.noise = Noise(np.ones(1), 1.0)
    plain = balance.fit(extra=_scaled(extra))
    residual = balance.residual(plain, _scaled(extra))
    balance.noise = autoregression(residual, balance.lengths, freedom=freedom)
    return residual


def _scaled(columns: Floats) -> Floats:
    return np.asarray(columns / np.maximum(scipy.linalg.norm(columns, axis=0), 1e-300), dtype=np.float64)
