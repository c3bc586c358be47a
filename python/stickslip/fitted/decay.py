"""The hyperbolic law slip by slip: each has its own levels, all share one decay, which is profiled.

A slip says little of the decay by itself. It is held at one value for all of them, the slips are fitted under it,
and the value under which they fit best is sought.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.errors import StickslipError
from stickslip.fitted.scatter import effective_readings
from stickslip.fitted.shooting import Shot, Simulator, shoot
from stickslip.measured.fit_window import Array, FitWindow

REFINEMENTS = 10  # of the profile of the decay: its points are a factor 4 apart, then 2, 1.4, .. 1.001
WIDER = 3  # times that its range is widened where it is lowest at an end
CURVED = 2.0  # -2 log likelihood between neighbouring points; below it chance decides


@dataclass(frozen=True)
class Profile:
    """Hyperbolic fits of every slip at several common decays: (g,), g shots, and scores (g, k)."""

    decays: Array
    shots: list[Shot]
    scores: Array

    def joined(self, at: int, decay: float, shot: Shot, coulomb: Shot) -> Profile:
        """The profile with one more decay, as its number `at`."""
        return Profile(
            np.insert(self.decays, at, decay),
            [*self.shots[:at], shot, *self.shots[at:]],
            np.insert(self.scores, at, scores_of(shot, coulomb), axis=0),
        )

    def lowest(self, total: Array) -> int:
        """Index of the least total score that has a neighbour on either side."""
        return int(np.clip(np.argmin(total), 1, len(total) - 2))

    def best(self, weights: Array) -> float:
        """Decay of least total score, by a parabola in log decay through the three lowest."""
        total = self.scores @ weights
        i = self.lowest(total)
        a, b, _ = np.polyfit(np.log(self.decays[i - 1 : i + 2]), total[i - 1 : i + 2], 2)
        at = float(np.exp(-b / (2 * a))) if a > 0 else float(self.decays[np.argmin(total)])
        return float(np.clip(at, self.decays[i - 1], self.decays[i + 1]))

    def refit(self, weights: Array) -> Array:
        """Mean numbers of the slips, each counted as often as `weights` (k,) says, and the decay that suits best."""
        decay = self.best(weights)
        means = np.array([weights @ levels(shot) / weights.sum() for shot in self.shots])
        near = [np.interp(np.log(decay), np.log(self.decays), column) for column in means.T]
        return np.array([*near, decay])


def hyperbolic(
    speed: float,
    coulomb: Shot,
    rig: BlockOnBelt,
    noise: Array,
    simulator: Simulator,
    tell: Callable[[str, float], None],
) -> tuple[Shot, float, Profile]:
    """Each slip with its own R(0) and level at speed under a common decay, which is profiled."""

    def fitted(decay: float, near: Sequence[Shot] = ()) -> Shot:
        return _fitted(decay, coulomb, rig, noise, simulator, near)

    return profiled(speed, coulomb, fitted, tell)


class FittedDecay(Protocol):
    """All slips under one decay, started from fits under decays near it."""

    def __call__(self, decay: float, near: Sequence[Shot] = ()) -> Shot:
        """All slips fitted."""


def profiled(
    speed: float, coulomb: Shot, fitted: FittedDecay, tell: Callable[[str, float], None]
) -> tuple[Shot, float, Profile]:
    """The decay that slips `fitted` under it say most of, and its profile.

    `speed` is that of a typical slip. The profile is widened until it rises on both sides, and refined where it is
    lowest, until a parabola through three of its points errs by less than chance.
    """
    decays = np.array([0.1, 0.4, 1.5, 6.0, 24.0]) / speed
    shots = []
    for i, decay in enumerate(decays):
        tell("hyperbolic law", 0.5 + 0.04 * i)
        shots.append(fitted(decay))
    profile = Profile(decays, shots, np.array([scores_of(s, coulomb) for s in shots]))
    for _ in range(WIDER):
        at = int(np.argmin(profile.scores.sum(axis=1)))
        if 0 < at < len(profile.decays) - 1:
            break
        place, decay = (0, profile.decays[0] / 4) if at == 0 else (at + 1, profile.decays[-1] * 4)
        profile = profile.joined(place, decay, fitted(decay), coulomb)
    for level in range(REFINEMENTS):
        total = profile.scores.sum(axis=1)
        i = profile.lowest(total)
        if total[i - 1] + total[i + 1] - 2 * total[i] < CURVED:
            break
        tell("hyperbolic law", 0.7 + 0.02 * level)
        for at in (i + 1, i):  # the later gap first: it does not move the earlier
            decay = float(np.sqrt(profile.decays[at - 1] * profile.decays[at]))
            shot = fitted(decay, profile.shots[at - 1 : at + 1])
            profile = profile.joined(at, decay, shot, coulomb)
    decay = profile.best(np.ones(len(coulomb.windows)))
    near = profile.shots[profile.lowest(profile.scores.sum(axis=1))]
    return fitted(decay, [near]), decay, profile


def _fitted(
    decay: float,
    coulomb: Shot,
    rig: BlockOnBelt,
    noise: Array,
    simulator: Simulator,
    near: Sequence[Shot] = (),
) -> Shot:
    """All slips under one decay, each started from where it fitted best under a decay `near` it."""
    model = Model(rig, friction=HyperbolicFriction(decay=decay))
    shots = []
    for i, (w, r, std) in enumerate(zip(coulomb.windows, coulomb.residuals, coulomb.local_std, strict=True)):
        start = _begun(w, decay)
        if near:
            fits = [float(np.sum(one.residuals[i] ** 2)) for one in near]
            start = near[int(np.argmin(fits))].windows[i]
        try:
            shot = shoot(model, [start], (), noise=noise, simulator=simulator, iterations=15)
        except StickslipError:
            none = np.zeros((0, 0))
            shot = Shot((), np.zeros(0), none, none, [start], [std], [3 * r], np.inf, 1, np.zeros(0))
        shots.append(shot)
    return merged(shots)


def levels(shot: Shot) -> Array:
    """Each slip's own numbers, (k, p)."""
    return np.array([list(w.local.values()) for w in shot.windows])


def _begun(w: FitWindow, decay: float) -> FitWindow:
    """A slip's start under the hyperbolic law from its Coulomb levels."""
    static, kinetic = w.local["static"], w.local["kinetic"]
    u = 0.05 * float(np.nanmax(np.abs(np.diff(w.readings[:, 0])))) / float(np.median(np.diff(w.t)))
    drop = min((static - kinetic) * (1 + 1 / max(decay * u, 1e-3)), 0.9 * static)
    return replace(w, local={"scale": drop, "constant": static - drop})


def scores_of(shot: Shot, reference: Shot) -> Array:
    """-2 log likelihood of each slip, its noise level unknown, on the reference's number of readings."""
    effective = np.array([effective_readings([r]) for r in reference.residuals])
    chi2 = np.array([float(np.sum(r**2)) for r in shot.residuals])
    return np.asarray(effective * np.log(np.maximum(chi2, 1e-300)), dtype=float)


def merged(shots: Sequence[Shot]) -> Shot:
    """Fits of single slips as one, without anything in common."""
    empty = np.zeros((0, 0))
    return Shot(
        names=(),
        values=np.zeros(0),
        covariance=empty,
        sandwich=empty,
        windows=[w for s in shots for w in s.windows],
        local_std=[d for s in shots for d in s.local_std],
        residuals=[r for s in shots for r in s.residuals],
        chi2=float(sum(s.chi2 for s in shots)),
        dof=sum(s.dof for s in shots),
        prior_share=np.zeros(0),
    )
