"""Train runs that a search of windows does without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stickslip.fitted.data import Data
from stickslip.measured.case import Case


def with_windows(case: Case, used: Sequence[Data]) -> tuple[Case, tuple[str, ...]]:
    """
    Return the case without the train runs that have no windows, and that in words.

    Parameters
    ----------
    case : as declared
    used : its train runs that have windows
    """
    kept = {run.name for run in used}
    gone = [run.name for run in case.train if run.name not in kept]
    words = tuple(
        f"{name}: not used: nothing in it rises at belt_speed for long, so that no stick ends in it; the other train "
        "runs are enough. Is belt_speed right?"
        for name in gone
    )
    return replace(case, runs=tuple(run for run in case.runs if run.name not in gone)), words
