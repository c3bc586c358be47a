"""A curve that was scored, with all else fitted beside it: what it gains is proven there.

A score is of first order. Along what is all but free (a load and the level of a law) it steps far; friction that is
larger makes the same scatter a smaller share of it, and linear windows take that for a gain.
"""

from __future__ import annotations

import itertools
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.laboratory.curve_term import curve_term
from stickslip.discovery.laboratory.hypothesis import Bench, Term, terms_at
from stickslip.discovery.laboratory.learned import Learned
from stickslip.discovery.laboratory.trials import Trial
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.event_windows import own_in
from stickslip.likelihoods.fit import fitted
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.remembered import remembered
from stickslip.likelihoods.single_windows import settled

Floats = NDArray[np.float64]
SHARES = (1.0, 0.4, 0.0)  # of a curve as it was scored, that a fit is tried from
HELD = 1e-9  # what a number that stays where it is may move by
GAUSSIAN = 1e6  # degrees of freedom of Student's t, so many that it has no tails


def proven(bench: Bench, base: Trial, curve: Learned) -> tuple[Learned, Trial]:
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


def beside(bench: Bench, base: Trial, curve: Learned) -> Trial:
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


def _with_term(bench: Bench, base: Trial, curve: Learned) -> Trial:
    """
    The hypothesis with a curve as a term, fitted from the best of several starts.

    A curve does what a wrong constant does: beside it constants have no long tails.
    """
    policy = replace(bench.policy, tail=GAUSSIAN)
    declared = bench.declared if base.freed is None else base.freed.declared
    firm = replace(bench, policy=policy, declared=declared)
    starts = (_settled(firm, base, curve, *one) for one in itertools.product(SHARES, (True, False)))
    first, term, _ = min(starts, key=_cost)
    fit = fitted(first, policy, policy.candidate_steps, held=2)
    if fit.steps >= policy.candidate_steps:  # what it gains is not yet what it could
        with suppress(FloatingPointError):
            fit = min(fit, fitted(fit, policy), key=lambda one: one.deviance)
    return replace(base, terms=terms_at((*base.terms, term), first.windows, fit.at), fit=fit)


def _settled(
    bench: Bench, base: Trial, curve: Learned, share: float, declared: bool
) -> tuple[Fit, Term, float]:
    """A start with a share of the curve, constants as declared or as they are, its windows settled; what it costs."""
    assert curve.effect is not None
    there = curve.effect.replace(**{name: share * x for name, x in curve.effect.parameters.items()})
    # what is the law's own level, or a set-point's, is not sought
    held = f"value_{len(curve.x) // 2}" if curve.count < len(curve.x) else None
    term = curve_term(there, curve.width, held)
    windows = bench.windows((*base.terms, term))
    at = np.array([n.start for n in windows.numbers])
    at[: len(base.fit.at)] = base.fit.at
    # of what names explain the curve could take any part
    windows.numbers = tuple(
        replace(n, low=x - HELD, high=x + HELD) if n.name.rpartition(".")[0] in base.names else n
        for n, x in zip(windows.numbers, at.tolist(), strict=True)
    )
    if declared:
        group = windows.prior.group
        at[group] = windows.prior.centre[group]
    own = own_in(base.fit.own, base.fit.windows, windows)
    first = replace(base.fit, windows=windows, at=windows.bounded(at), own=own)
    own, _, each = settled(first)
    return replace(first, own=own), term, float(each.sum()) + windows.prior.penalty(first.at)


def _cost(start: tuple[Fit, Term, float]) -> float:
    return start[2]
