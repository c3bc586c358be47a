"""A curve that was scored, with all else fitted beside it: what it gains is proven there.

A score is of first order. Along what is all but free (a load and the level of a law) it steps far; friction that is
larger makes the same scatter a smaller share of it, and linear windows take that for a gain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.laboratory.curve_term import curve_term
from stickslip.discovery.laboratory.hypothesis import Bench, terms_at
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.rig_numbers import BEYOND
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit import fitted
from stickslip.likelihoods.remembered import remembered

Floats = NDArray[np.float64]
HELD = 1e-9  # what a number that stays where it is may move by
GAUSSIAN = 1e6  # degrees of freedom of Student's t, so many that it has no tails


def proven(bench: Bench, base: Trial, curve: ScoredCurve) -> tuple[ScoredCurve, Trial]:
    """
    Return a curve as it stands with all else fitted beside it, and the hypothesis with it.

    What it explains is held against what events that remember explain without it.

    Parameters
    ----------
    bench, base : the hypothesis that it stands beside
    curve : as scored
    """
    after = beside(bench, base, curve)
    gain = base.fit.deviance - base.remembered - after.fit.deviance + remembered(after.fit)
    if curve.effect is None:
        return replace(curve, gain=gain), after
    assert after.fit.solution is not None
    p, numbers = len(base.fit.at), after.fit.values()
    names = [f"{curve.effect.name}.{name}" for name in curve.effect.parameters]
    free = np.array([name in {n.name for n in after.fit.windows.numbers[p:]} for name in names])
    covariance = np.zeros((len(names), len(names)))
    covariance[np.ix_(free, free)] = after.fit.solution.covariance[p:, p:]
    return curve.fitted(np.array([numbers[name] for name in names]), covariance, gain), after


def beside(bench: Bench, base: Trial, curve: ScoredCurve) -> Trial:
    """
    Return a hypothesis with a curve, fitted.

    It is a term of it whose values are fitted too; one of the belt is there as what is known of each event, as it was
    scored.

    Parameters
    ----------
    bench, base : the hypothesis that it stands beside
    curve : as scored
    """
    if curve.effect is not None:
        return _with_term(bench, base, curve)
    fit, windows = base.fit, bench.windows(base.terms)
    assert curve.events is not None
    assert isinstance(windows, BeltWindows)
    nothing, own = np.zeros(windows.effects), fit.own.copy()
    windows.added = np.array([nothing if one is None else one for one in curve.events])
    own[:, windows.begins :] -= windows.added  # it begins with the motions that there were
    start = replace(fit, windows=windows, own=own)
    return replace(base, fit=fitted(start, bench.policy, bench.policy.candidate_steps, held=2))


def _with_term(bench: Bench, base: Trial, curve: ScoredCurve) -> Trial:
    """
    The hypothesis with a curve as a term, fitted from where it stands without it.

    A curve does what a wrong constant does: beside it constants have no long tails. Where they are far off without it
    it is fitted from those declared, too, and the better is kept. What names at its place explain it could take any
    part of: they stay where they are.
    """
    assert curve.effect is not None
    policy = replace(bench.policy, tail=GAUSSIAN)
    declared = bench.declared if base.freed is None else base.freed.declared
    # what is the law's own level, or a set-point's, is not sought
    held = f"value_{len(curve.x) // 2}" if curve.count < len(curve.x) else None
    term = curve_term(curve.effect.replace(**dict.fromkeys(curve.effect.parameters, 0.0)), curve.width, held)
    windows = replace(bench, policy=policy, declared=declared).windows((*base.terms, term))
    at = np.array([n.start for n in windows.numbers])
    at[: len(base.fit.at)] = base.fit.at
    windows.numbers = tuple(
        replace(n, low=x - HELD, high=x + HELD) if n.name.rpartition(".")[0] in base.names else n
        for n, x in zip(windows.numbers, at.tolist(), strict=True)
    )
    starts = [at]
    if windows.prior.farthest(at) > BEYOND:  # they do the curve's work, and hold it where it is nothing
        starts.append(windows.prior.as_declared(at))
    fits = [fitted(replace(base.fit, windows=windows, at=one), policy, held=2) for one in starts]
    fit = min(fits, key=lambda one: one.deviance)
    return replace(base, terms=terms_at((*base.terms, term), windows, fit.at), fit=fit)
