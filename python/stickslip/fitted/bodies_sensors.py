"""What sensors say beside coordinates: where the force in a link puts the bodies, and where readings jump."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.rigs.general import Equations

Floats = NDArray[np.float64]
STANDS_OUT = 4.0  # standard deviations of the difference of two readings that noise does not make
OFF = 0.05  # share by which a way may be read otherwise than it is set
DETERMINED = 1e-6  # how nearly a coordinate must follow from links


def may_jump(own: Equations, quantity: str) -> bool:
    """Say whether a reading is an acceleration or friction: where a contact comes to rest or lets go they jump."""
    return quantity in own.sensed and quantity[:2] in ("a_", "T_")


def jumps(x: Floats, noise: float) -> NDArray[np.bool_]:
    """
    Return the readings on both sides of a jump, (n,).

    On which side of one a reading lies, its time does not say: where a model jumps a sample earlier, the two differ by
    the whole jump. A jump is a step that stands out against the ones before and after it.

    Parameters
    ----------
    x : (n,) readings
    noise : standard deviation of one
    """
    out = np.zeros(len(x), dtype=bool)
    step = np.abs(np.diff(x))
    padded = np.concatenate([[0.0], step, [0.0]])
    around = np.maximum(padded[:-2], padded[2:])
    at = np.flatnonzero(step > STANDS_OUT * np.sqrt(2.0) * noise + 2.0 * around)
    out[at] = out[at + 1] = True
    return out


def followed(own: Equations, read: Mapping[str, Floats], go: Floats) -> float:
    """
    Return how far the drive goes by the positions that follow it, over how far it goes as set.

    Gains and set-points are nearly right; over a long way that is more than a spring ever deflects. Else it is 1.

    Parameters
    ----------
    own : the rig
    read : readings (n,) by what they read
    go : (n,) how far the drive has come by its set-point
    """
    if not np.ptp(go) or np.linalg.matrix_rank(own.K) < len(own.names):
        return 1.0
    follows = np.linalg.solve(own.K, own.drive_stiffness)
    for name, share in zip(own.names, follows.tolist(), strict=True):
        if name in read and share:
            slope, start = np.polyfit(share * go, read[name], 1)
            swings = float(np.std(read[name] - slope * share * go - start))
            if swings / float(np.ptp(share * go)) < abs(slope - 1) < OFF:
                return float(slope)
    return 1.0


def placed_by_links(
    own: Equations, t: Floats, read: Mapping[str, Floats], noise: Mapping[str, float], go: Floats
) -> dict[str, tuple[Floats, float]]:
    """
    Return coordinates that are not read but follow from forces in links, by name: (n,) and their noise.

    Parameters
    ----------
    own : the rig
    t : (n,) times
    read, noise : readings (n,) by what they read, and their standard deviations
    go : (n,) how far the drive has come
    """
    lost = [i for i, name in enumerate(own.names) if name not in read]
    links = [one for one in own.links if f"F_{one.name}" in read and one.stiffness]
    if not lost or not links:
        return {}
    rows, sides, sizes = [], [], []
    known = [i for i in range(len(own.names)) if i not in lost]
    for one in links:
        # of the spring; what the damper adds follows from how fast that changes
        spring = read[f"F_{one.name}"] / one.stiffness
        spring = spring - one.damping / one.stiffness * np.gradient(spring, t) if one.damping else spring
        side = spring + one.rest - one.of_drive * go
        for i in known:
            side = side - one.row[i] * read[own.names[i]]
        sizes.append(noise[f"F_{one.name}"] / abs(one.stiffness))
        rows.append(one.row[lost])
        sides.append(side)
    A, size = np.array(rows), np.array(sizes)
    inverse = np.linalg.pinv(A / size[:, None])
    told = np.abs(inverse @ (A / size[:, None]) - np.eye(len(lost))).max(axis=1) < DETERMINED
    found = inverse @ (np.array(sides) / size[:, None])
    doubt = np.linalg.norm(inverse, axis=1)
    return {own.names[i]: (found[k], float(doubt[k])) for k, i in enumerate(lost) if told[k]}
