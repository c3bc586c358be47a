"""Where a body is whose position is not read: where its contact lets go at the static limit when it is seen to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.bodies_model import law_of
from stickslip.declared.model import Model
from stickslip.declared.rigs.general import Equations
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.bodies_cuts import Cut
from stickslip.simulated.general import General

Floats = NDArray[np.float64]
AHEAD = 3  # samples of a slip that say which way it goes


def carried(rig: Equations, run: BodiesData, i: int, direction: Floats, q: Floats) -> float:
    """
    Return the friction that holds a contact at a sample, by the springs and dampers on it.

    Parameters
    ----------
    rig, run, i : equations, a run and a sample of it
    direction : (n,) of the contact
    q : (n,) where the rig is
    """
    pulls = rig.force - rig.K @ q - rig.C @ run.v[i]
    pulls = pulls + rig.drive_stiffness * (run.drawn + float(run.drive.way(run.t[i])))
    pulls = pulls + rig.drive_damping * float(run.drive(run.t[i]))
    return float(direction @ pulls / (direction @ direction))


def let_go(run: BodiesData, window: Cut, own: General, model: Model) -> Floats:
    """
    Return what positions that are not read are to be moved by at the start of a window, (coordinates,).

    A velocity says how far a body goes, and not from where; when it lets go depends on that more than all else does.

    Parameters
    ----------
    run, window : a run and a window of it
    own, model : the rig as it is simulated, and the declared model
    """
    rig = own.equations
    out = np.zeros(len(rig.names))
    lost = ~np.array(run.placed, dtype=bool) if run.placed else np.zeros(len(rig.names), dtype=bool)
    stiff = rig.K[np.ix_(lost, lost)]
    for j, (contact, mode) in enumerate(zip(rig.contacts, window.modes, strict=False)):
        along = contact.direction[lost]
        if mode != 0 or not along.any():
            continue
        free = np.flatnonzero(~run.stuck[window.start : window.stop, j])
        if not len(free):
            continue
        first = window.start + int(free[0])
        last = max(first - 1, window.start)
        ahead = slice(first, min(first + AHEAD, window.stop))
        slip = float(np.mean(contact.slip(run.v[ahead], run.belt(run.t[ahead]))))
        limit = law_of(model.friction, contact).static_limits[0 if slip < 0 else 1]
        held = carried(rig, run, last, contact.direction, run.q[last] + out)
        out[lost] -= np.linalg.pinv(stiff) @ along * (np.sign(slip) * limit - held)
    return out
