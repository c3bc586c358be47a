"""95 % intervals of a fitted balance, from the curvature of its chi-squared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.driven_slider import terms as tm
from stickslip.discovery.driven_slider.fit import Balance, Choice, Fit, lengths
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
    chi-squared per reading where that is above 1: what is left over widens the intervals. A scanned number is drawn
    no further than the runs can tell: what moves nothing has the whole of that range.
    """
    X, steps = balance.design(fit)
    names = balance.law_names(fit)
    used = len(names) + sum(len(b) for b in fit.amplitudes)
    keep = [*range(used), *range(X.shape[1] - len(steps), X.shape[1])]
    best = np.concatenate([fit.coefficients[:used], np.zeros(len(steps))])
    drawn = _drawn(best, X, keep, used, max(fit.per_reading, 1.0))
    law = {
        name: Interval(float(fit.coefficients[i]), None, None)
        if not X[:, i].any()  # a direction in which the slider never moved
        else _interval(fit.coefficients[i], drawn[:, i])
        for i, name in enumerate(names)
        if name != "mass"
    }
    out = Numbers(law, {}, {})
    grids = tm.grids(balance.runs, balance.band.cutoff)
    at, k = len(names), 0
    for one, b in zip(fit.choices, fit.amplitudes, strict=True):
        count = len(one.inside)
        values = one.term.parameters(one.inside, b, fit.law)
        many: dict[str, list[float]] = {name: [] for name in values}
        shifted = _shifted(one, steps[k : k + count] * drawn[:, used + k : used + k + count], grids)
        for row, inside in zip(drawn, shifted, strict=True):
            numbers = one.term.parameters(inside, row[at : at + len(b)], _law(fit, names, row))
            for name, value in numbers.items():
                many[name].append(value)
        if one.name.startswith("tabulated"):
            out.deviations[one.name] = np.array([np.std(v) for v in many.values()])
        out.effects[one.name] = {
            n: _interval(v, np.array(many[n]), turn=n == "phi") for n, v in values.items()
        }
        at, k = at + len(b), k + count
    return out


def _drawn(best: Floats, X: Floats, keep: list[int], used: int, inflated: float) -> Floats:
    """Draws (DRAWS, k) of the numbers whose columns of the design are `keep`.

    The first `used` are coefficients, the rest shifts of scanned numbers: endless both ways where nothing moves.
    """
    scale = lengths(X)
    q = np.linalg.pinv((X / scale).T @ (X / scale), rcond=1e-12, hermitian=True) / np.outer(scale, scale)
    covariance = q[np.ix_(keep, keep)] * inflated
    generator = np.random.default_rng(0)
    # semidefinite but for rounding, whatever the sizes of its entries
    out = generator.multivariate_normal(best, covariance, DRAWS, check_valid="ignore", method="eigh")
    silent = used + np.flatnonzero(~X[:, keep[used:]].any(axis=0))
    out[::2, silent], out[1::2, silent] = -np.inf, np.inf
    return out


def _shifted(one: Choice, logs: Floats, grids: Mapping[str, Floats]) -> Floats:
    """Scanned numbers (DRAWS, k) whose logarithms are shifted, within what is tried of them."""
    for i, (name, inside) in enumerate(zip(one.term.scanned, np.abs(one.inside), strict=True)):
        tried = np.append(np.abs(grids[name]), inside)
        logs[:, i] = np.clip(logs[:, i], *np.log(np.array([tried.min(), tried.max()]) / inside))
    return np.asarray(one.inside * np.exp(logs))


def _law(fit: Fit, names: tuple[str, ...], row: Floats) -> Law:
    known = dict(zip(names, map(float, row), strict=False))
    return Law(known.get("mass", fit.law.mass), known["damping"], known["kinetic"], known["kinetic_plus"])


def _interval(value: float, drawn: Floats, *, turn: bool = False) -> Interval:
    if turn:  # a phase goes round
        drawn = value + np.mod(drawn - value + np.pi, 2 * np.pi) - np.pi
    low, high = np.percentile(drawn, [2.5, 97.5])
    return Interval(float(value), float(low), float(high))
