"""What is said beside the verdict on a block on a belt."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from stickslip.declared.effect import CONSTANTS
from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.discovery.result import Alternative, Experiment, FoundEffect
from stickslip.discovery.rig_numbers import BEYOND
from stickslip.fitted.block_events.table import MeasuredBlock
from stickslip.measured.case import Case

STICKS = 5  # whose median has an error
MEDIAN = 1.25  # standard error of a median over that of a mean


def ridden(case: Case, runs: Sequence[MeasuredBlock], effects: Sequence[FoundEffect]) -> tuple[str, ...]:
    """
    Return what is said where nothing is named, and sticks all the same rise at another rate than the belt's.

    A stick shows that whatever friction does; what makes it so the readings do not tell.
    """
    rates = np.concatenate([one.sticks.rate for one in runs])
    if effects or len(rates) < STICKS:
        return ()
    ratio = float(np.median(rates))
    error = float(np.subtract(*np.quantile(rates, [0.75, 0.25]))) / 1.35 / math.sqrt(len(rates)) * MEDIAN
    channel = case.train[0].channel("x1")
    force = channel == "spring_force"
    known = math.hypot(
        case.uncertainty.relative(channel), case.uncertainty.relative("stiffness") if force else 0.0
    )
    if ratio <= 0 or abs(math.log(ratio)) < BEYOND * math.hypot(error / ratio, known):
        return ()
    who = f"the gain of {channel}, the spring's stiffness" if force else f"the gain of {channel}"
    size = f"{ratio:.3g} +- {SIGMAS_95 * error:.1g} times"
    load = "weight" if force else "length"
    return (
        f"in sticks {channel} rises {size} as fast as declared ({len(rates)} sticks): {who} or the speed of the pull "
        "is off by that, which these runs do not tell: load the sensor with a known "
        f"{load}, and measure the speed",
    )


def absorbed(signs: Iterable[float]) -> str:
    """Say what becomes of a constant load, by the directions of the runs."""
    if len(set(signs)) == 1:
        return (
            "a constant load on the block is absorbed whole by the friction law: every run slips one way only"
        )
    return "a constant load on the block is not sought: it shifts friction's levels, up one way and down the other"


def set_point(name: str) -> tuple[Alternative, ...]:
    """Return what a gain is as well, no reading being another: a belt of another multiple of its set-points."""
    if name != "sensor_gain":
        return ()
    reason = (
        "a true belt speed of (1 + e) times the set-point, in every run alike, gives the same readings to the last: "
        "measure the speed of the pull"
    )
    return (Alternative("belt speed", 1.0, 0.0, True, True, reason, {}),)


def experiments(effects: Sequence[FoundEffect]) -> tuple[Experiment, ...]:
    """What would break the ties that these runs cannot."""
    out = []
    tied = {(e.name, a.name) for e in effects for a in e.alternatives if a.tied}
    constants = {name for pair in tied for name in pair} & set(CONSTANTS)
    if len(constants) > 1:
        pair = (
            ("sensor_gain", "rig_stiffness") if "sensor_gain" in constants else ("rig_mass", "rig_stiffness")
        )
        out.append(
            Experiment(
                "weigh the block, and hang a known weight on the spring", None, pair, float("inf"), True
            )
        )
        out.append(
            Experiment("repeat with another spring of known stiffness", None, pair, float("inf"), True)
        )
    if ("sensor_gain", "belt speed") in tied:
        out.append(
            Experiment(
                "measure the speed of the pull", None, ("sensor_gain", "belt speed"), float("inf"), True
            )
        )
    if any({"belt_seam", "harmonic_forcing"} == set(pair) for pair in tied):
        what = "two speeds whose runs both last several periods"
        out.append(Experiment(what, None, ("belt_seam", "harmonic_forcing"), float("inf"), True))
    return tuple(out)
