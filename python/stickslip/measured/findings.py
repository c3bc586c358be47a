"""What is odd about a recording yet leaves it usable: said, never silently used."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stickslip.measured.prefixes import power, put_right
from stickslip.measured.signals import check_time_base, find_clipping, find_glitches, quantisation

Floats = NDArray[np.float64]

FINE = 0.5  # a quantisation step below this part of the noise is dithered away
ENOUGH = 12  # samples from which noise and glitches can be told
BESIDE = 3  # samples on either side that a glitch is judged by
LOOKED_AT = 1 << 19  # samples of a channel that are looked at, a second's work; of a longer one, stretches
STRETCHES = 16


class FindingKind(Enum):
    """Kinds of findings; the value is the sentence that a report puts above them."""

    GUESSED = "something of a file had to be guessed"
    GAP = "samples are missing"
    IRREGULAR = "the time base is irregular"
    CLIPPED = "a channel is clipped"
    QUANTISED = "a channel is coarsely quantised"
    GLITCHES = "a channel has glitches of one sample or two"
    CONSTANT = "a channel never changes"
    BELT = "the belt is far from its set-point"
    SIZE = "readings are of a size the rig can hardly reach"


@dataclass(frozen=True)
class Finding:
    """One finding.

    Parameters
    ----------
    kind
        What kind of thing it is.
    channel
        "t", "x1", "y1", "belt", "spring_force" or "drive".
    message
        One line, in the unit of the channel's column.
    samples
        Indices it concerns; empty where it is the whole channel.
    """

    kind: FindingKind
    channel: str
    message: str
    samples: tuple[int, ...] = ()

    def __str__(self) -> str:
        return self.message


def time_findings(t: Floats, unit: str) -> list[Finding]:
    """Look for gaps and irregular steps in increasing times (n,)."""
    base = check_time_base(t)
    found = []
    if base.gaps.size:
        first, last = base.gaps[0]
        words = f"t: {len(base.gaps)} gap(s), {base.missing} sample(s) missing"
        words += f", the first from {first:g} to {last:g}"
        at = np.searchsorted(t, base.gaps[:, 0])
        found.append(Finding(FindingKind.GAP, "t", f"{words} {unit}", tuple(int(i) for i in at)))
    if base.irregular.size:
        words = f"t: {base.irregular.size} step(s) off the usual {base.dt:g} {unit} by more than 1 %"
        found.append(Finding(FindingKind.IRREGULAR, "t", words, tuple(int(i) for i in base.irregular)))
    return found


def channel_findings(
    name: str, x: Floats, unit: str, noise: float | None, jumps: NDArray[np.intp]
) -> list[Finding]:
    """Look at one channel.

    Parameters
    ----------
    name, x, unit
        Channel and its values (n,) in the unit of its column.
    noise
        Its declared standard deviation; None: unknown.
    jumps
        Samples beside a gap or an off step, whose neighbours say nothing of them.
    """
    lowest, highest = float(np.min(x)), float(np.max(x))
    if lowest == highest:
        words = f"{name}: {x[0]:g} {unit} throughout; is the sensor alive?"
        return [Finding(FindingKind.CONSTANT, name, words)]
    if x.size > LOOKED_AT:
        return _in_stretches(name, x, unit, noise, jumps, (lowest, highest))
    found = []
    clipping = find_clipping(x)
    at = np.flatnonzero(clipping.mask)
    for limit, side in ((clipping.low, "lowest"), (clipping.high, "highest")):
        if limit is not None:
            count = int(np.sum(x == limit))
            words = (
                f"{name}: {count} samples sit at the {side} value {limit:g} {unit}; the range is too small"
            )
            found.append(Finding(FindingKind.CLIPPED, name, words, tuple(int(i) for i in at)))
    grid = quantisation(x)
    # the digits a file is printed with are a grid too: it matters where it is as coarse as the noise
    coarse = grid.step > FINE * noise if noise is not None else 2 * grid.levels < x.size
    if grid.step > 0 and coarse:
        words = f"{name}: quantised in steps of {grid.step:.3g} {unit} ({grid.levels} levels)"
        found.append(Finding(FindingKind.QUANTISED, name, words))
    if x.size >= ENOUGH and not any(one.kind is FindingKind.CLIPPED for one in found):
        glitches = find_glitches(x, noise=noise).indices
        glitches = glitches[~np.isin(glitches, jumps[:, None] + np.arange(-BESIDE, BESIDE + 1))]
        if glitches.size:
            many = np.count_nonzero(np.diff(glitches, prepend=-2) > 1)
            words = f"{name}: {many} glitch(es) of one sample or two, the first at sample {glitches[0]}"
            found.append(Finding(FindingKind.GLITCHES, name, words, tuple(int(i) for i in glitches)))
    return found


def stretches(samples: int) -> NDArray[np.intp]:
    """Return the samples of a long record that are looked at: stretches of it, evenly apart."""
    width = LOOKED_AT // STRETCHES
    starts = np.linspace(0, samples - width, STRETCHES).astype(np.intp)
    return np.asarray((starts[:, None] + np.arange(width)).ravel())


def _in_stretches(
    name: str, x: Floats, unit: str, noise: float | None, jumps: NDArray[np.intp], ends: tuple[float, float]
) -> list[Finding]:
    """Look at stretches of a long channel, whose lowest and highest values are known."""
    at = stretches(x.size)
    width = at.size // STRETCHES
    seams = np.arange(width, at.size, width)  # as beside a gap
    beside = np.union1d(np.flatnonzero(np.isin(at, jumps)), seams)
    found = channel_findings(name, x[at], unit, noise, beside)
    reached = x[at].min() == ends[0] or x[at].max() == ends[1]  # a limit is one of the whole record
    return [
        replace(
            one,
            message=f"{one.message}, as {STRETCHES} stretches of {width} samples show",
            samples=tuple(int(at[i]) for i in one.samples),
        )
        for one in found
        if one.kind is not FindingKind.CLIPPED or reached
    ]


def belt_findings(belt: Floats, set_point: float, unit: str) -> list[Finding]:
    """Compare the measured belt speed (n,) with its set-point, both in the column's unit."""
    mean = float(np.mean(belt))
    if set_point != 0 and not 0.5 < mean / set_point < 2.0:
        words = (
            f"belt: averages {mean:.3g} {unit}, its set-point is {set_point:.3g} {unit}; unit or sign wrong?"
        )
        return [Finding(FindingKind.BELT, "belt", words)]
    return []


def drive_findings(t: Floats, x: Floats, force: Floats, mass: float) -> list[Finding]:
    """Compare the mass that drive and acceleration tell of with the declared one: a wrong unit, gain or sign.

    Parameters
    ----------
    t, x, force
        Times, position and drive (n,) in the model's numbers.
    mass
        The declared mass.
    """
    wide = max(
        len(t) // 400, 1
    )  # samples a difference spans: long enough that steps of the reading do not matter
    dt = wide * float(np.median(np.diff(t)))
    if len(t) < 8 * wide or np.ptp(force) == 0:
        return []
    a = (x[2 * wide :] - 2 * x[wide:-wide] + x[: -2 * wide]) / dt**2
    triangle = np.convolve(np.ones(wide), np.ones(wide)) / wide**2
    mean = np.convolve(force, triangle, mode="valid")[: len(a)]
    v = (x[2 * wide :] - x[: -2 * wide]) / (2 * dt)
    columns = np.column_stack([a[: len(mean)], v[: len(mean)], np.sign(v[: len(mean)]), np.ones(len(mean))])
    told = float(np.linalg.lstsq(columns, mean, rcond=None)[0][0])
    if 1 / 3 < told / mass < 3:
        return []
    words = f"drive: it and the acceleration tell of a mass of {told:.3g} where {mass:.3g} is declared"
    n = power(told / mass)
    words += (
        f"; {put_right({'mass': mass}, 'kg', n)}"
        if n
        else "; is a unit, the drive's scale, or a sign wrong, or a column another's?"
    )
    return [Finding(FindingKind.SIZE, "drive", words)]


def size_findings(name: str, x: Floats, reach: float, unit: str, per_unit: float) -> list[Finding]:
    """Compare a channel's range with the deflection that static friction can hold.

    Parameters
    ----------
    name, x
        Channel and its values (n,) in the model's numbers.
    reach
        Deflection the friction can hold: static limits over stiffness.
    unit, per_unit
        Unit of the column, and the model's number for 1 of it.
    """
    width = float(np.ptp(x))
    if reach <= 0 or width == 0 or 1e-3 < width / reach < 50:
        return []
    words = (
        f"{name}: ranges over {width / per_unit:.3g} {unit}, where the declared friction holds the spring"
        f" at about {reach / per_unit:.3g} {unit}; is the unit right?"
    )
    return [Finding(FindingKind.SIZE, name, words)]
