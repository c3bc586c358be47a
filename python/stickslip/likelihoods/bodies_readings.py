"""From a simulated window of a rig of bodies to what its sensors read: rows, gains, offsets, and their slopes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.shared import SharedNumber
from stickslip.simulated.bodies_lowering import LoweredBodies
from stickslip.simulated.sensed import weights

Floats = NDArray[np.float64]


def sensor_rows(
    lowered: LoweredBodies,
    sensed: Sequence[str],
    numbers: Sequence[SharedNumber],
    at: Floats,
    shared: Sequence[int],
    moves: Mapping[str, Mapping[str, Floats]],
) -> dict[str, tuple[Floats, dict[int, Floats]]]:
    """
    Return the row of weights of what each sensor reads, and what it moves by with shared numbers, by column.

    Parameters
    ----------
    lowered : the model
    sensed : what is read beside the state
    numbers, at, shared : numbers of the hypothesis, their coordinates, and which have columns
    moves : by constant of the rig and by what is read, what rows move by over what is declared
    """
    usual, out = weights(lowered.own), {}
    for name in sensed:
        row, moved = usual[name].copy(), dict[int, Floats]()
        for j, one in enumerate(numbers):
            if name in (by := moves.get(one.name, {})):
                row += (one.value(float(at[j])) - 1.0) * by[name]
                if j in shared:
                    moved[list(shared).index(j)] = by[name]
        out[name] = row, moved
    return out


def gained(
    read: Floats,
    by: Floats,
    names: Sequence[str],
    numbers: Sequence[SharedNumber],
    at: Floats,
    shared: Sequence[int],
) -> None:
    """
    Multiply readings (n, c) by their gains, and their slopes (n, c, columns).

    Parameters
    ----------
    read, by : changed in place
    names : of the gains, one a channel
    numbers, at, shared : numbers of the hypothesis, their coordinates, and which have columns
    """
    for j, one in enumerate(numbers):
        if one.name not in names:
            continue
        c = names.index(one.name)
        plain = read[:, c].copy()
        read[:, c] *= 1.0 + one.value(float(at[j]))
        by[:, c] *= 1.0 + one.value(float(at[j]))
        if j in shared:
            by[:, c, list(shared).index(j)] = plain


def shifted(
    read: Floats,
    by: Floats,
    names: Sequence[str],
    numbers: Sequence[SharedNumber],
    at: Floats,
    shared: Sequence[int],
) -> None:
    """Add to readings their sensors' offsets; as `gained`."""
    for j, one in enumerate(numbers):
        if one.name not in names:
            continue
        c = names.index(one.name)
        read[:, c] += one.value(float(at[j]))
        if j in shared:
            by[:, c, list(shared).index(j)] = 1.0
