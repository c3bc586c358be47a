"""Are the channels what the case says they are? Two tests that need no fit and no friction law.

The angle body's line of (2.1) has no friction in it: what x1 does to y1 is known, so that its weak form, with smooth
bumps as test functions, gives the ratio of the two channels. And a block that sticks rides the belt: the commonest rate
of x1 is the belt's speed. An effect moves these numbers by a tenth or two; a wrong unit, sign or column by far more.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.rig import Rig
from stickslip.declared.units import default_speed_unit, factor
from stickslip.errors import InputError
from stickslip.fitted.data import Data
from stickslip.fitted.rig_constants import rig_constants
from stickslip.measured.case import Case
from stickslip.measured.findings import FindingKind
from stickslip.measured.prefixes import RATIO
from stickslip.measured.stick_speed import commonest_rate

Floats = NDArray[np.float64]
BUMP = 0.6  # length of a test function, in cycles
SURE = 0.97  # correlation of the two sides of the angle body's equation above which their ratio is believed
CLOSE = 0.995  # the same where the equation holds but for noise
SPEED = 2.5  # the same for the speed of the sticking block over the belt's
ODD, ALIKE = 0.33, 0.03  # in the logarithm: a run's speed that is off, where the others' are right
GAIN = 1.15  # a belt channel off by more, where block and set-point agree, is not believed
SHIFTED = 0.1  # share of the equation left over below which a shifted zero explains what is wrong
INERTIA = 8.0  # the angle body's inertia over the declared one that no effect of the list has
FITS = 0.15  # how near a unit must bring a ratio to 1, in the logarithm, to be suggested
TIMES = ("s", "ms", "us", "min", "hour")
LENGTHS = ("m", "cm", "mm", "um", "inch")
ANGLES = ("rad", "deg", "mrad")
SPEEDS = ("m/s", "cm/s", "mm/s", "um/s")


@dataclass(frozen=True)
class Ratio:
    """y1 over what x1 asks for by the angle body's equation, and the correlation of the equation's two sides."""

    gain: float
    correlation: float

    @property
    def sure(self) -> bool:
        """Do the two sides go together, whatever their ratio?"""
        return abs(self.correlation) > SURE

    @property
    def right(self) -> bool:
        """Is the ratio 1 within what a sensor may be off?"""
        return self.sure and 1 / RATIO < self.gain < RATIO


def body_ratio(data: Sequence[Data], rig: Rig, *, time: float = 1.0, swapped: bool = False) -> Ratio:
    """Ratio of y1 to x1 by the angle body's equation, over all runs.

    Parameters
    ----------
    data : the runs, in model units.
    rig : numbers of (2.1).
    time : what the times are multiplied by first.
    swapped : take the columns x1 and y1 for each other.
    """
    left, right = [], []
    for run in data:
        x, y = run.readings[:, 1 if swapped else 0], run.readings[:, 0 if swapped else 1]
        for a, b, _ in _sides(run.t * time, x, y, rig):
            left.append(a)
            right.append(b)
    A, B = np.array(left), np.array(right)
    sizes = float(A @ A), float(B @ B)
    if len(A) < 3 or min(sizes) <= 0:
        return Ratio(1.0, 0.0)
    both = float(A @ B)
    return Ratio(both / sizes[1], both / np.sqrt(sizes[0] * sizes[1]))


def _sides(t: Floats, x: Floats, y: Floats, rig: Rig) -> Iterator[tuple[float, float, float]]:
    """Integrals of (beta3 y1 + eta12 y1' + alpha2 y1'') f, of -(x1 + eta1 x1') f, by parts, and of f, over bumps f."""
    length = BUMP * period_of(t, x)
    weight = np.gradient(t)
    for start in np.arange(t[0], t[-1] - length, length / 4):
        part = slice(*np.searchsorted(t, [start, start + length]))
        s, k = 2 * (t[part] - start) / length - 1, 2 / length
        if len(s) < 8:
            continue
        c = 1 - s**2
        f, f1 = c**4, -8 * s * c**3 * k
        f2 = (-8 * c**3 + 48 * s**2 * c**2) * k**2
        w = weight[part]
        yield (
            float(np.sum(w * y[part] * (rig.beta3 * f - rig.eta12 * f1 + rig.alpha2 * f2))),
            -float(np.sum(w * x[part] * (f - rig.eta1 * f1))),
            float(np.sum(w * f)),
        )


def zeros(data: Sequence[Data], rig: Rig) -> tuple[Floats, float]:
    """Zero of x1 by run that the angle body's equation asks for (or of y1, times beta3), and how well that meets it.

    The second is the share of the equation's left-hand side that is left over, root mean square.
    """
    shifts, off, whole = [], 0.0, 0.0
    for run in data:
        sides = np.array(list(_sides(run.t, run.readings[:, 0], run.readings[:, 1], rig)))
        if len(sides) < 3:
            return np.zeros(len(data)), 1.0
        A, B, f = sides.T
        shift = float((A - B) @ f / (f @ f))
        shifts.append(shift)
        off += float(np.sum((A - B - shift * f) ** 2))
        whole += float(np.sum((A - A.mean()) ** 2))
    return np.array(shifts), float(np.sqrt(off / max(whole, 1e-300)))


def period_of(t: Floats, x: Floats) -> float:
    """Period of the strongest line of x."""
    dt = float(np.median(np.diff(t)))
    even = np.interp(np.arange(t[0], t[-1], dt), t, x)
    power = np.abs(np.fft.rfft((even - even.mean()) * np.hanning(len(even)))) ** 2
    return len(even) * dt / (2 + int(np.argmax(power[2:])))


def stick_speed(run: Data) -> float | None:
    """The rate of x1 at which the block rides the belt; None if none stands out, or the run is too short to tell."""
    dt, period = float(np.median(np.diff(run.t))), period_of(run.t, run.readings[:, 0])
    if period < 25 * dt or run.t[-1] - run.t[0] < 2.5 * period:
        return None
    return commonest_rate(run.t, run.readings[:, 0], int(period / 25 / dt))


def plausible(case: Case, data: Sequence[Data]) -> tuple[list[Data], tuple[str, ...]]:
    """Refuse a case whose channels cannot be what it says: a wrong unit, sign or column.

    Returns
    -------
    The runs, without the readings of a belt channel that the block contradicts, and what is to be said of that.

    Raises
    ------
    InputError
        With the channel, by how much it is off, and the unit that would be right, if one is.
    """
    rig = case.rig
    assert isinstance(rig, Rig)
    for run in data:
        for c, name in enumerate(run.channels[:2]):
            if np.ptp(run.readings[:, c]) == 0:
                raise InputError(
                    f"{run.name}: channel {name} never changes: is the sensor alive? leave the run out"
                )
    ratio, speed = body_ratio(data, rig), _speed(data)
    if ratio.sure and not ratio.right:
        raise InputError(_displacement(case, ratio.gain, speed))
    if not ratio.sure:
        _odd_run(data, rig)
        _columns(case, data)
    rig_constants(case, data, lambda other, faster: body_ratio(data, other, time=faster).right)
    if not ratio.sure:
        _inertia(data, rig)
    if speed is not None and not 1 / SPEED < speed < SPEED:
        raise InputError(_belt(case, data, speed, ratio))
    if speed is not None:
        _each_run(case, data)
    for one in (finding for run in case.runs for finding in run.findings if finding.kind is FindingKind.SIZE):
        agree = (
            "x1, y1, t and belt_speed agree with each other, but "
            if ratio.right and speed is not None
            else ""
        )
        size = str(one).replace(":", "", 1).removesuffix("; is the unit right?")
        raise InputError(f"{agree}{size}: check the rig's numbers (length, k1, k2), [friction] and the units")
    return _without_belt(data)


def _without_belt(data: Sequence[Data]) -> tuple[list[Data], tuple[str, ...]]:
    """Leave out a belt channel that reads otherwise than the block rides, where that agrees with the set-points."""
    ridden = [(run, stick_speed(run)) for run in data if run.readings.shape[1] == 3 and run.belt_speed]
    known = [(run, v) for run, v in ridden if v is not None]
    by_block = [abs(float(np.log(abs(v / run.belt_speed)))) for run, v in known]
    by_belt = [float(np.median(run.readings[:, 2])) / v for run, v in known]
    if len(known) < 3 or max(by_block) > 0.1 or not (min(by_belt) > GAIN or max(by_belt) < 1 / GAIN):
        return list(data), ()
    left = []
    for run in data:
        weight = run.weight.copy()
        weight[:, 2] = 0.0
        left.append(replace(run, weight=weight))
    return left, (
        f"channel belt reads {_times(float(np.median(by_belt)))} the speed at which the block rides, which is the "
        "set-point by x1: its readings are left out; check its unit and calibration",
    )


def _speed(data: Sequence[Data]) -> float | None:
    """Median over the runs of the sticking block's speed over the set-point; None where too few runs tell."""
    found = [(stick_speed(run), run.belt_speed) for run in data if run.belt_speed]
    ratios = [v / v_b for v, v_b in found if v is not None]
    return float(np.median(ratios)) if 2 * len(ratios) > len(data) else None


def _displacement(case: Case, gain: float, speed: float | None) -> str:
    """What to say where y1 is `gain` times what x1 asks for, and the block sticks at `speed` times the set-point."""
    # x1 is the wrong one if undoing its error puts the block's speed right too
    by_x1 = (
        speed is not None
        and speed * gain > 0
        and (speed < 0 or abs(np.log(speed * gain)) < abs(np.log(speed)))
    )
    name, other, size = ("x1", "y1", 1 / gain) if by_x1 else ("y1", "x1", gain)
    law = "by the angle body's equation in (2.1), which friction does not enter"
    if speed is None:
        return f"channel {name} {_reads(size)} what {other} asks for {law}: {_advice(case, name, size)}, or {other}'s"
    also = (
        f", and {_times(speed)} what belt_speed asks for"
        if by_x1
        else f", while {other} agrees with belt_speed"
    )
    return f"channel {name} {_reads(size)} what {other} asks for {law}{also}: {_advice(case, name, size)}"


def _odd_run(data: Sequence[Data], rig: Rig) -> None:
    """One run that does not meet the angle body's equation at all, where all others do closely."""
    each = [body_ratio([run], rig).correlation for run in data]
    for i, run in enumerate(data):
        if len(data) > 2 and each[i] < 0.3 and min(each[:i] + each[i + 1 :]) > CLOSE:
            raise InputError(
                f"{run.name}: x1 and y1 do not meet the angle body's equation in (2.1), unlike in the other runs: "
                "are they columns of one run?"
            )


def _columns(case: Case, data: Sequence[Data]) -> None:
    """Where the angle body's equation fails as it stands: with x1 and y1 swapped, or with other times?"""
    rig = case.rig
    assert isinstance(rig, Rig)
    if body_ratio(data, rig, swapped=True).right:
        raise InputError(
            "x1 and y1 meet the angle body's equation in (2.1) only with one taken for the other: "
            "are their columns swapped in [channels]?"
        )
    shift, left = zeros(data, rig)
    if left < SHIFTED:
        run = int(np.argmax(np.abs(shift)))
        name = (*case.train, *case.validate)[run].name
        x, y = (
            f"{size / factor(c, case.channels[c].unit, rig):.3g} {_word(case.channels[c].unit)}".rstrip()
            for c, size in (("x1", shift[run]), ("y1", shift[run] / rig.beta3))
        )
        raise InputError(
            f"{name}: x1 and y1 meet the angle body's equation in (2.1) only with another zero: x1 reads {x} too much, "
            f"or y1 {y}; subtract what the sensor reads with its spring at rest"
        )
    declared = case.channels["t"].unit
    if declared == "1":
        return
    for unit in TIMES:
        times = factor("t", unit, rig) / factor("t", declared, rig)
        if unit != declared and body_ratio(data, rig, time=times).right:
            raise InputError(
                f"channel t is in '{declared}' by [channels], but x1 and y1 meet the angle body's equation in (2.1) "
                f"only with times in '{unit}': check its unit"
            )


def _inertia(data: Sequence[Data], rig: Rig) -> None:
    """The angle body's equation fails as it stands, and holds with quite another inertia."""

    def sides(other: Rig) -> Floats:
        channels = [(run.t, run.readings[:, 0], run.readings[:, 1]) for run in data]
        return np.array([one for t, x, y in channels for one in _sides(t, x, y, other)])

    one, two = (sides(replace(rig, alpha2=alpha2)) for alpha2 in (1.0, 2.0))
    if len(one) < 3:
        return
    c, right = two[:, 0] - one[:, 0], one[:, 1]  # the left-hand side is linear in alpha2
    rest = one[:, 0] - c
    left = right - rest
    asked = float(c @ left / (c @ c))
    met = np.corrcoef(rest + asked * c, right)[0, 1]
    if asked <= 0 or met < CLOSE or 1 / INERTIA < asked / rig.alpha2 < INERTIA:
        return
    told, times = "check alpha2", _times(asked / rig.alpha2)
    if rig.scales is not None:
        r = rig.scales.r / np.sqrt(asked / rig.alpha2)
        told = f"check J (kg m^2) and r (m): J must be {times} as much, or r {r:.3g} m"
    raise InputError(
        f"x1 and y1 meet the angle body's equation in (2.1) only with alpha2 = {asked:.3g}, {times} the declared "
        f"{rig.alpha2:.3g}: {told}"
    )


def _belt(case: Case, data: Sequence[Data], speed: float, ratio: Ratio) -> str:
    """What to say where the sticking block moves at `speed` times the set-point."""
    head = f"the block sticks at a rate of x1 that is {_times(speed)} belt_speed"
    if speed < 0:
        what = "the sign" if 0.5 < -speed < 2 else "sign and unit"
        return f"{head}: check {what} of belt_speed, and of x1 and y1"
    if ratio.right and _oversized(case, data, speed):
        declared = case.channels["x1"].unit
        meant = _unit(case, "x1", declared, 1 / speed)
        hint = f" (with '{meant}' both would be right)" if meant else ""
        return f"{head}, and {_times(speed)} what friction allows: check the units of x1 and y1, '{declared}'{hint}"
    unit = case.channels["belt"].unit if "belt" in case.channels else default_speed_unit(case.rig)
    meant = _unit(case, "belt", unit, speed)
    hint = f"; in '{meant}' it would be right" if meant else ""
    where = "by [channels]" if "belt" in case.channels else "as no belt channel gives another"
    also = ", while x1 and y1 agree with each other" if ratio.right else ", or the units of x1 and t"
    return f"{head}{also}: check belt_speed, which is in '{unit}' {where}{hint}"


def _oversized(case: Case, data: Sequence[Data], speed: float) -> bool:
    """Is the size of x1 nearer to what static friction can hold if x1 is divided by `speed`?"""
    assert isinstance(case.rig, Rig)
    reach = max(case.friction.static_limits) / case.rig.alpha1
    size = np.log(float(np.std(np.concatenate([run.readings[:, 0] for run in data]))) / (0.5 * reach))
    return bool(abs(size - np.log(speed)) < abs(size))


def _each_run(case: Case, data: Sequence[Data]) -> None:
    """One run whose belt speed is off, where the others' are right; and a belt channel that says otherwise."""
    unit = case.channels["belt"].unit if "belt" in case.channels else default_speed_unit(case.rig)
    one = factor("belt", unit, case.rig)
    ridden = [stick_speed(run) for run in data]
    off = [
        0.0 if v is None or v * run.belt_speed <= 0 else abs(float(np.log(v / run.belt_speed)))
        for v, run in zip(ridden, data, strict=True)
    ]
    usual = float(np.median([abs(run.belt_speed) for run in data]))
    for i, (run, v) in enumerate(zip(data, ridden, strict=True)):
        if v is None:
            continue
        others = max((size for j, size in enumerate(off) if j != i), default=np.inf)
        if (v * run.belt_speed < 0 or run.belt_speed == 0) and abs(v) > 0.2 * usual:
            wrong = True
        else:
            wrong = off[i] > np.log(SPEED) or (off[i] > ODD and others < ALIKE and len(data) > 3)
        if wrong:
            raise InputError(
                f"{run.name}: belt_speed is {_in(unit, run.belt_speed / one)}, but the block sticks at a rate of x1 of "
                f"{_in(unit, v / one)}, unlike in the other runs: check its belt_speed (number and sign) and its file"
            )
        if run.readings.shape[1] == 3 and run.belt_speed:
            share = float(np.median(run.readings[:, 2])) / run.belt_speed
            if not 1 / SPEED < share < SPEED:
                raise InputError(
                    f"{run.name}: channel belt reads {_times(share)} belt_speed, at which the block does ride by x1: "
                    f"check the belt's column, sign and unit '{unit}'"
                )


def _in(unit: str, value: float) -> str:
    return f"{value:.3g} {_word(unit)}".rstrip()


def _advice(case: Case, name: str, size: float) -> str:
    if size < 0:
        return f"check the sign of {name}"
    declared = case.channels[name].unit
    meant = _unit(case, name, declared, 1 / size)
    if meant:
        return f"its unit is '{declared}' by [channels]; with '{meant}' it would be right"
    return f"check its unit ('{declared}'), its scale and its column"


def _unit(case: Case, name: str, declared: str, wanted: float) -> str | None:
    """A unit whose size over the declared one's is `wanted`; None if no usual one is."""
    if declared == "1" or wanted <= 0:
        return None
    known = {"y1": LENGTHS + ANGLES, "x1": LENGTHS, "belt": SPEEDS}[name]
    own = factor(name, declared, case.rig)
    off = {unit: abs(np.log(factor(name, unit, case.rig) / own / wanted)) for unit in known}
    best = min(off, key=lambda unit: off[unit])
    return best if off[best] < FITS and best != declared else None


def _word(unit: str) -> str:
    return "" if unit == "1" else unit


def _reads(ratio: float) -> str:
    return "reads the negative of" if 0.5 < -ratio < 2 else f"reads {_times(ratio)}"


def _times(ratio: float) -> str:
    """A ratio in words."""
    if 0.5 < -ratio < 2:
        return "minus"
    return f"{float(f'{ratio:.3g}'):.10g} times"
