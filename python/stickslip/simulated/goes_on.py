"""Where a run ends, as the start of the one that goes on from it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.errors import InputError
from stickslip.simulated.states import HIDDEN
from stickslip.simulated.trajectory import Trajectory

Mode = Literal["auto", "stick", "slip-", "slip+"]
NAMED: dict[int, Mode] = {-1: "slip-", 0: "stick", 1: "slip+"}


def where_it_ends(
    run: Trajectory, model: Model, t_start: float, contact: Mode | Sequence[Mode], *, of_bodies: bool
) -> tuple[float, NDArray[np.float64], Mode | Sequence[Mode]]:
    """
    Return time, state with what is hidden, and modes at the last sample of a run.

    Parameters
    ----------
    run : that goes on
    model : that goes on with it
    t_start, contact : as given, if they were
    of_bodies : whether what goes on is simulated as a rig of bodies or matrices

    Raises
    ------
    InputError
        The run is of another rig, has no samples, or a start of another time or mode is given; a named rig goes on
        under a belt of another kind, whose way and rest are kept elsewhere.
    """
    if run.state_names != model.rig.state_names:
        raise InputError("is a run of another rig than the model's", key="initial")
    if not len(run.t):
        raise InputError("is a run without samples; nothing goes on from it", key="initial")
    end = float(run.t[-1])
    if t_start not in (0.0, end):
        raise InputError(f"the run to go on from ends at {end:g}; leave it out", key="t_start", value=t_start)
    if contact != "auto":
        raise InputError("the run to go on from has its own; leave it out", key="contact", value=contact)
    if of_bodies != (len(run.rested) > 0):
        words = "goes on as it began: under a belt at a constant speed, or under one by a formula"
        raise InputError(words, key="initial")
    hidden = run.hidden_names if of_bodies else HIDDEN
    state = np.array(
        [*run.state[-1], *(float(run.hidden[k][-1]) if k in run.hidden_names else 0.0 for k in hidden)]
    )
    modes = [NAMED[int(one)] for one in np.atleast_1d(run.mode[-1])]
    return end, state, modes if run.mode.ndim > 1 else modes[0]
