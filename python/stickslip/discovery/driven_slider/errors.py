"""Errors on the validate runs: of the force, and of forecasts of the position under the recorded drive."""

from __future__ import annotations

import numpy as np

from stickslip.declared.model import Model
from stickslip.discovery.result import ErrorBlock, RunError
from stickslip.likelihoods.driven_slider.banded import BandedBalance
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.likelihoods.driven_slider.held_out import NAN, floor_of_forecast, forecasts, share
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.measured.case import Case

METRIC = (
    "norm of the force that the model leaves unexplained over that of the drive, on the validate runs, within the"
    " band in which the drive explains the acceleration; friction at rest left free"
)


def error_block(
    case: Case, validate: BandedBalance, null: MotionFit, chosen: MotionFit, before: Model, after: Model
) -> ErrorBlock:
    """Both errors of every validate run, before and after; the floor is what the noise alone leaves."""
    ends = np.cumsum(validate.lengths)
    left = {"before": validate.unexplained(null), "after": validate.unexplained(chosen)}
    floor = validate.floor(chosen)
    rows = []
    for run, stop, length in zip(case.validate, ends, validate.lengths, strict=True):
        part = slice(stop - length, stop)
        total = float(np.linalg.norm(validate.force[part]))
        force = {k: share(float(np.linalg.norm(v[part])), total) for k, v in left.items()}
        force["floor"] = share(floor * float(np.sqrt(length)), total)
        position = {
            "before": forecasts(before, run, STEER.ahead),
            "after": forecasts(after, run, STEER.ahead),
            "floor": floor_of_forecast(chosen, run, STEER.ahead),
        }
        none = {"before": NAN, "after": NAN, "floor": NAN}
        unit = {"x1": run.unit("x1"), "drive": "1"}
        per = run.factor("x1") / run.channels["x1"].scale
        rmse = {"x1": {k: v / per for k, v in position.items()}, "drive": force}
        moved = float(np.std(run.x1))
        rows.append(
            RunError(
                run.name,
                0.0,
                force,
                {k: share(v, moved) for k, v in position.items()},
                none,
                none,
                none,
                none,
                rmse,
                unit,
            )
        )
    total = float(np.linalg.norm(validate.force))
    whole = {k: share(float(np.linalg.norm(v)), total) for k, v in left.items()}
    noise = share(floor * float(np.sqrt(sum(validate.lengths))), total)
    return ErrorBlock(METRIC, whole["before"], whole["after"], noise, tuple(rows))
