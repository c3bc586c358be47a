"""The runs of a fit as a report draws them."""

from __future__ import annotations

from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.result import RunView
from stickslip.discovery.views import Made, nothing, view
from stickslip.fitted.readings import reading_rate
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit_state import Fit


def train_views(bench: Bench, before: Fit, after: Fit) -> list[RunView]:
    """Return the runs of the fit."""
    was, now = (_made(bench, fit) for fit in (before, after))
    return [
        view(run, one, other, bench.model.rig) for run, one, other in zip(bench.data, was, now, strict=True)
    ]


def _made(bench: Bench, fit: Fit) -> list[Made]:
    """What a fit makes of each run; NaN where no window is."""
    assert isinstance(fit.windows, BeltWindows)
    out, beside = [nothing(run) for run in bench.data], fit.windows.beside
    for s, motion in zip(bench.stretches, fit.windows.motions(fit.at, fit.own), strict=True):
        if motion is None:
            continue
        made, rows = out[s.run], slice(s.start, s.stop)
        made.readings[rows], made.state[rows], made.mode[rows] = motion.readings, motion.state, motion.mode
        made.rate[rows] = reading_rate(motion.t, motion.state, fit.values(s.run), beside)
    return out
