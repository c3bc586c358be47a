"""A branch of limit cycles: what `continuation` returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from stickslip.cycles import LimitCycle
from stickslip.flow import Floats
from stickslip.sliding import Complexes

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.branch_problem import Point

Kind = Literal["fold", "flip", "neimark_sacker", "hopf", "loss_of_stick", "crossing", "grazing"]


@dataclass(frozen=True)
class SpecialPoint:
    """A bifurcation on a branch.

    Attributes
    ----------
    kind
        "fold" (the branch turns round), "flip" (a multiplier -1), "neimark_sacker" (a pair of modulus 1),
        "hopf" (the cycle shrinks to steady sliding and the branch ends); "loss_of_stick" (the only stick phase
        shrinks to nothing), "crossing" (v_w = 0 begins to be crossed, in place of or besides a stick),
        "grazing" (a further stick phase begins or ends).
    value
        Of the parameter.
    cycle
        The cycle there, on the side it was reached from; at a hopf point the last one traced.
    index
        Of the branch's point that follows.
    turns_round
        Does the branch turn round in a corner here (a fold that is not smooth)?
    ends
        Does the branch end here, the cycle jumping or vanishing?
    """

    kind: Kind
    value: float
    cycle: LimitCycle
    index: int
    turns_round: bool = False
    ends: bool = False


@dataclass(frozen=True)
class Branch:
    """Limit cycles along a branch, in the order in which it was traced from its lower start to its end.

    Attributes
    ----------
    parameter
        Its name.
    values : (n,)
        The parameter.
    period : (n,)
    state : (n, d)
        On the section.
    states
        Names of the states.
    multipliers : (n, m) complex
    stable : (n,) bool
    stick_time : (n,)
        Time stuck in one period, all stick phases together.
    special
        Bifurcations, in the same order.
    """

    parameter: str
    values: Floats
    period: Floats
    state: Floats
    states: tuple[str, ...]
    multipliers: Complexes
    stable: NDArray[np.bool_]
    stick_time: Floats
    special: tuple[SpecialPoint, ...]

    def __len__(self) -> int:
        return len(self.values)

    def to_xarray(self) -> xr.Dataset:
        """Return the branch as a dataset over `point`; special points in the attributes."""
        import xarray as xr

        columns = {
            self.parameter: ("point", self.values),
            "period": ("point", self.period),
            "stick_time": ("point", self.stick_time),
            "stable": ("point", self.stable),
            "state": (("point", "state_name"), self.state),
            "multiplier_abs": (("point", "multiplier"), np.abs(self.multipliers)),
            "multiplier_arg": (("point", "multiplier"), np.angle(self.multipliers)),
        }
        special = [f"{one.kind} at {one.value!r}" for one in self.special]
        return xr.Dataset(columns, coords={"state_name": list(self.states)}, attrs={"special": special})


def stick_time(cycle: LimitCycle) -> float:
    """Time stuck in one period."""
    tr = cycle.transitions
    if len(tr) == 0:
        return cycle.period if cycle.contact == "stick" else 0.0
    lasting = np.diff(np.append(tr.t, tr.t[0] + cycle.period))
    return float(lasting[tr.after == 0].sum())


def branch_of(
    parameter: str,
    cycle: Callable[[Point], LimitCycle],
    back: tuple[list[Point], list[SpecialPoint]],
    ahead: tuple[list[Point], list[SpecialPoint]],
) -> Branch:
    """Join what was traced both ways from the start."""
    shift = len(back[0]) - 1
    cycles = [cycle(point) for point in (*back[0][:0:-1], *ahead[0])]
    values = [point.value for point in (*back[0][:0:-1], *ahead[0])]
    special = [
        *(replace(one, index=shift - one.index + 1) for one in back[1][::-1]),
        *(replace(one, index=one.index + shift) for one in ahead[1]),
    ]
    return Branch(
        parameter=parameter,
        values=np.array(values),
        period=np.array([one.period for one in cycles]),
        state=np.array([one.state for one in cycles]),
        states=cycles[0].states,
        multipliers=np.array([one.multipliers for one in cycles]),
        stable=np.array([one.stable for one in cycles]),
        stick_time=np.array([stick_time(one) for one in cycles]),
        special=tuple(special),
    )


def kind_of(before: tuple[tuple[int, int], ...], after: tuple[tuple[int, int], ...]) -> Kind:
    """Name the sliding bifurcation between two sequences of contact modes."""
    sticks = [sum(into == 0 for _, into in s) for s in (before, after)]
    crossings = [sum(0 not in change for change in s) for s in (before, after)]
    if (sticks[0] == 0) != (sticks[1] == 0):
        return "loss_of_stick"
    if crossings[0] != crossings[1]:
        return "crossing"
    return "grazing"


def flip_test(cycle: LimitCycle) -> float:
    """Zero where a multiplier is -1."""
    return float(np.prod(1 + cycle.multipliers).real)


def neimark_sacker_test(cycle: LimitCycle) -> float:
    """Zero where a complex pair has modulus 1; nan where there is none."""
    upper = cycle.multipliers[cycle.multipliers.imag > 1e-9]
    return float(np.prod(np.abs(upper) - 1)) if len(upper) else np.nan
