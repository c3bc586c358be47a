"""What the train runs name is claimed only where runs that were not used are forecast no worse with it."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from stickslip.discovery.result import Found, Verdict

FoundT = TypeVar("FoundT", bound=Found)


def carries_over(found: Found) -> bool:
    """Whether names are claimed: the error on runs never used does not rise with them."""
    return found.verdict is not Verdict.effect_found or not found.error.rises


def instead(found: Found, silent: FoundT) -> FoundT:
    """Return the result without the names, and which they would have been."""
    names = ", ".join(one.name for one in found.effects)
    why = (
        f"{names} would be named by the train runs, but the error on runs never used RISES from "
        f"{found.error.before:.3g} to {found.error.after:.3g}: nothing is claimed"
    )
    return replace(silent, unclaimed=found.effects, messages=(why, *silent.messages))
