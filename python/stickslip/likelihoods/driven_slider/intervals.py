"""95 % intervals of a fitted balance, from the curvature of its chi-squared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.driven_slider import terms as tm
from stickslip.likelihoods.driven_slider.fit import STEP, Balance, lengths
from stickslip.likelihoods.driven_slider.fitted_motion import Choice, MotionFit
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.likelihoods.interval import Interval

Floats = NDArray[np.float64]

LAW = {"mass": "mass", "damping": "damping", "kinetic": "minus", "kinetic_plus": "plus"}


@dataclass(frozen=True)
class Numbers:
    """Intervals of the law, of every candidate's parameters, and the standard deviations of a curve's values."""

    law: dict[str, Interval]
    effects: dict[str, dict[str, Interval]]
    deviations: dict[str, Floats]


def intervals(balance: Balance, fit: MotionFit) -> Numbers:
    """Intervals of the law and of every candidate's parameters.

    The numbers are drawn from the normal distribution that the least squares give, its variance multiplied by
    chi-squared per reading where that is above 1: what is left over widens the intervals. A scanned number is drawn
    no further than the runs can tell: what moves nothing has the whole of that range.
    """
    balance.at(fit)
    X, moved, steps = derivatives(balance, fit)
    drawn = _drawn(balance, fit, np.column_stack([X, moved]), len(fit.coefficients))
    logs = steps * drawn[:, len(fit.coefficients) :]
    used = drawn[:, : len(fit.coefficients)]
    laws = [balance.law_of(row) for row in used]
    law = {
        name: Interval(float(getattr(fit.law, own)), None, None)
        if not X[:, i].any()  # a direction in which the slider never moved
        else _interval(getattr(fit.law, own), np.array([getattr(one, own) for one in laws]))
        for i, (name, own) in enumerate(LAW.items())
    }
    out = Numbers(law, {}, {})
    grids = tm.grids(balance.runs)
    amplitudes = [balance.amplitudes(fit.choices, row) for row in used]
    k = 0
    for place, one in enumerate(fit.choices):
        count = len(one.inside)
        shifted = _shifted(one, logs[:, k : k + count], grids)
        rows = zip(amplitudes, shifted, laws, strict=True)
        numbers = [one.term.parameters(inside, b[place], own) for b, inside, own in rows]
        values = one.term.parameters(one.inside, fit.amplitudes[place], fit.law)
        many = {name: np.array([row[name] for row in numbers]) for name in values}
        if one.name.startswith("tabulated"):
            out.deviations[one.name] = np.array([np.std(v) for v in many.values()])
        out.effects[one.name] = {n: _interval(v, many[n], turn=n == "phi") for n, v in values.items()}
        k += count
    return out


def derivatives(balance: Balance, fit: MotionFit) -> tuple[Floats, Floats, Floats]:
    """White columns of everything fitted, those of the scanned numbers, and the step of the logarithm of each."""
    _, X = balance.design(fit.choices, fit.law)
    parts, steps = [np.zeros((len(X), 0))], []
    for one, b in zip(fit.choices, fit.amplitudes, strict=True):
        if not len(one.inside):
            continue
        c = balance.white_columns(one.term, one.inside, fit.law)
        weight = (np.ones(1) if one.term.fixed else b) / fit.law.mass
        for i in range(len(one.inside)):
            step = STEP * balance.step(one)
            inside = one.inside.copy()
            inside[i] *= np.exp(step)
            column = np.zeros(len(X))
            change = balance.white_columns(one.term, inside, fit.law) - c
            column[: len(c)] = -(change @ weight) / STEP
            parts.append(column[:, None])
            steps.append(step / STEP)
    return X, np.column_stack(parts), np.array(steps)


def law_covariance(balance: Balance, fit: MotionFit) -> Floats:
    """Covariance (4, 4) of mass, damping and friction of either direction, to first order; 0 of what is held."""
    balance.at(fit)
    X, moved, _ = derivatives(balance, fit)
    known = _known(balance, fit, np.column_stack([X, moved]))[: len(LAW), : len(LAW)]
    mass = fit.law.mass
    slopes = mass * np.eye(len(LAW))  # all but the first coefficient are numbers over the mass
    slopes[:, 0] = [-mass * getattr(fit.law, own) for own in LAW.values()]
    return np.asarray(slopes @ known @ slopes.T, dtype=np.float64)


def _known(balance: Balance, fit: MotionFit, X: Floats) -> Floats:
    """Covariance (k, k) of the numbers whose columns are `X`; what is left over widens it."""
    scale = lengths(X)
    q = np.linalg.pinv((X / scale).T @ (X / scale), rcond=1e-12, hermitian=True) / np.outer(scale, scale)
    if balance.held(fit.choices):
        own = X[:, 1:] / scale[1:]
        q = np.zeros_like(q)
        q[1:, 1:] = np.linalg.pinv(own.T @ own, rcond=1e-12, hermitian=True) / np.outer(scale[1:], scale[1:])
    return np.asarray(q * max(fit.per_reading, 1.0), dtype=np.float64)


def _drawn(balance: Balance, fit: MotionFit, X: Floats, used: int) -> Floats:
    """Draws (draws, k) of the numbers whose columns are `X`: `used` coefficients, then shifts of scanned numbers.

    A mass that is held stays; a shift is endless both ways where nothing moves.
    """
    best = np.concatenate([fit.coefficients, np.zeros(X.shape[1] - used)])
    generator = np.random.default_rng(0)
    # semidefinite but for rounding, whatever the sizes of its entries
    spread = _known(balance, fit, X)
    out = generator.multivariate_normal(
        best, spread, STEER.interval_draws, check_valid="ignore", method="eigh"
    )
    silent = used + np.flatnonzero(~X[:, used:].any(axis=0))
    out[::2, silent], out[1::2, silent] = -np.inf, np.inf
    return out


def _shifted(one: Choice, logs: Floats, grids: Mapping[str, Floats]) -> Floats:
    """Scanned numbers (draws, k) whose logarithms are shifted, within what is tried of them."""
    for i, (name, inside) in enumerate(zip(one.term.scanned, np.abs(one.inside), strict=True)):
        tried = np.append(np.abs(grids[name]), inside)
        # where either sign is tried, so is 0 between them
        least = tried.min() if grids[name].min() > 0 else 1e-9 * tried.max()
        logs[:, i] = np.clip(logs[:, i], *np.log(np.array([least, tried.max()]) / inside))
    return np.asarray(one.inside * np.exp(logs))


def _interval(value: float, drawn: Floats, *, turn: bool = False) -> Interval:
    if turn:  # a phase goes round
        drawn = value + np.mod(drawn - value + np.pi, 2 * np.pi) - np.pi
    low, high = np.percentile(drawn, [2.5, 97.5])
    return Interval(float(value), float(low), float(high))
