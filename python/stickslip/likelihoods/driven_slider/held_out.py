"""How far off a fitted slider is on runs that were not fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.declared.model import Model
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.driven import missed_ahead
from stickslip.likelihoods.driven_slider.banded import BandedBalance
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.likelihoods.driven_slider.prepared import balance, check_samples
from stickslip.measured.recording import Recording

NAN = float("nan")


@dataclass(frozen=True)
class HeldOut:
    """Errors of a fitted law on runs not fitted.

    `force` is what is unexplained over the drive, within the band, `position` [m] how far off positions are
    `STEER.ahead` seconds on; `floor` and `position_floor` are what noise as large as on the fitted runs leaves. `why`
    there are none.
    """

    force: float = NAN
    floor: float = NAN
    position: float = NAN
    position_floor: float = NAN
    why: str = ""


def held_out(
    runs: Sequence[Recording], fitted: BandedBalance, fit: MotionFit, model: Model
) -> HeldOut | None:
    """Errors on some runs; None without any. Runs that nothing can be said of do not stop an identification."""
    if not runs:
        return None
    runs = [run for run in runs if len(run) > 2 * fitted.band.half + 1]
    if not runs:
        return HeldOut(
            why=f"none is longer than the {2 * fitted.band.half + 1} samples that a force balance needs"
        )
    try:
        check_samples(runs)
        own = balance(runs, fitted.balance.declared)
    except InputError as error:
        return HeldOut(why=str(error))
    own.like(fitted.balance)
    shown = BandedBalance(own, fitted.band)
    total = float(np.linalg.norm(shown.force))
    noise = shown.floor(fit) * float(np.sqrt(sum(shown.lengths)))
    off, least = (
        float(np.sqrt(np.mean(np.square(one))))
        for one in (
            [forecasts(model, run, STEER.ahead) for run in runs],
            [floor_of_forecast(fit, run, STEER.ahead) for run in runs],
        )
    )
    return HeldOut(
        share(float(np.linalg.norm(shown.unexplained(fit))), total), share(noise, total), off, least
    )


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
