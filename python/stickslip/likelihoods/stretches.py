"""Stretches of a run from mid-stick to mid-stick: each holds one breakaway and one slip whole."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.fitted.data import Data
from stickslip.likelihoods.policy import POLICY, Policy


@dataclass(frozen=True)
class Stretch:
    """
    Samples start <= i < stop of a run.

    Parameters
    ----------
    run, start, stop : where it is
    dwell : time that the block has stuck at its first sample
    """

    run: int
    start: int
    stop: int
    dwell: float


def stretches(data: Sequence[Data], policy: Policy = POLICY) -> list[Stretch]:
    """Return the stretches of all runs; a cycle without a clear stick ends none and begins none."""
    out = []
    for number, run in enumerate(data):
        cuts = [
            _middle(run, int(a), int(b), policy) for a, b in zip(run.slips[:-1], run.slips[1:], strict=True)
        ]
        for one, other in zip(cuts[:-1], cuts[1:], strict=True):
            if one is not None and other is not None:
                out.append(Stretch(number, one[0], other[0], one[1]))
    return out


def _middle(run: Data, first: int, last: int, policy: Policy) -> tuple[int, float] | None:
    """Return the middle sample of the longest stick between two slips, and how long the block has stuck there."""
    slow = np.abs(run.v[first:last] - run.belt_speed) < policy.stick_band * abs(run.belt_speed)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]]).astype(int)))
    begins, ends = edges[::2], edges[1::2]
    if not len(begins):
        return None
    longest = int(np.argmax(ends - begins))
    if ends[longest] - begins[longest] < policy.fewest_stuck:
        return None
    middle = first + int(begins[longest] + ends[longest]) // 2
    return middle, float(run.t[middle] - run.t[first + begins[longest]])
