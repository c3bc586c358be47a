"""How far off a fitted slider is on runs that were not fitted."""

from __future__ import annotations

import numpy as np

from stickslip.declared.model import Model
from stickslip.errors import StickslipError
from stickslip.fitted.driven import missed_ahead
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.measured.recording import Recording

NAN = float("nan")


def share(part: float, whole: float) -> float:
    """A part of a whole; nan where there is no whole: no drive, or no motion."""
    return part / whole if whole > 0 else NAN


def forecasts(model: Model, run: Recording, ahead: float) -> float:
    """Root mean square error of the position `ahead` seconds on [m]; nan of a model that cannot be simulated."""
    try:
        return float(np.sqrt(np.mean(missed_ahead(model, run, ahead) ** 2)))
    except StickslipError:
        return NAN


def floor_of_forecast(fit: MotionFit, run: Recording, ahead: float) -> float:
    """The same error that the process noise alone makes: drawn and integrated twice."""
    step = float(np.median(np.diff(run.t)))
    steps = round(ahead / step)
    generator = np.random.default_rng(0)
    ends = []
    for _ in range(200):
        _, d = fit.noise.drawn(steps, generator)
        ends.append(np.sum(np.cumsum(d)) * step**2)
    return float(np.sqrt(np.mean(np.square(ends))))
