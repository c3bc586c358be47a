"""What a search of windows does without: train runs that have none, and most cycles of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from stickslip.fitted.data import Data
from stickslip.likelihoods.stretches import Stretch
from stickslip.measured.case import Case

NOTHING: Mapping[str, str] = {}
IDLE = (
    "not used: nothing in it rises at belt_speed for long, so that no stick ends in it; the other train runs are "
    "enough. Is belt_speed right?"
)
MOST = 0.5  # share of a run's cycles that are fitted, below which it is said


def with_windows(
    case: Case, used: Sequence[Data], every: Sequence[Stretch], why: Mapping[str, str] = NOTHING
) -> tuple[Case, tuple[str, ...]]:
    """
    Return the case without the train runs that have no windows, and in words what is not fitted.

    Parameters
    ----------
    case : as declared
    used, every : its train runs that have windows, and these
    why : others have none, by name; the rest stick nowhere
    """
    kept = {run.name for run in used}
    gone = [run.name for run in case.train if run.name not in kept]
    words = [f"{name}: {why.get(name, IDLE)}" for name in gone]
    for number, run in enumerate(used):
        count, cycles = sum(one.run == number for one in every), len(run.slips) - 1
        if 0 < count < MOST * cycles:
            words.append(
                f"{run.name}: {count} of its {cycles} cycles are fitted: between the others the block does not clearly "
                "stick"
            )
    return replace(case, runs=tuple(run for run in case.runs if run.name not in gone)), tuple(words)
