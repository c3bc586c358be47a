"""Readings that a search leaves out: how many, and why."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.discovery.filtered import filtered, thinned, told
from stickslip.discovery.laboratory.left import Left
from stickslip.fitted.data import Data
from stickslip.measured.case import Case


def masked(before: Sequence[Data], after: Sequence[Data]) -> int:
    """Return how many readings have been taken out."""
    return sum(int(np.sum(b.weight == 0) - np.sum(a.weight == 0)) for a, b in zip(before, after, strict=True))


def independent(case: Case, data: Sequence[Data], left: Left) -> tuple[list[Data], tuple[str, ...]]:
    """
    Return the runs with as many readings as are independent behind a sensor's filter, and that in words.

    Parameters
    ----------
    case : as declared
    data : all runs, those of the fit first
    left : what the fit leaves
    """
    found = filtered(left, data)
    if found is None:
        return list(data), ()
    some = thinned(data, *found)
    return some, (told(case, some, found[0]),)


def left_out(before: Sequence[Data], after: Sequence[Data]) -> tuple[str, ...]:
    """Say how many readings of the fit were left out."""
    out, readings = masked(before, after), sum(run.readings.size for run in before)
    if not out:
        return ()
    which = "1 reading that stands out" if out == 1 else f"{out} readings that stand out"
    return (f"left out of the fits: {which} from both sides ({100 * out / readings:.2g} % of all)",)
