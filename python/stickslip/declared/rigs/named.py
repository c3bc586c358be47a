"""The equations of a named rig as those of a rig of matrices."""

from __future__ import annotations

import numpy as np

from stickslip.declared.rig import AnyRig, BlockOnBelt, Rig
from stickslip.declared.rigs.general import Against, ContactRow, Equations, GeneralRig, Unit


def equations_of(rig: AnyRig) -> tuple[Equations, tuple[int, ...]]:
    """Equations of a rig, and the places of its states among (q, v).

    The drive of a driven slider acts as through a damper of 1: its "speed" is the force.
    """
    if isinstance(rig, GeneralRig):
        return rig.equations, tuple(range(2 * len(rig.equations.names)))
    names: tuple[str, ...] = ("x1",)
    order: tuple[int, ...] = (0, 1)
    against: Against = "belt"
    pull = 0.0
    if isinstance(rig, BlockOnBelt):
        matrices = ([[rig.mass]], [[rig.damping]], [[rig.stiffness]])
    elif isinstance(rig, Rig):
        s = 1.0 if rig.coupling == "reciprocal" else -1.0
        C = [[rig.eta1, rig.eta1], [rig.eta1, rig.eta12]]
        matrices = ([[rig.alpha1, 0.0], [0.0, rig.alpha2]], C, [[rig.alpha1, s], [1.0, rig.beta3]])
        names, order = ("x1", "y1"), (0, 2, 1, 3)
    else:
        matrices, against, pull = ([[rig.mass]], [[rig.damping]], [[0.0]]), "ground", 1.0
    M, C_, K = (np.array(one) for one in matrices)
    n = len(names)
    contact = ContactRow("block", np.eye(n)[0], against, "", False)
    zero = np.zeros(n)
    units: tuple[Unit, ...] = tuple("m" for _ in names)
    return Equations(names, units, M, C_, K, zero, zero, zero + pull, (contact,)), order
