"""A branch of limit cycles: what `continuation` returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from stickslip.objects import Displayed, Sampled, one_line
from stickslip.simulated.orbits.cycle import LimitCycle
from stickslip.simulated.orbits.flow import Complexes, Floats, Signature
from stickslip.simulated.orbits.steady_sliding import SteadySliding

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.simulated.orbits.branch_equations import CyclePoint

End = Literal["span", "closed", "hopf", "special", "no_convergence", "retraced", "max_points"]
ENDS: Mapping[End, str] = {  # as a person reads them
    "span": "span",
    "closed": "closed",
    "hopf": "Hopf bifurcation",
    "special": "special point",
    "no_convergence": "no convergence",
    "retraced": "retraced",
    "max_points": "most points",
}
Kind = Literal["fold", "flip", "neimark_sacker", "hopf", "loss_of_stick", "crossing", "grazing"]
BESIDE = 0.1  # of a step: a start that lies nearer to it has been passed
SAME_WAY = 0.9  # cosine of the angle to where it left
FEWEST = 4  # points of a loop


@dataclass(frozen=True, eq=False, repr=False)
class SpecialPoint(Displayed):
    """A bifurcation on a branch; printed, one line.

    Attributes
    ----------
    kind
        "fold" (the branch turns round), "flip" (a multiplier -1), "neimark_sacker" (a pair of modulus 1),
        "hopf" (the cycle shrinks to steady sliding and the branch ends short of it); "loss_of_stick" (the only stick
        phase shrinks to nothing), "crossing" (v_w = 0 begins to be crossed, in place of or besides a stick),
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
    sliding
        At a hopf point, the steady sliding that the cycle shrinks to.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
    >>> branch = ss.continuation(model, 2.0, span=(1.9, 3.2), guess=(3.0, 0.0))
    >>> [f"{point.kind} at {point.value:.4f}" for point in branch.special]
    ['loss_of_stick at 2.8923']
    """

    kind: Kind
    value: float
    cycle: LimitCycle
    index: int
    turns_round: bool = False
    ends: bool = False
    sliding: SteadySliding | None = None

    @property
    def period(self) -> float:
        """Of the cycle; at a hopf point that of the smallest cycles, which the eigenvalues of sliding give."""
        return self.cycle.period if self.sliding is None else self.sliding.turning_time

    def __repr__(self) -> str:
        more = (", turns round" if self.turns_round else "") + (", ends" if self.ends else "")
        return one_line(f"<{self.kind} at {self.value:.9g}: period {self.period:.6g}{more}>")


@dataclass(frozen=True, eq=False, repr=False)
class Branch(Sampled):
    """Limit cycles along a branch, in the order in which it was traced from its lower start to its end; printed, its
    span and a line for each bifurcation.

    Attributes
    ----------
    parameter
        Its name.
    values : (n,)
        The parameter.
    period : (n,)
        Of the cycles, in the rig's unit of time.
    state : (n, d)
        On the section.
    states
        Names of the states.
    multipliers : (n, m) complex
        Greatest first; nan at the end of a row where a state that has influence elsewhere has none.
    stable : (n,) bool
        Does a small disturbance die out?
    stick_time : (n,)
        Time stuck in one period, all stick phases of all contacts together.
    special
        Bifurcations, in the same order.
    ends
        How it ends, first and last: at the "span", at a "hopf" or another "special" point, where the correction does
        not converge ("no_convergence"), where it came back to a part of itself ("retraced") or at
        "max_points"; "closed" twice where it has come round to a part of itself, a loop.
    forced
        Is the rig moved from outside? States are then those once a period of that, not those of greatest x1.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> branch = ss.continuation(model, 0.1, span=(0.09, 0.11), step=0.5)
    >>> print(f"the period goes from {branch.period[0]:.3f} to {branch.period[-1]:.3f}")
    the period goes from 10.873 to 10.151
    >>> branch.special
    ()
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
    ends: tuple[End, End]
    forced: bool = False

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        span = (
            f"{self.parameter} {self.values.min():.6g} to {self.values.max():.6g}" if len(self) else "empty"
        )
        kept = f"{np.count_nonzero(self.stable)} of {len(self)} points stable"
        special = f"; {len(self.special)} bifurcations" if self.special else ""
        return one_line(f"<Branch: {span}; {kept}{special}; {self.ends_told()}>")

    def ends_told(self) -> str:
        """Say in words where it ends."""
        return "ends: " + ", ".join(ENDS[one] for one in self.ends)

    def __str__(self) -> str:
        return "\n  ".join([repr(self), *map(repr, self.special)])

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
        attrs = {"special": special, "ends": list(self.ends)}
        return xr.Dataset(columns, coords={"state_name": list(self.states)}, attrs=attrs)


def _table(rows: list[Complexes]) -> Complexes:
    """Rows of several lengths as one array, filled up with nan."""
    table = np.full((len(rows), max(map(len, rows))), np.nan, dtype=np.complex128)
    for line, row in zip(table, rows, strict=True):
        line[: len(row)] = row
    return table


def stick_time(cycle: LimitCycle) -> float:
    """Time stuck in one period, of all contacts together."""
    tr = cycle.transitions
    if len(tr) == 0:
        each = (cycle.contact,) if isinstance(cycle.contact, str) else cycle.contact
        return cycle.period * each.count("stick")
    lasting = np.diff(np.append(tr.t, tr.t[0] + cycle.period))
    return float(lasting @ (tr.after == 0).reshape(len(tr), -1).sum(axis=1))


@dataclass
class Trace:
    """What was traced from a start one way: points, the start first; special points; how it ended."""

    points: list[CyclePoint]
    special: list[SpecialPoint]
    end: End = "max_points"


def comes_round(
    points: Sequence[CyclePoint], along: Floats, point: CyclePoint
) -> tuple[End, CyclePoint] | None:
    """Does the branch pass, on its way from the last of these points, one of them? As it left it, or back on itself."""
    last = points[-1]
    chord = point.x - last.x
    size = float(np.linalg.norm(chord))
    if size == 0 or len(points) < FEWEST:
        return None
    x = np.array([one.x for one in points])
    share = (x[:-2] - last.x) @ chord / size**2
    beside = np.linalg.norm(x[:-2] - last.x - share[:, None] * chord, axis=1)
    for i in np.flatnonzero((share > 0) & (share <= 1) & (beside < BESIDE * size)).tolist():
        way = along if i == 0 else x[i + 1] - x[i]
        cosine = float(way @ chord) / size / max(float(np.linalg.norm(way)), 1e-300)
        if points[i].signature == point.signature and cosine > SAME_WAY:
            return "closed", points[i]
        if i == 0 and points[i].signature == point.signature and cosine < -SAME_WAY:
            return "retraced", points[i]  # elsewhere it may be the other side of a sharp corner
    return None


def branch_of(
    parameter: str,
    cycle: Callable[[CyclePoint], LimitCycle],
    back: Trace,
    ahead: Trace,
) -> Branch:
    """Join what was traced both ways from the start."""
    shift = len(back.points) - 1
    points = (*back.points[:0:-1], *ahead.points)
    cycles = [cycle(point) for point in points]
    special = [
        *(replace(one, index=shift - one.index + 1) for one in back.special[::-1]),
        *(replace(one, index=one.index + shift) for one in ahead.special),
    ]
    return Branch(
        parameter=parameter,
        values=np.array([point.value for point in points]),
        period=np.array([one.period for one in cycles]),
        state=np.array([one.state for one in cycles]),
        states=cycles[0].states,
        multipliers=_table([one.multipliers for one in cycles]),
        stable=np.array([one.stable for one in cycles]),
        stick_time=np.array([stick_time(one) for one in cycles]),
        special=tuple(special),
        ends=(back.end, ahead.end),
        forced=points[0].flow.forcing_period is not None,
    )


def kind_of(before: Signature, after: Signature) -> Kind:
    """Name the sliding bifurcation between two sequences of contact modes."""
    each = [_changes(before), _changes(after)]
    sticks = [sum(into == 0 for _, into in s) for s in each]
    crossings = [sum(0 not in change for change in s) for s in each]
    if (sticks[0] == 0) != (sticks[1] == 0):
        return "loss_of_stick"
    if crossings[0] != crossings[1]:
        return "crossing"
    return "grazing"


def _changes(sequence: Signature) -> list[tuple[int, int]]:
    """Modes (before, after) of every contact that changes its own, in order."""
    pairs = [(np.atleast_1d(a), np.atleast_1d(b)) for a, b in sequence]
    return [(int(a), int(b)) for one, other in pairs for a, b in zip(one, other, strict=True) if a != b]


def flip_test(cycle: LimitCycle) -> float:
    """Zero where a multiplier is -1."""
    return float(np.prod(1 + cycle.multipliers).real)


def neimark_sacker_test(cycle: LimitCycle) -> float:
    """Zero where a complex pair has modulus 1; nan where there is none."""
    upper = cycle.multipliers[cycle.multipliers.imag > 1e-9]
    return float(np.prod(np.abs(upper) - 1)) if len(upper) else np.nan
