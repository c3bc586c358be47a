"""Curves that no name explains: a force, a factor of friction or of the belt's speed, or a reading, of one variable.

All but that of the belt have the columns of a model that has such a curve, of no size. That of the belt has those of
what it adds to each window's own belt.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated, tabulated
from stickslip.declared.model import Model
from stickslip.discovery.laboratory.curve_term import curve_term
from stickslip.discovery.laboratory.hypothesis import Term
from stickslip.discovery.laboratory.learned import Factors, ScoredCurve
from stickslip.discovery.workers import ALONE, Workers
from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.motion import WindowMotion
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.score import Columns, score
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.stretches import Stretch
from stickslip.simulated import states

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Shaped:
    """
    A curve's shapes: where, of what, its knots, columns by shape, and what it is in the model where it is in it.

    `width` is the standard deviation of its values before the readings; `factors` are what its shapes add to
    random effects.
    """

    where: str
    variable: str
    grid: Floats
    columns: Columns
    width: float = math.inf
    effect: Tabulated | None = None
    factors: Factors | None = None


class _OnBelt(Protocol):
    """What curves ask of a bench of a rig on a belt."""

    @property
    def model(self) -> Model: ...
    @property
    def data(self) -> Sequence[Data]: ...
    @property
    def stretches(self) -> Sequence[Stretch]: ...
    @property
    def sensors(self) -> Sensors: ...
    @property
    def policy(self) -> Policy: ...
    @property
    def one_way(self) -> bool: ...
    @property
    def two_degree(self) -> bool: ...
    def windows(self, terms: Sequence[Term] = ()) -> BeltWindows: ...


def learned(
    bench: _OnBelt, fit: Fit, terms: Sequence[Term] = (), workers: Workers = ALONE
) -> list[ScoredCurve]:
    """Return every curve beside a hypothesis, best first; the workers score them."""
    motions = fit.windows.motions(fit.at, fit.own)
    every = workers.map(partial(_scored, bench, fit, terms, motions), _asked(bench))
    return sorted((one for one in every if one is not None), key=lambda one: -one.gain)


def _asked(bench: _OnBelt) -> list[tuple[str, str]]:
    """Where curves are, and what they are of."""
    out = []
    for variable in ("x1", "x2", "y1", "y2", "t") if bench.two_degree else ("x1", "x2", "t"):
        # a slip goes one way: a factor of friction in x1 is a force on the block in x1, if it is no field
        out += [("contact", "v_w" if variable == "x2" else variable)] if variable != "x1" else []
        out += [("block", variable)]
        out += [("angle_body", variable)] if bench.two_degree else []
        out += [("belt", variable)] if variable == "t" else []
        out += [(place, variable) for place in bench.sensors.places]
    return out


def _levelled(bench: _OnBelt, motions: list[WindowMotion | None], one: _Shaped) -> Floats:
    """Which combinations of a curve's shapes are its own."""
    # friction as a whole is the law's, and so is a constant force on the block while all slip one way, and what of a
    # reading no angle body shows; speeds that are all off are the set-points'
    if one.where in ("contact", "belt") or (bench.one_way and (one.where == "block" or not bench.two_degree)):
        return scipy.linalg.null_space(_mean(bench, motions, one.variable, one.grid)[None])
    return np.eye(len(one.grid))


def _scored(
    bench: _OnBelt,
    fit: Fit,
    terms: Sequence[Term],
    motions: list[WindowMotion | None],
    asked: tuple[str, str],
) -> ScoredCurve | None:
    """A curve; None where no window can be simulated with it."""
    one = _shaped(bench, fit, terms, motions, *asked)
    if all(each is None for each in one.columns):
        return None
    free = _levelled(bench, motions, one)
    reduced = [None if c is None else c @ free for c in one.columns]
    # a curve is as good as a spring: with a mass that is free to follow, all forces would shrink, scatter too
    # what is all but free beside the law's level, as a load is, is known as well as that level before the runs
    found = score(fit, reduced, bench.policy, tight=True, precision=one.width**-2)
    std = np.sqrt(np.abs(np.einsum("ki,ij,kj->k", free, found.covariance, free)))
    value = free @ found.size
    events = None if one.factors is None else [None if each is None else each @ value for each in one.factors]
    effect = one.effect and one.effect.replace(
        **{name: float(x) for name, x in zip(one.effect.parameters, value, strict=True)}
    )
    return ScoredCurve(
        one.where,
        one.variable,
        found.gain,
        one.grid,
        value,
        std,
        free.shape[1],
        reduced,
        free=free,
        effect=effect,
        width=one.width,
        events=events,
    )


def _shaped(
    bench: _OnBelt,
    fit: Fit,
    terms: Sequence[Term],
    motions: list[WindowMotion | None],
    where: str,
    variable: str,
) -> _Shaped:
    grid = _grid(bench, motions, variable, bench.policy.curve_shapes)
    if where == "belt":
        factors, width = _speeds(fit, motions, grid), bench.policy.law_spread
        return _Shaped(where, variable, grid, _of_events(fit, factors), width, factors=factors)
    units = {"contact": 1.0, "block": max(bench.model.friction.static_limits)}
    width = bench.policy.law_spread * units.get(where, math.inf)
    curve = tabulated(where, variable, grid, np.zeros(len(grid)))
    windows = bench.windows((*terms, curve_term(curve, width)))
    p, k = len(fit.at), len(grid)
    columns = windows.columns(np.concatenate([fit.at, np.zeros(k)]), fit.own, range(p, p + k))
    return _Shaped(where, variable, grid, columns, width, curve)


def _at(bench: _OnBelt, run: int, motion: WindowMotion, variable: str) -> Floats:
    """What a curve is of, along a motion."""
    if variable == "t":
        return motion.t
    if variable == "v_w":
        return np.asarray(motion.state[:, states.X2] - bench.data[run].belt_speed)
    return motion.state[:, states.AT[variable]]


def _slips(bench: _OnBelt, motions: list[WindowMotion | None], variable: str) -> Floats:
    """The same of all slips."""
    every = zip(bench.stretches, motions, strict=True)
    return np.concatenate([_at(bench, s.run, m, variable)[m.mode != 0] for s, m in every if m is not None])


def _grid(bench: _OnBelt, motions: list[WindowMotion | None], variable: str, count: int) -> Floats:
    """Places of a curve's knots: where slips pass often there are many, and none is far from the next."""
    every = _slips(bench, motions, variable)
    low, high = np.quantile(every, [0.002, 0.998])
    often = np.quantile(every, np.linspace(0.002, 0.998, count))
    return np.asarray(0.5 * (often + np.linspace(low, high, count)))


def _mean(bench: _OnBelt, motions: list[WindowMotion | None], variable: str, grid: Floats) -> Floats:
    """Mean of each shape over all slips, (k,)."""
    return np.asarray(shapes(grid, _slips(bench, motions, variable)).mean(axis=0))


def shapes(grid: Floats, x: Floats) -> Floats:
    """Return the cardinal natural splines of a grid, held constant outside, (n, k)."""
    spline = scipy.interpolate.CubicSpline(grid, np.eye(len(grid)), bc_type="natural")
    return np.asarray(spline(np.clip(x, grid[0], grid[-1])))


def _of_events(fit: Fit, factors: Factors) -> Columns:
    """Columns of what a curve adds to the windows' random effects, through theirs."""
    first = len(fit.at) + fit.windows.begins
    return [
        None if block is None or factor is None else block[:, :, first : first + len(factor)] @ factor
        for block, factor in zip(fit.blocks, factors, strict=True)
    ]


def _speeds(fit: Fit, motions: list[WindowMotion | None], grid: Floats) -> Factors:
    """A window's belt speed, its line and its mean, over the set-point by each shape of a curve in t."""
    out: list[Floats | None] = []
    for motion in motions:
        if motion is None:
            out.append(None)
            continue
        factor = np.zeros((fit.windows.effects, len(grid)))
        line = factor[fit.windows.kinetic.stop : -1]
        line[:] = shapes(grid, np.linspace(motion.t[0], motion.t[-1], len(line)))
        factor[-1] = line.mean(axis=0)
        line -= factor[-1]
        out.append(factor)
    return out
