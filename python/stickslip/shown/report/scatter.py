"""`scatter` of report.json: what differs from event to event, and at most by how much where nothing is seen to."""

from __future__ import annotations

import math

from stickslip.discovery.plain import Json, plain
from stickslip.discovery.result import Found
from stickslip.likelihoods.interval import Interval
from stickslip.likelihoods.policy import POLICY

KINDS = ("static", "kinetic", "belt")


def scatter(found: Found) -> dict[str, Json]:
    """
    Return relative standard deviations of static and kinetic friction and of the belt's speed, by name.

    Where every event is like every other the least is 0, and the most what would be seen. None of what the rig has not,
    or where friction of single events is not looked at.
    """
    out: dict[str, Json] = dict.fromkeys(KINDS)
    there = found.after.scatter
    if there is not None and not found.scatter:
        static = math.hypot(there.static, there.kinetic)
        for name, size in zip(KINDS, (static, there.kinetic, there.belt), strict=True):
            out[name] = plain(Interval(size, 0.0, max(size, POLICY.repeats)))
    return out | {name: plain(one) for name, one in found.scatter.items()}
