"""What the train runs say is claimed only where runs that were not used are forecast no worse with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import scipy

from stickslip.declared.catalogue import KINDS
from stickslip.discovery.result import ErrorBlock, Found, FoundEffect, Likelihood, Verdict

FoundT = TypeVar("FoundT", bound=Found)
FEWEST = 5  # events, the fewest whose ranks can speak against anything at 5 %


def of_falls(falls: Sequence[float], spare: float | None = None, name: str = "") -> Likelihood | None:
    """
    Return how likely runs never used are; None of so few that they can speak against nothing.

    Parameters
    ----------
    falls : by how much the -2 log likelihood of each of their events falls with what was found
    spare, name : as the likelihood has them
    """
    if len(falls) < FEWEST:
        return None
    test = scipy.stats.wilcoxon(falls, alternative="less")
    return Likelihood(float(np.sum(falls)), len(falls), float(test.pvalue), spare, name)


def deciding(
    falls: Sequence[float], spare: float | None, each: Mapping[str, tuple[Sequence[float], float]]
) -> Likelihood | None:
    """
    Return what decides: the first of several effects that does not carry over beside the others, or all together.

    Parameters
    ----------
    falls, spare : of all that was found, as of `of_falls`
    each : the same of each effect, by name
    """
    alone = (of_falls(own, beyond, name) for name, (own, beyond) in each.items())
    return next((one for one in alone if one is not None and not one.carries), of_falls(falls, spare))


def carries_over(found: Found) -> bool:
    """Whether what was found is claimed: runs never used do not speak against it."""
    return found.verdict is Verdict.no_effect or found.error.carries


def claimed(found: FoundT, fewer: Iterable[FoundT], silent: Callable[[], FoundT]) -> FoundT:
    """
    Return what is claimed: all that was found, or of its effects what runs never used bear, or nothing.

    Parameters
    ----------
    found : all of it
    fewer : the same with fewer effects, the best first, each made when it is asked for
    silent : makes the same with none
    """
    if carries_over(found):
        return found
    for less in fewer:
        if carries_over(less):
            return replace(less, messages=(_beside(found, less), *less.messages))
    return instead(found, silent())


def _beside(found: Found, less: Found) -> str:
    """Why what does not carry over is not claimed beside what does."""
    kept = {(one.name, one.where) for one in less.effects}
    gone = [one for one in found.effects if (one.name, one.where) not in kept]
    known = ", ".join(map(_called, less.effects))
    names = ", ".join(map(_called, gone))
    held = found.error.likelihood
    it = "" if held is None or held.name in ("", *(one.name for one in gone)) else "both together"
    return (
        f"{names} would be named beside {known} by the train runs, but {doubt(found.error, it)}: not claimed"
    )


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


def doubt(error: ErrorBlock, it: str = "") -> str:
    """Return in words why what was found, `it`, does not carry over."""
    held = error.likelihood
    rises = f"the error on runs never used RISES from {error.before:.3g} to {error.after:.3g}"
    if held is None:
        return rises
    it = it or held.name or "it"
    if held.against and held.gain > 0:  # a few events gain more than most lose
        return f"most of {held.forecasts} events of runs never used are less likely with {it} (p = {held.chance:.2g})"
    less = f"runs never used are less likely with {it}, by {-held.gain:.3g} in -2 log likelihood"
    if held.against:
        return f"{less} over {held.forecasts} events (p = {held.chance:.2g})"
    if held.too_little:
        return f"{less}: more than the {held.spare:.3g} by which the train runs pass the gate"
    return f"{rises}, and they are no more likely with {it}"
