"""What the train runs name is claimed only where runs that were not used are forecast no worse with it."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from stickslip.discovery.result import ErrorBlock, Found, Verdict

FoundT = TypeVar("FoundT", bound=Found)


def carries_over(found: Found) -> bool:
    """Whether names are claimed: runs never used do not speak against them."""
    return found.verdict is not Verdict.effect_found or found.error.carries


def instead(found: Found, silent: FoundT) -> FoundT:
    """Return the result without the names, and which they would have been."""
    names = ", ".join(one.name for one in found.effects)
    why = f"{names} would be named by the train runs, but {doubt(found.error)}: nothing is claimed"
    return replace(silent, unclaimed=found.effects, messages=(why, *silent.messages))


def doubt(error: ErrorBlock) -> str:
    """Return in words why what was found does not carry over."""
    if (held := error.likelihood) is None:
        return f"the error on runs never used RISES from {error.before:.3g} to {error.after:.3g}"
    if held.against and held.gain > 0:  # a few forecasts gain more than most lose
        return f"most of {held.forecasts} forecasts of runs never used are less likely with it (p = {held.chance:.2g})"
    less = f"runs never used are less likely with it, by {-held.gain:.3g} in -2 log likelihood"
    if held.against:
        return f"{less} over {held.forecasts} forecasts (p = {held.chance:.2g})"
    return f"{less}: more than the {held.spare:.3g} by which the train runs pass the gate"
