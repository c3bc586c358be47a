"""What the train runs say is claimed only where runs that were not used are forecast no worse with it."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from stickslip.declared.catalogue import KINDS
from stickslip.discovery.result import ErrorBlock, Found, FoundEffect, Verdict

FoundT = TypeVar("FoundT", bound=Found)


def carries_over(found: Found) -> bool:
    """Whether what was found is claimed: runs never used do not speak against it."""
    return found.verdict is Verdict.no_effect or found.error.carries


def instead(found: Found, silent: FoundT) -> FoundT:
    """Return the result without the names, and which they would have been."""
    names = ", ".join(map(_called, found.effects))
    verb = "named" if all(_called(one) == one.name for one in found.effects) else "told"
    why = f"{names} would be {verb} by the train runs, but {doubt(found.error)}: nothing is claimed"
    return replace(silent, unclaimed=found.effects, messages=(why, *silent.messages))


def _called(one: FoundEffect) -> str:
    """What was found, by its name or by its place."""
    if one.curve is None or one.name in KINDS:
        return one.name
    return f"a curve in {one.curve.variable} of no name ({one.where})"


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
