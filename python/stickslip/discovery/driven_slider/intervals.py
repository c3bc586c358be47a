"""95 % intervals of a fitted balance, from the curvature of its chi-squared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.driven_slider.fit import Balance, Fit
from stickslip.discovery.driven_slider.terms import Law
from stickslip.discovery.result import Interval

Floats = NDArray[np.float64]

DRAWS = 500


@dataclass(frozen=True)
class Numbers:
    """Intervals of the law, of every candidate's parameters, and the standard deviations of a curve's values."""

    law: dict[str, Interval]
    effects: dict[str, dict[str, Interval]]
    deviations: dict[str, Floats]


def intervals(balance: Balance, fit: Fit) -> Numbers:
    """Intervals of the law and of every candidate's parameters.

    The numbers are drawn from the normal distribution that the least squares give, its variance multiplied by
    chi-squared per reading where that is above 1: what is left over widens the intervals.
    """
    X, steps = balance.design(fit)
    names = balance.law_names(fit)
    used = len(names) + sum(len(b) for b in fit.amplitudes)
    scale = np.maximum(np.linalg.norm(X, axis=0), 1e-300)
    q = np.linalg.pinv((X / scale).T @ (X / scale), rcond=1e-12, hermitian=True) / np.outer(scale, scale)
    keep = [*range(used), *range(X.shape[1] - len(steps), X.shape[1])]
    covariance = q[np.ix_(keep, keep)] * max(fit.per_reading, 1.0)
    best = np.concatenate([fit.coefficients[:used], np.zeros(len(steps))])
    drawn = np.random.default_rng(0).multivariate_normal(best, covariance, DRAWS, method="eigh")
    law = {
        name: _interval(fit.coefficients[i], drawn[:, i]) for i, name in enumerate(names) if name != "mass"
    }
    out = Numbers(law, {}, {})
    at, k = len(names), 0
    for one, b in zip(fit.choices, fit.amplitudes, strict=True):
        count = len(one.inside)
        values = one.term.parameters(one.inside, b, fit.law)
        many: dict[str, list[float]] = {name: [] for name in values}
        for row in drawn:
            shifted = one.inside * np.exp(steps[k : k + count] * row[used + k : used + k + count])
            for name, value in one.term.parameters(
                shifted, row[at : at + len(b)], _law(fit, names, row)
            ).items():
                many[name].append(value)
        if one.name.startswith("tabulated"):
            out.deviations[one.name] = np.array([np.std(v) for v in many.values()])
        out.effects[one.name] = {
            n: _interval(v, np.array(many[n]), turn=n == "phi") for n, v in values.items()
        }
        at, k = at + len(b), k + count
    return out


def _law(fit: Fit, names: tuple[str, ...], row: Floats) -> Law:
    known = dict(zip(names, map(float, row), strict=False))
    return Law(known.get("mass", fit.law.mass), known["damping"], known["kinetic"], known["kinetic_plus"])


def _interval(value: float, drawn: Floats, *, turn: bool = False) -> Interval:
    if turn:  # a phase goes round
        drawn = value + np.mod(drawn - value + np.pi, 2 * np.pi) - np.pi
    low, high = np.percentile(drawn, [2.5, 97.5])
    return Interval(float(value), float(low), float(high))
