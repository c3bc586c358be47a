"""The swings of a block on a base at rest, as its readings show them: turning points, and what these say of friction.

Turning points X about the middle follow ``|X[n+1]| = rho |X[n]| - (1 + rho) F/k`` (Feeny and Liang, J. Sound Vib. 195,
1996): Coulomb friction takes 2 F/k from every swing, viscous damping a share of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from stickslip.declared.rig import BlockOnBelt
from stickslip.errors import InputError
from stickslip.measured.cutting import local_state
from stickslip.measured.fit_window import Array
from stickslip.measured.prepared import Measured

FEWEST = 3  # swings
CLEAR = 8.0  # times the noise: a swing that is one
ENOUGH = 6  # swings from which damping is told beside friction, readings from which a sine is
WITHIN = 1.2  # radians on either side of the fastest place that lie between two turning points


@dataclass(frozen=True)
class Decrement:
    """
    What turning points say.

    Parameters
    ----------
    friction : Coulomb's, a force
    ratio : of neighbouring amplitudes that viscous damping alone would leave, at most 1
    swings : how many half periods
    held, passed : force of the spring where the block came to rest, 0 where it did not, and the least at a turn that it
        went on from: the static limit lies between them
    """

    friction: float
    ratio: float
    swings: int
    held: float = 0.0
    passed: float = math.inf

    def damping(self, rig: BlockOnBelt) -> float:
        """Return the damping that leaves this ratio."""
        log = -math.log(self.ratio) / math.pi
        return 2 * math.sqrt(rig.stiffness * rig.mass) * log / math.sqrt(1 + log**2)


def decrement(turns: Array, stiffness: float) -> Decrement:
    """
    Return the friction of turning points.

    Parameters
    ----------
    turns : (n,) displacements of successive turning points, of alternating sides, the resting place at 0
    stiffness : of the spring

    Raises
    ------
    InputError
        Fewer than three swings, or amplitudes that do not fall.
    """
    size = np.abs(np.asarray(turns, dtype=float))
    if len(size) < FEWEST + 1:
        raise InputError(
            f"{max(len(size) - 1, 0)} swings of a ring-down are seen; at least {FEWEST} are needed"
        )
    if len(size) > ENOUGH:
        slope, level = np.polyfit(size[:-1], size[1:], 1)
        ratio = float(np.clip(slope, 0.05, 1.0))
    else:
        ratio = 1.0
    level = float(np.mean(size[1:] - ratio * size[:-1]))
    friction = -level * stiffness / (1 + ratio)
    if friction <= 0:
        raise InputError(
            "the swings of a ring-down do not fall as friction makes them: nothing is told of it"
        )
    return Decrement(friction, ratio, len(size) - 1)


def turning_points(run: Measured, rig: BlockOnBelt) -> tuple[Array, Array]:
    """
    Return samples and displacements of the turning points of a run, (n,) each, while its swings are clear.

    Each is where the sine of the half swing before it ends: a parabola through what is near it is flatter, and a sample
    is beside it.
    """
    v, t, w = run.track.v, run.t, math.sqrt(rig.stiffness / rig.mass)
    fastest = int(np.nanargmax(np.abs(v)))
    crossings = fastest + np.flatnonzero(np.sign(v[fastest:-1]) * np.sign(v[fastest + 1 :]) < 0)
    at: list[int] = []
    places: list[float] = []
    for i in crossings.tolist():
        way = np.sign(v[fastest]) * (-1) ** len(places)
        place, _ = local_state(t, run.readings[:, 0], i, max(run.track.width, 3))
        if places and (place - places[-1]) * way < CLEAR * run.noise[0]:
            break
        found = _sine(run, float(t[i]) - 0.5 * math.pi / w, w)  # it was fastest a quarter of a period before
        at.append(i)
        places.append(place if found is None else float(found[0] + way * math.hypot(*found[1:])))
    return np.array(at, dtype=int), np.array(places)


def _sine(run: Measured, middle: float, w: float) -> Array | None:
    """
    A sine of the rig's frequency about a middle that friction shifts, at most a swing long: (3,) of 1, cos and sin.

    It is what moves between two turning points under Coulomb friction. None where readings are too few.
    """
    near = slice(*np.searchsorted(run.t, [middle - WITHIN / w, middle + WITHIN / w]))
    x, phase = run.readings[near, 0], w * (run.t[near] - middle)
    good = np.isfinite(x)
    if good.sum() < ENOUGH:
        return None
    shapes = np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)])[good]
    return np.asarray(np.linalg.lstsq(shapes, x[good], rcond=None)[0], dtype=np.float64)


def decrement_of(run: Measured, rig: BlockOnBelt) -> Decrement:
    """Return what the turning points of a run say, and between what the static limit lies; as `decrement` raises."""
    at, places = turning_points(run, rig)
    try:
        found = decrement(places, rig.stiffness)
    except InputError as error:
        raise InputError(f"{run.name}: {error}") from None
    size, last, after = rig.stiffness, float(places[-1]), run.readings[at[-1] :, 0]
    still = CLEAR * float(run.noise[0])
    rests = float(np.nanmax(np.abs(after - last))) < still
    end = run.readings[run.t > run.t[-1] - 0.5 * math.pi * math.sqrt(rig.mass / rig.stiffness), 0]
    held = (
        abs(last)
        if rests
        else abs(float(np.nanmean(end)))
        if float(np.nanmax(end) - np.nanmin(end)) < still
        else 0.0
    )
    passed = float(np.min(np.abs(places[:-1] if rests else places)))
    return replace(found, held=size * held, passed=size * passed)


def zero_of(run: Measured, rig: BlockOnBelt) -> float:
    """What a run reads where the spring is slack: between the middles of two swings; 0 where that is not clear."""
    v, t, w = run.track.v, run.t, math.sqrt(rig.stiffness / rig.mass)
    fastest = int(np.nanargmax(np.abs(v)))
    turns = t[fastest + np.flatnonzero(np.sign(v[fastest:-1]) * np.sign(v[fastest + 1 :]) < 0)][: ENOUGH + 1]
    swings = [_sine(run, float(middle), w) for middle in 0.5 * (turns[1:] + turns[:-1])]
    middles = np.array([one[0] for one in swings if one is not None])
    between = 0.5 * (middles[1:] + middles[:-1])
    if len(between) < FEWEST:
        return 0.0
    error = float(np.std(between, ddof=1)) / math.sqrt(len(between))
    zero = float(np.mean(between))
    return zero if abs(zero) > CLEAR * max(error, run.noise[0] / math.sqrt(len(t))) else 0.0


def passing(run: Measured, at: int, rig: BlockOnBelt) -> tuple[float, float]:
    """Where the block is, and how fast."""
    w = math.sqrt(rig.stiffness / rig.mass)
    found = _sine(run, float(run.t[at]), w)
    if found is None:
        return local_state(run.t, run.readings[:, 0], at, max(run.track.width, 3))
    return float(found[0] + found[1]), float(w * found[2])
