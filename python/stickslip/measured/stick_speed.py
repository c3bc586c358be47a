"""The speed a block rides at in its sticks, read from the record alone, and held against the belt's set-point.

`signals.find_belt_speed` looks near a set-point; this looks without one, and so sees a set-point in a wrong unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.rig import AnyRig, BlockOnBelt
from stickslip.declared.units import Channel, default_speed_unit, factor
from stickslip.errors import InputError
from stickslip.measured.findings import LOOKED_AT, STRETCHES, stretches
from stickslip.measured.signals import find_belt_speed
from stickslip.measured.signals.timebase import usual_step

Floats = NDArray[np.float64]
PRONOUNCED = 0.5  # width of the commonest fifth of the rates over their size, below which it is a stick
PARTS = (25, 8, 4)  # parts of a period that the rate is taken over
GAP = 10  # samples that stand for a longer gap
FEWEST = 100  # samples of a record that shows its sticks
CLEAR = 1.6  # a ratio to the set-point that neither creep nor a sensor's gain explains
NEAR = 1.25  # the same for a run none of whose sticks was found, which are looked for within this
RETURNS = 2.0  # way at the speed ridden over the range of x1, above which slips bring the block back
TEN = 0.03  # how near a power of ten a ratio must be, in its logarithm to base 10
SPEEDS = ("m/s", "cm/s", "mm/s", "um/s")


class Recorded(Protocol):
    """What of a recording is asked for here."""

    @property
    def rig(self) -> AnyRig:
        """The rig it was recorded on."""

    @property
    def belt_speed(self) -> float:
        """The set-point, in the model's unit."""

    @property
    def t(self) -> Floats:
        """Times, (n,)."""

    @property
    def x1(self) -> Floats:
        """Displacement of the block, (n,)."""

    @property
    def channels(self) -> Mapping[str, Channel]:
        """The channels recorded."""

    def channel(self, name: str) -> str:
        """How a person calls one."""


def commonest_rate(t: Floats, x: Floats, width: int) -> float | None:
    """The rate of x at which the block rides the belt: the middle of its commonest fifth; None if none stands out.

    It must outweigh the opposite rate, which an oscillation without sticks has as often.

    Parameters
    ----------
    t, x : (n,) arrays
        Times and displacement, finite.
    width : int
        Samples that the rate is taken over.
    """
    if t.size > LOOKED_AT:  # a long record shows its commonest rate in stretches
        parts = stretches(t.size).reshape(STRETCHES, -1)
        v = np.sort(np.concatenate([_rates(t[part], x[part], width) for part in parts]))
    else:
        v = np.sort(_rates(t, x, width))
    count = len(v) // 5
    spans = v[count:] - v[:-count]
    at = int(np.argmin(spans))
    middle, half = 0.5 * float(v[at] + v[at + count]), 0.5 * float(spans[at])
    opposite = int(np.count_nonzero(np.abs(v + middle) <= half))
    return middle if 0 < 2 * half < PRONOUNCED * abs(middle) and opposite < 0.4 * count else None


def _rates(t: Floats, x: Floats, width: int) -> Floats:
    """The slope of x over so many samples, at even times (n,)."""
    dt = usual_step(t)
    steps = np.diff(t)
    if steps.max() > GAP * dt:  # a gap says nothing of rates, and a day of it takes gigabytes
        t = np.append(0.0, np.cumsum(np.minimum(steps, GAP * dt)))
    even = np.interp(np.arange(t[0], t[-1], dt), t, x)
    over = max(7, min(width, t.size // 8) | 1)
    return np.asarray(scipy.signal.savgol_filter(even, over, 2, deriv=1, delta=dt))


def ridden_speed(t: Floats, x: Floats, period: float) -> float | None:
    """Speed of the sticks of a record, whatever the belt was said to do; None where no rate stands out.

    In noise the rate is taken over longer stretches; what is found is then refined by `find_belt_speed`.

    Parameters
    ----------
    t, x : (n,) arrays
        Times and displacement; NaN in x is bridged.
    period : float
        Natural period of the block on its spring, in the unit of t.
    """
    if not (good := np.isfinite(x)).all():
        t, x = t[good], x[good]
    if len(t) < FEWEST or np.ptp(x) == 0:
        return None
    samples = period / usual_step(t)
    middle = slice(max(0, (len(t) - LOOKED_AT) // 2), (len(t) + LOOKED_AT) // 2)  # of a long record
    for parts in PARTS:
        width = min(int(samples / parts), len(t) // 8)
        rate = commonest_rate(t, x, width)
        if rate is not None:
            try:
                return find_belt_speed(t[middle], x[middle], rate, within=0.2).speed
            except InputError:  # a rate that few windows share
                return rate
    return None


def wrong_set_point(recording: Recorded, clear: float = CLEAR) -> str | None:
    """What is wrong with the set-point of a block on a belt, in words; None where it is not off by a ratio of `clear`.

    Parameters
    ----------
    recording : Recorded
        Of a `BlockOnBelt`.
    clear : float
        Ratio, above 1.
    """
    rig = recording.rig
    if not isinstance(rig, BlockOnBelt):
        return None
    period = 2 * np.pi * float(np.sqrt(rig.mass / rig.stiffness))
    return contradicted(recording, ridden_speed(recording.t, recording.x1, period), clear)


def contradicted(
    recording: Recorded, ridden: float | None, clear: float, who: str = "the sticks ride at"
) -> str | None:
    """What is wrong with a set-point where another speed was seen, in words; None within a ratio of `clear`.

    Parameters
    ----------
    recording : Recorded
    ridden : float or None
        The speed seen, in the model's unit.
    clear : float
        Ratio, above 1.
    who : str
        What showed it.
    """
    rig, set_point = recording.rig, recording.belt_speed
    if ridden is None or (set_point != 0 and 1 / clear < ridden / set_point < clear):
        return None
    if set_point == 0 and not _returns(recording, ridden):
        return None
    channels = recording.channels
    bare = isinstance(rig, BlockOnBelt) and "1" in (one.unit for one in channels.values())
    unit = "1" if bare else channels["belt"].unit if "belt" in channels else default_speed_unit(rig)
    one = 1.0 if unit == "1" else factor("belt", unit, rig)
    word = "" if unit == "1" else f" {unit}"
    said = f"belt_speed is {set_point / one:.4g}{word}, but {who} {ridden / one:.3g}{word}"
    if set_point == 0:
        return f"{said}: check belt_speed"
    ratio = ridden / set_point
    if ratio < 0:
        return f"{said}: check the sign of belt_speed, and that of {recording.channel('x1')}{_ten(-ratio, unit, rig)}"
    other = "the stiffness, " if "spring_force" in channels else ""
    return (
        f"{said}, {_times(ratio)} that: check belt_speed, {other}and the units of {recording.channel('x1')} and t"
        f"{_ten(ratio, unit, rig)}"
    )


def _returns(recording: Recorded, ridden: float) -> bool:
    """Does a block that rides so fast slip back, unlike one at rest whose sensor drifts?"""
    return abs(ridden) * float(np.ptp(recording.t)) > RETURNS * float(
        np.ptp(recording.x1[np.isfinite(recording.x1)])
    )


def why_idle(recording: Recorded, sticks: int) -> str:
    """Why no slip of a run is used, where `sticks` sticks were found in it at its belt speed."""
    wrong = wrong_set_point(recording, clear=NEAR)
    if wrong:
        return wrong
    if sticks < 2:
        return "nothing in it rises at belt_speed for long: does the block stick, is belt_speed right?"
    return "no slip between two of its sticks stands out from the noise"


def _times(ratio: float) -> str:
    power = round(float(np.log10(ratio)))
    near = power != 0 and abs(np.log10(ratio) - power) < TEN
    return f"{10.0**power if near else float(f'{ratio:.3g}'):.10g} times"


def _ten(ratio: float, unit: str, rig: AnyRig) -> str:
    """The unit that explains a power of ten."""
    power = round(float(np.log10(ratio)))
    if power == 0 or abs(np.log10(ratio) - power) > TEN:
        return ""
    if unit != "1":
        for meant in SPEEDS:
            if abs(np.log10(factor("belt", meant, rig) / factor("belt", unit, rig) / ratio)) < TEN:
                return f"; in '{meant}' it would be right"
    return "; a power of ten is a unit's"
