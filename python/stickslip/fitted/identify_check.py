"""What is not worth identifying: a case that cannot be what it says, and a rig that no law moves like the readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stickslip.declared.rig import Rig
from stickslip.declared.scale import plainly
from stickslip.errors import InputError
from stickslip.fitted.data import one_rig, prepare
from stickslip.fitted.identify_words import spread_share
from stickslip.fitted.plausible import plausible
from stickslip.fitted.shooting import Shot
from stickslip.measured.case import Case, Recording
from stickslip.measured.constants import block_constants
from stickslip.measured.fit_window import Array

LONG = 60  # samples of a run that the check can look at
LOST = 0.9  # of the readings' spread: hardly better than a block that stands still; a strong missing effect leaves 0.8


def checked(case: Case, train: Sequence[Recording]) -> tuple[str, ...]:
    """What `discover` would say of the channels of the train runs, for a rig of (2.1).

    Parameters
    ----------
    case : Case
    train : sequence of Recording
        Its train runs, as they are fitted.

    Raises
    ------
    InputError
        As `discover` refuses a wrong unit, sign or column, a constant in another unit, or a run of another rig.
    """
    one_rig(case.rig, train)
    case = replace(case, runs=tuple(train))
    if not isinstance(case.rig, Rig):
        block_constants(case)
        return ()
    runs = [run for run in train if run.y1 is not None and len(run.t) >= LONG]
    if not runs:
        return ()
    return plausible(case, prepare(runs))[1]


def misfit(shot: Shot, noise: Array) -> float:
    """Root mean square of readings minus simulation over the readings' spread within windows, of the worse channel.

    `noise` (c,) is that of a single reading.
    """
    off, spread = np.zeros(len(noise)), np.zeros(len(noise))
    for window, residual in zip(shot.windows, shot.residuals, strict=True):
        off += np.sum((residual * noise) ** 2, axis=0) / window.averaged
        spread += np.nansum((window.readings - np.nanmean(window.readings, axis=0)) ** 2, axis=0)
    return float(np.sqrt(np.max(off / np.maximum(spread, 1e-300))))


def explainable(shot: Shot, noise: Array) -> None:
    """Refuse what the law does not explain even within windows of one period, each from a state of its own.

    Raises
    ------
    InputError
        By how much it is off, and what to look at.
    """
    share = misfit(shot, noise)
    if not share <= LOST:
        raise InputError(
            f"even single periods differ from the readings by {plainly(np.sqrt(shot.reduced), 3)} times the noise, "
            f"{spread_share(share)}: no friction moves this rig so; are its numbers (masses in kg), "
            "the units of [channels] and the belt speeds right?"
        )
