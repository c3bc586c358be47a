"""The error on runs never fitted, of a rig of bodies or matrices: one window ahead, with friction of the mean event."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stickslip.declared.model import Model
from stickslip.discovery.result import ErrorBlock, RunError
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.bodies_ahead import Ahead, one_ahead
from stickslip.likelihoods.bodies_cuts import cuts
from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.own_phases import with_own_drive, with_own_phases
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared
from stickslip.measured.recording import Recording

METRIC = (
    "error of the readings one window (a stick and the slips after it) ahead of where the window before ends, with "
    "friction of the mean event, over how far they move in it; mean over validate runs"
)
WHO = ("before", "after", "floor")
NONE = dict.fromkeys(WHO, math.nan)


def error_block(
    before: Model, after: Model, runs: Sequence[BodiesData], recordings: Sequence[Recording]
) -> tuple[ErrorBlock, list[tuple[Ahead, Ahead]]]:
    """
    Return `error` of the report, and the forecasts that it rests on.

    The floor is what noise of the readings alone leaves; that friction of the next event is not known comes on top.
    """
    rows, kept = [], []
    for run, recording in zip(runs, recordings, strict=True):
        now = ahead(after, run)
        was = now if before == after else ahead(before, run)
        kept.append((was, now))
        rows.append(_row(run, recording, was, now))
    mean = {who: float(np.nanmean([row.one_cycle[who] for row in rows])) for who in WHO}
    return ErrorBlock(METRIC, mean["before"], mean["after"], mean["floor"], tuple(rows)), kept


def ahead(model: Model, run: BodiesData) -> Ahead:
    """Return what a model forecasts of a run, one window ahead.

    Raises
    ------
    InputError
        The run is too short.
    """
    cut = cuts([run])
    if not any(a.stop == b.start for a, b in zip(cut[:-1], cut[1:], strict=True)):
        raise InputError(f"run '{run.name}' is too short to be forecast window by window")
    run = with_own_drive(model, run, cut)
    own = with_own_phases(model, run, cut)
    return one_ahead(null(BodiesWindows(own, [run], cut, [], Declared()), POLICY), run)


def _row(run: BodiesData, recording: Recording, was: Ahead, now: Ahead) -> RunError:
    error = {"before": was.error, "after": now.error, "floor": now.floor}
    rmse, unit = {}, {}
    for c, name in enumerate(run.channels):
        factor = recording.factors.get(name, 1.0)
        sizes = (was.off[c], now.off[c], run.noise[c])
        rmse[name] = {who: float(size / factor) for who, size in zip(WHO, sizes, strict=True)}
        unit[name] = recording.channels[name].unit if name in recording.channels else "1"
    return RunError(run.name, run.belt_speed, error, NONE, NONE, NONE, NONE, NONE, rmse, unit)
