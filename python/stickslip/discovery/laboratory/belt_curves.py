"""Curves that no name explains: a force, a factor of friction or of the belt's speed, or a reading, of one variable.

While the block slips, a force on it is a change of friction: the windows have columns of that at every place of the
slip, where the static limit follows, so that a curve of anything costs no simulation. So they have of the belt's speed.
A force on the angle body is seen through that body alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.laboratory.learned import Factors, Learned
from stickslip.discovery.workers import ALONE, Workers
from stickslip.fitted.data import Data
from stickslip.likelihoods import belt_waves
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.motion import Motion
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.score import Columns, score
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.stretches import Stretch
from stickslip.simulated import states

Floats = NDArray[np.float64]
FEWEST = 3  # samples of a slip that a curve can be read along


@dataclass(frozen=True)
class _Shaped:
    """
    A curve's shapes: where, of what, its knots, columns by shape, and what they add to random effects where it does.

    `unit` is how large 1 of a random effect is there, infinite where it adds to none.
    """

    where: str
    variable: str
    grid: Floats
    columns: Columns
    factors: Factors | None = None
    unit: float = math.inf


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


def learned(bench: _OnBelt, fit: Fit, workers: Workers = ALONE) -> list[Learned]:
    """Return every curve beside a hypothesis, best first; the workers score them."""
    motions = fit.windows.motions(fit.at, fit.own)
    every = [_levelled(bench, motions, one) for one in _every(bench, fit, motions)]
    return sorted(workers.map(partial(_scored, fit, bench.policy), every), key=lambda one: -one.gain)


def _levelled(bench: _OnBelt, motions: list[Motion | None], one: _Shaped) -> tuple[_Shaped, Floats]:
    """A curve, and which combinations of its shapes are its own."""
    # friction as a whole is the law's, and so is a constant force or reading while all slip one way; speeds that are
    # all off are the set-points'
    if one.where in ("contact", "belt") or bench.one_way:
        return one, scipy.linalg.null_space(_mean(motions, one.variable, one.grid)[None])
    return one, np.eye(bench.policy.curve_shapes)


def _scored(fit: Fit, policy: Policy, levelled: tuple[_Shaped, Floats]) -> Learned:
    one, free = levelled
    reduced = [None if c is None else c @ free for c in one.columns]
    # a curve is as good as a spring: with a mass that is free to follow, all forces would shrink, scatter too
    # what is all but free beside the law's level, as a load is, is known as well as that level before the runs
    found = score(fit, reduced, policy, tight=True, precision=(policy.law_spread * one.unit) ** -2)
    std = np.sqrt(np.abs(np.einsum("ki,ij,kj->k", free, found.covariance, free)))
    value, count = free @ found.size, free.shape[1]
    events = None
    if one.factors is not None:
        events = [None if each is None else each @ value for each in one.factors]
    return Learned(
        one.where, one.variable, found.gain, one.grid, value, std, count, reduced, found.size, events
    )


def _every(bench: _OnBelt, fit: Fit, motions: list[Motion | None]) -> Iterator[_Shaped]:
    two, units = bench.two_degree, {"contact": 1.0, "block": max(bench.model.friction.static_limits)}
    names = ("x1", "x2", "y1", "y2", "t") if two else ("x1", "x2", "t")
    for variable in names:
        grid = _grid(motions, variable, bench.policy.curve_shapes)
        for where in ("contact", "block"):
            if (where, variable) == ("contact", "x1"):
                continue  # a slip goes one way: such a factor is a force on the block in x1, if it is no field
            factors = _factors(bench, fit, motions, where, variable, grid)
            shown = "v_w" if (where, variable) == ("contact", "x2") else variable
            yield _Shaped(where, shown, grid, _of_events(fit, factors), factors, units[where])
        if variable == "t":
            factors = _speeds(fit, motions, grid)
            yield _Shaped("belt", variable, grid, _of_events(fit, factors), factors, 1.0)
        for channel, place in enumerate(bench.sensors.places):
            yield _Shaped(place, variable, grid, _of_reading(bench, fit, motions, channel, variable, grid))
        if two:
            yield _Shaped("angle_body", variable, grid, _of_angle(bench, fit, motions, variable, grid))


def _at(motion: Motion, variable: str) -> Floats:
    return motion.t if variable == "t" else motion.state[:, states.AT[variable]]


def _grid(motions: list[Motion | None], variable: str, count: int) -> Floats:
    """Places of a curve's knots: where slips pass often there are many, and none is far from the next."""
    every = np.concatenate([_at(one, variable)[one.mode != 0] for one in motions if one is not None])
    low, high = np.quantile(every, [0.002, 0.998])
    often = np.quantile(every, np.linspace(0.002, 0.998, count))
    return np.asarray(0.5 * (often + np.linspace(low, high, count)))


def _mean(motions: list[Motion | None], variable: str, grid: Floats) -> Floats:
    """Mean of each shape over all slips, (k,)."""
    of = "x2" if variable == "v_w" else variable
    slips = np.concatenate([_at(one, of)[one.mode != 0] for one in motions if one is not None])
    return np.asarray(shapes(grid, slips).mean(axis=0))


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


def _speeds(fit: Fit, motions: list[Motion | None], grid: Floats) -> Factors:
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


def _factors(
    bench: _OnBelt, fit: Fit, motions: list[Motion | None], where: str, variable: str, grid: Floats
) -> Factors:
    """What each shape adds to a window's random effects: friction at the places of its curve, over the law's."""
    assert isinstance(fit.windows, BeltWindows)
    law = bench.model.friction
    out: list[Floats | None] = []
    for s, motion in zip(bench.stretches, motions, strict=True):
        if motion is None:
            out.append(None)
            continue
        factor, belt_speed = np.zeros((fit.windows.effects, len(grid))), bench.data[s.run].belt_speed
        out.append(factor)
        at = _along_slip(motion, fit.windows.knots[s.run], variable, belt_speed)
        if at is None:
            continue
        values, speed = at
        slip = factor[fit.windows.kinetic]
        slip[:] = shapes(grid, values)
        if where == "block":
            slip /= -(np.sign(speed) * np.maximum(law.magnitude(speed), 1e-6))[:, None]
    return out


def _along_slip(
    motion: Motion, knots: Floats, variable: str, belt_speed: float
) -> tuple[Floats, Floats] | None:
    """What a variable and v_w are where the slip passes the places of the friction curve."""
    slips = np.flatnonzero(motion.mode != 0)
    if len(slips) < FEWEST:
        return None
    x, order = np.unique(motion.state[slips, 0], return_index=True)
    if len(x) < FEWEST:
        return None
    values = np.interp(knots, x, _at(motion, variable)[slips][order])
    speed = np.interp(knots, x, (motion.state[:, 1] - belt_speed)[slips][order])
    return values, np.where(speed == 0, -np.sign(belt_speed) * 1e-9, speed)


def _of_reading(
    bench: _OnBelt, fit: Fit, motions: list[Motion | None], channel: int, variable: str, grid: Floats
) -> Columns:
    """Columns of what is added to a reading."""
    out: list[Floats | None] = []
    for s, block, motion in zip(bench.stretches, fit.blocks, motions, strict=True):
        if block is None or motion is None:
            out.append(None)
            continue
        made = np.zeros((*block.shape[:2], len(grid)))
        weight = bench.data[s.run].weight[s.start : s.stop, channel]
        made[:, channel] = shapes(grid, _at(motion, variable)) * weight[:, None]
        out.append(made)
    return out


def _of_angle(bench: _OnBelt, fit: Fit, motions: list[Motion | None], variable: str, grid: Floats) -> Columns:
    """Columns of a force on the angle body, seen through that body alone."""
    values = fit.values()
    out: list[Floats | None] = []
    for s, block, motion in zip(bench.stretches, fit.blocks, motions, strict=True):
        if block is None or motion is None:
            out.append(None)
            continue
        made = np.zeros((*block.shape[:2], len(grid)))
        force = shapes(grid, _at(motion, variable))
        weight = bench.data[s.run].weight[s.start : s.stop, 1]
        made[:, 1] = belt_waves.pushed(force, float(np.median(np.diff(motion.t))), values) * weight[:, None]
        out.append(made)
    return out
