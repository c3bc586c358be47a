"""Is a constant of the rig of (2.1) declared in another unit? Its own frequency, and the angle body's line, say so.

The block swings with omega^2 = (k1 + k2)/m in its slips, and the angle body's line of (2.1) holds for the readings
whatever friction does. Constants in other units break one or both; those whose powers of 1000 mend both are named.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.declared.rig import Rig
from stickslip.errors import InputError
from stickslip.fitted.data import Data
from stickslip.measured.case import Case
from stickslip.measured.constants import swing_rate
from stickslip.measured.prefixes import STEP, power, put_right, times

Holds = Callable[[Rig, float], bool]
# numbers that are given in one unit, and powers of 1000 that the true ones may be over the declared
MASS, FORCE, LENGTH = "mass", "force", "length"
CAUSES = {("m",): MASS, ("J",): MASS, ("k1", "k2", "k3"): FORCE, ("c1", "c2"): FORCE, ("r",): LENGTH}
GROUPS: Mapping[tuple[str, ...], tuple[int, ...]] = {
    ("m",): (-1, 1),
    ("J",): (-1, -2, -3),
    ("k1", "k2", "k3"): (1,),
    ("c1", "c2"): (1,),
    ("r",): (-1,),
}


@dataclass(frozen=True)
class Other:
    """The rig with some constants taken in other units: `powers` by the names given alike."""

    rig: Rig
    powers: Mapping[tuple[str, ...], int]

    @property
    def causes(self) -> int:
        """How many units were mistaken: m in g and J in g m^2 are one, as are N/mm and N s/mm."""
        return len({(CAUSES[names], n) for names, n in self.powers.items()})

    def beyond(self, other: Other) -> bool:
        """Does it change all that another does, and more?"""
        return other.powers.items() < self.powers.items()


def rig_constants(case: Case, data: Sequence[Data], holds: Holds) -> None:
    """Refuse a rig of (2.1) in SI with constants in other units than they are taken in.

    Parameters
    ----------
    case
        Whose rig it is.
    data
        Its runs in the model's numbers.
    holds
        Whether the angle body's line holds for the runs with a rig, their times multiplied by a factor.

    Raises
    ------
    InputError
        Which numbers, by what power of 1000 they are off, and what would be right.
    """
    rig = case.rig
    assert isinstance(rig, Rig)
    rates = [rate for run in data if (rate := swing_rate(run.t, run.readings[:, 0])) is not None]
    if rig.scales is None or not rates:
        return
    shown = float(np.median(rates)) ** 2  # over omega^2, which is 1 in the model
    off = power(shown, 2 * case.uncertainty.relative("omega"))
    if not off and (holds(rig, 1.0) or not _near(shown)):
        return
    best: list[Other] = []
    for other in _others(rig):
        if best and other.causes > best[0].causes:
            break
        assert other.rig.scales is not None
        faster = other.rig.scales.omega / rig.scales.omega
        more = any(other.beyond(one) for one in best)
        if not more and _near(shown / faster**2) and holds(other.rig, faster):
            best.append(other)
    if best:
        raise InputError(_words(case, best, shown if off else None))


def _near(ratio: float) -> bool:
    """Is it 1, as near as a frequency is seen?"""
    return power(ratio * STEP) == 1


def _others(rig: Rig) -> list[Other]:
    """Rigs with constants in other units, those of the fewest causes first."""
    si, every = rig.to_si(), []
    for given in itertools.product(*((0, *powers) for powers in GROUPS.values())):
        powers = {names: n for names, n in zip(GROUPS, given, strict=True) if n}
        moved = {name: si[name] * STEP**n for names, n in powers.items() for name in names}
        if powers:
            every.append(Other(Rig.from_si(**{**si, **moved}, coupling=rig.coupling), powers))
    return sorted(every, key=lambda one: (one.causes, len(one.powers), sum(map(abs, one.powers.values()))))


def _words(case: Case, best: Sequence[Other], shown: float | None) -> str:
    head = (
        "x1 and y1 do not meet the angle body's equation in (2.1)"
        if shown is None
        else f"the slips swing with {times(shown)} the (k1 + k2)/m that [rig] declares"
    )
    values = case.uncertainty.values
    told = [
        " and ".join(
            put_right({name: values[name] for name in names}, Rig.dimensions[names[0]].unit, n)
            for names, n in other.powers.items()
        )
        for other in best
    ]
    return f"{head}: {'; or '.join(told)}"
