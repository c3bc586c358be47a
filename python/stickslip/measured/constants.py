"""Is a constant of a block declared in another unit: a mass in g, a stiffness in N/mm? The runs show what it is.

From the crest of x1 before a slip to the trough behind it a block swings half a turn of its own frequency,
omega^2 = k/m, whatever friction is constant; no belt speed and no declared number is needed to see it. A force channel
shows the stiffness: it grows by k v_b in sticks. And a declared law shows it where the block breaks away: k x1 is the
static limit. What is off by a power of 1000 is a prefix of a unit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.rig import LONG, BlockOnBelt
from stickslip.declared.si import scales_of
from stickslip.declared.uncertainty import Uncertainty
from stickslip.declared.units import in_si
from stickslip.errors import InputError
from stickslip.measured.case import Case
from stickslip.measured.prefixes import power, put_right, times
from stickslip.measured.recording import Recording
from stickslip.measured.stick_speed import commonest_rate

Floats = NDArray[np.float64]
LEGS = 3  # swings, at least, that a frequency is read from
SHORTEST = 4  # samples in half a turn


def swing_rate(t: Floats, x: Floats) -> float | None:
    """Angular frequency of a block's slips, by the quicker way between a crest of x (n,) and a trough; None: unseen."""
    good = np.isfinite(x)
    t, x = t[good], x[good]
    if len(t) < SHORTEST * LEGS:
        return None
    low, high = np.quantile(x, [0.02, 0.98])
    crests, troughs = (
        scipy.signal.find_peaks(side * x, prominence=0.5 * (high - low))[0] for side in (1, -1)
    )
    if high <= low or min(len(crests), len(troughs)) < LEGS:
        return None
    legs = [_next(t[one], t[other]) for one, other in ((crests, troughs), (troughs, crests))]
    if min(len(one) for one in legs) < LEGS:
        return None
    half = min(float(np.median(one)) for one in legs)
    return math.pi / half if half > SHORTEST * float(np.median(np.diff(t))) else None


def _next(starts: Floats, ends: Floats) -> Floats:
    """Times from each start to the next end that comes before the next start."""
    at = np.searchsorted(ends, starts)
    known = at < len(ends)
    starts, found = starts[known], ends[at[known]]
    own = np.append(found[:-1] < starts[1:], True)
    return np.asarray((found - starts)[own])


@dataclass(frozen=True)
class ShownConstant:
    """What the runs show of a block on a belt over what is declared: k/m, and k where a force or a law tells."""

    rate: float  # omega^2
    stiffness: float | None


def block_constants(case: Case) -> None:
    """Refuse a block on a belt whose mass or stiffness was given in another unit than it is taken in.

    Raises
    ------
    InputError
        Which number, by what power of 1000 it is off, and what would be right.
    """
    known = case.uncertainty
    shown = None if scales_of(case.rig, case.channels) is None else _shown(case)
    if shown is None:
        return
    off = power(shown.rate, math.hypot(known.relative("mass"), known.relative("stiffness")))
    if not off:
        return
    if shown.stiffness is None:
        told = _by_rate_alone(known, off)
    else:
        k = power(shown.stiffness, known.relative("stiffness"))
        told = [_together(known, {"stiffness": k, "mass": k - off})]
    clock = _clock(case, off, shown.stiffness)
    told = [clock] if clock and off < 0 else [*told, *([clock] if clock else [])]
    head = f"the slips of the train runs swing with {times(shown.rate)} the k/m that [rig] declares"
    raise InputError(f"{head}: {'; or '.join(told)}")


def _shown(case: Case) -> ShownConstant | None:
    """Medians over the train runs; None where their frequency is not seen."""
    rates, forces = [], []
    for run in case.train:
        rig, rate = run.rig, swing_rate(run.t, run.x1)
        if rate is None or not isinstance(rig, BlockOnBelt):
            continue
        rates.append(rate**2 * rig.mass / rig.stiffness)
        force = _by_force(run, rate) if "spring_force" in run.channels else _by_law(case, run, rig)
        if force is not None:
            forces.append(force)
    if not rates:
        return None
    return ShownConstant(float(np.median(rates)), float(np.median(forces)) if forces else None)


def _by_force(run: Recording, rate: float) -> float | None:
    """True stiffness over the declared: x1 is the force over the declared one, and grows at belt speed in sticks."""
    width = int(0.1 * 2 * math.pi / rate / float(np.median(np.diff(run.t))))
    good = np.isfinite(run.x1)
    ridden = commonest_rate(run.t[good], run.x1[good], width) if run.belt_speed else None
    return None if ridden is None or ridden / run.belt_speed <= 0 else ridden / run.belt_speed


def _by_law(case: Case, run: Recording, rig: BlockOnBelt) -> float | None:
    """True stiffness over the declared: at the largest deflection the spring bears the declared static limit."""
    if not {"static", "scale", "T_s_minus"} & set(case.declared_numbers):
        return None
    limit = case.friction.static_limits[0 if run.belt_speed > 0 else 1]
    reach = float(np.nanquantile(np.sign(run.belt_speed) * run.x1, 0.98))
    return limit / (rig.stiffness * reach) if reach > 0 and limit > 0 else None


def _together(known: Uncertainty, powers: Mapping[str, int]) -> str:
    """Mass and stiffness put right together, those that are off."""
    told = []
    for number, n in powers.items():
        name = next(name for name in known.values if LONG.get(name, name) == number)
        if n:
            told.append(put_right({name: known.values[name]}, BlockOnBelt.dimensions[number].unit, n))
    return " and ".join(told)


def _by_rate_alone(known: Uncertainty, off: int) -> list[str]:
    """What may be off where the readings are displacements and no declared law says how large forces are."""
    told = [_together(known, {"mass": -off}), _together(known, {"stiffness": off})]
    return [*told, _together(known, {"mass": -off // 2, "stiffness": off // 2})] if off % 2 == 0 else told


def _clock(case: Case, off: int, stiffness: float | None) -> str | None:
    """Times in another unit change k/m by its square, and a force's rate by itself; None where no unit does that."""
    if off % 2 or (stiffness is not None and power(stiffness) != off // 2):
        return None
    unit = case.channels["t"].unit
    sizes = {
        one: in_si(one, "s", what="a time") / in_si(unit, "s", what="a time") for one in ("s", "ms", "us")
    }
    meant = next((one for one, size in sizes.items() if math.isclose(size, 1000.0 ** (off // 2))), None)
    return (
        None if meant is None else f"channel t is in '{unit}' by [channels]; with '{meant}' it would be right"
    )
