"""What sensors read of a rig of bodies or matrices: rows of weights over all that the core says of a sample.

A reading is a row times (q, q', states of laws and effects, ways of the belt and the drive, q'', friction T of the
contacts, forces of effects, speeds of the belt and the drive, 1). Where friction or an effect jumps, it is what follows
the jump.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.rigs.general import Equations, GeneralRig
from stickslip.simulated.bodies_lowering import NOMINAL, LoweredBodies
from stickslip.simulated.general import General

Floats = NDArray[np.float64]


def everything(raw: Mapping[str, Any]) -> Floats:
    """Return what the core says of every sample, (n, w); it was asked for what is `sensed`."""
    return np.concatenate([raw["state"], raw["sensed"], np.ones((len(raw["t"]), 1))], axis=1)


def everything_moves(raw: Mapping[str, Any]) -> Floats:
    """Return the derivatives of that, (n, w, p)."""
    moves = raw["sensitivity"]
    return np.concatenate(
        [moves, raw["sensed_sensitivity"], np.zeros((len(moves), 1, moves.shape[2]))], axis=1
    )


def weights(own: General, equations: Equations | None = None) -> dict[str, Floats]:
    """
    Return the row of every channel but the prescribed speeds' and the time's, (w,).

    Parameters
    ----------
    own : what is simulated
    equations : of the same rig with another number; of `own` if absent
    """
    eq = equations or own.equations
    n, m, speeds = len(eq.names), len(eq.contacts), int(eq.on_belt) + int(eq.driven)
    moving = 2 * n + len(own.hidden)
    begins = moving + speeds
    push = begins + n + m
    count = push + len(own.effects.pushes) + speeds + 1
    unit = np.eye(count)
    states = (*eq.names, *(f"v_{name}" for name in eq.names))
    out = {name: unit[i] for i, name in enumerate(states)}
    out |= {f"a_{name}": unit[begins + i] for i, name in enumerate(eq.names)}
    out |= {f"T_{one.name}": unit[begins + n + j] for j, one in enumerate(eq.contacts)}
    for one in eq.links:
        row, of = np.zeros(count), one.weights
        row[: 2 * n], row[-1] = of[: 2 * n], of[-1]
        if eq.driven:  # the last of the prescribed speeds
            row[begins - 1], row[-2] = of[2 * n : 2 * n + 2]
        for e, added in enumerate(own.effects.pushes):
            if added.link == one.name:
                row[push + e] -= 1.0
        out[f"F_{one.name}"] = row
    return out


def weights_move(lowered: LoweredBodies, names: Iterable[str], relative: bool = False) -> dict[str, Floats]:
    """
    Return what the rows move by with numbers of the rig that grow together, (w,); those that do not are left out.

    Parameters
    ----------
    lowered : the model
    names : of `Model.parameters`; those of no rig move nothing
    relative : over what the numbers are
    """
    rig, out = lowered.model.rig, dict[str, Floats]()
    known = rig.numbers if isinstance(rig, GeneralRig) else {}
    for name in names:
        if name not in known or name in lowered.places:
            continue
        size = known[name]
        step = NOMINAL * (abs(size) or 1.0)
        low, high = (weights(lowered.own, lowered.moved_equations(name, size + one)) for one in (-step, step))
        for channel in low:
            row = (high[channel] - low[channel]) / (2 * step) * (size if relative else 1.0)
            if row.any():
                out[channel] = out.get(channel, 0.0) + row
    return out


def sensed(
    lowered: LoweredBodies, raw: Mapping[str, Any], names: tuple[str, ...]
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """
    Return what is sensed beside the state by channel, (n,), and its derivatives by parameters, (n, p).

    Parameters
    ----------
    lowered : the model
    raw : what the core returned, with what is `sensed`
    names : of the parameters
    """
    rows, every, moves = weights(lowered.own), everything(raw), everything_moves(raw)
    moved = [weights_move(lowered, [name]) for name in names]
    values, slopes = dict[str, Floats](), dict[str, Floats]()
    for channel in lowered.own.equations.sensed:
        values[channel] = every @ rows[channel]
        slopes[channel] = rows[channel] @ moves
        for k, one in enumerate(moved):
            if channel in one:
                slopes[channel][:, k] += every @ one[channel]
    return values, slopes
