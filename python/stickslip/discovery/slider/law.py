"""The law of the mean event beside what was found: its numbers, and their covariance with the effects' own in it.

The two levels of every event are read through the effects: a gain that is 1 % larger makes both 1 % smaller. What is
doubtful of an effect is doubtful of the law: its joint covariance goes through the slopes of the levels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Effect, effect
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.discovery.result import Interval
from stickslip.discovery.slider.candidates import candidates
from stickslip.discovery.slider.choose import Choice
from stickslip.discovery.slider.held import constants_of
from stickslip.discovery.slider.numbers import Z, parameters
from stickslip.discovery.slider.weigh import Weighed, columns_of, weigh
from stickslip.fitted.block_events.cycle import S
from stickslip.fitted.block_events.levels import carried, number_of, sliding
from stickslip.fitted.block_events.sensor import reading_of
from stickslip.fitted.block_events.table import Measured
from stickslip.fitted.scatter import block_bootstrap

Floats = NDArray[np.float64]
Law = Mapping[str, Interval]


def terms(chosen: Sequence[Weighed], choice: Choice) -> tuple[Effect, ...]:
    """What was chosen as effects of a model."""
    return tuple(
        effect(
            one.candidate.name,
            **{name: number.value for name, number in parameters(one, choice).items()},
        )
        for one in chosen
    )


def law_beside(
    chosen: Sequence[Weighed], choice: Choice, runs: Sequence[Measured]
) -> tuple[CoulombFriction, Law]:
    """Mean static and kinetic force beside what was chosen, every run counting alike, and their intervals."""
    levels = _levels(chosen, choice, runs)
    means = np.array([one.mean(axis=0) for one in levels])
    own = np.array([np.atleast_2d(np.cov(block_bootstrap(one).T)) for one in levels])
    between = np.cov(means.T) if len(means) > 1 else np.zeros((2, 2))
    covariance = (between + own.mean(axis=0)) / len(means) + _of_effects(chosen, choice, runs)
    static, kinetic = means.mean(axis=0)
    names = ("static", "kinetic") if runs[0].run.sign > 0 else ("static_plus", "kinetic_plus")
    values, std = (float(static), float(min(kinetic, static))), np.sqrt(np.diag(covariance))
    law = {
        name: Interval(value, value - Z * float(s), value + Z * float(s))
        for name, value, s in zip(names, values, std, strict=True)
    }
    return CoulombFriction(static=values[0], kinetic=max(values[1], 0.0)), law


def _levels(chosen: Sequence[Weighed], choice: Choice, runs: Sequence[Measured]) -> list[Floats]:
    """Static and kinetic force of every event (k, 2), by runs that have some."""
    bare = CoulombFriction()
    model = Model(choice.declared.rig, friction=bare, effects=terms(chosen, choice))
    reading = reading_of(model, choice.declared.force_channel)
    growth, tau = (number_of(model, "static_aging", key) for key in ("dT", "tau"))
    out = []
    for one in (run for run in runs if len(run.events)):
        e, speed = one.events, one.run.belt_speed
        top, bottom = (reading.bend.undone(x, e.t) for x in (e.p[:, S], e.arrest))
        grown = growth * (1 - np.exp(-e.dwell / tau)) if growth else 0.0
        slid = sliding(model, top, bottom, speed, constants_of(model, one).log_w2)
        out.append(np.column_stack([carried(model, top, speed) - grown, slid]))
    return out


def _mean(chosen: Sequence[Weighed], choice: Choice, runs: Sequence[Measured]) -> Floats:
    return np.asarray(np.mean([one.mean(axis=0) for one in _levels(chosen, choice, runs)], axis=0))


def _of_effects(chosen: Sequence[Weighed], choice: Choice, runs: Sequence[Measured]) -> Floats:
    """Covariance (2, 2) that the law has of the effects beside it: of their sizes, and of the scales they have.

    Waves are left out: the levels are means over many of them.
    """
    steady = [i for i, one in enumerate(chosen) if not one.candidate.per_run]
    if not steady:
        return np.zeros((2, 2))
    joint = _joint([chosen[i] for i in steady], choice, chosen)
    slopes = []
    for i, size in zip(steady, np.sqrt(np.diag(joint)), strict=True):
        theta = float(chosen[i].theta[0])
        # an effect of one sign goes down to nothing, not beyond
        low = max(theta - size, 0.0) if chosen[i].candidate.sign and theta >= 0 else theta - size
        up, down = (_mean(_moved(chosen, i, at), choice, runs) for at in (theta + size, low))
        slopes.append((up - down) / (theta + size - low))
    J = np.array(slopes).T
    return np.asarray(J @ joint @ J.T, dtype=np.float64) + sum(
        (_of_scale(chosen, i, choice, runs) for i in steady), np.zeros((2, 2))
    )


def _moved(chosen: Sequence[Weighed], i: int, theta: float) -> list[Weighed]:
    return [*chosen[:i], replace(chosen[i], theta=np.array([theta])), *chosen[i + 1 :]]


def _joint(steady: Sequence[Weighed], choice: Choice, chosen: Sequence[Weighed]) -> Floats:
    """Joint covariance of the sizes of effects of one number each: their own variances, correlated by the design."""
    waves = [one.candidate for one in chosen if one.candidate.per_run]
    X = columns_of(choice.white, [*(one.candidate for one in steady), *waves])
    scale = np.linalg.norm(X, axis=0)
    scale[scale == 0] = 1.0
    C = np.linalg.pinv((X / scale).T @ (X / scale), hermitian=True)[: len(steady), : len(steady)]
    own = np.sqrt([float(one.covariance[0, 0]) for one in steady])
    root = np.sqrt(np.diag(C))
    return np.asarray(C / np.outer(root, root) * np.outer(own, own), dtype=np.float64)


def _of_scale(chosen: Sequence[Weighed], i: int, choice: Choice, runs: Sequence[Measured]) -> Floats:
    """What the law would be at the other scales that were tried of an effect, each as likely as its gain says."""
    one = chosen[i]
    if not one.candidate.searched:
        return np.zeros((2, 2))
    others = columns_of(choice.white, [w.candidate for w in chosen if w is not one])
    same = [c for c in candidates(choice.blocks, choice.declared) if c.name == one.candidate.name]
    found = [w for c in same if (w := weigh(choice.white, c, others)) is not None]
    if len(found) < 2:
        return np.zeros((2, 2))
    weight = np.exp(0.5 * np.array([w.gain for w in found]) - 0.5 * max(w.gain for w in found))
    laws = np.array([_mean([*chosen[:i], w, *chosen[i + 1 :]], choice, runs) for w in found])
    off = laws - weight @ laws / weight.sum()
    return np.asarray((off.T * weight) @ off / weight.sum(), dtype=np.float64)
