"""Forecasts as distributions: many runs of a model, each with friction and a belt of its own from event to event.

What scatters, and by how much, the past says: its windows are fitted with random effects. A run to come begins where
the last window of the past ends, its state and its own friction drawn from what that window leaves open; whenever the
block sticks again, the friction of its next event is drawn, correlated with the last one as the past's events are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated
from stickslip.declared.model import Model
from stickslip.fitted.data import Data
from stickslip.likelihoods.band import MEMBERS, band, standing
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit import fitted
from stickslip.likelihoods.fit_state import Fit, begin, unexplained
from stickslip.likelihoods.memory import KINETIC, MOST, memory
from stickslip.likelihoods.motion import Motion
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.population import factor
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.single_windows import window_posterior
from stickslip.likelihoods.stretches import Stretch, stretches

Floats = NDArray[np.float64]
AHEAD = 2.0  # cycles that members are simulated at once
YIELDS = "contact_compliance"  # under it nothing sticks, and no window begins
FEWEST = 3  # windows of a past that shows scatter


@dataclass(frozen=True)
class Distribution:
    """
    Readings to come.

    Parameters
    ----------
    mean, low, high : (n, channels) expected readings, and the band that holds 95 % of the readings to come
    scatter : relative standard deviation of friction as a whole from event to event
    """

    mean: Floats
    low: Floats
    high: Floats
    scatter: float


def distribution(
    model: Model, run: Data, sensors: Sensors, future: Floats, seed: int = 0
) -> Distribution | None:
    """
    Return the readings that follow a run; None where its windows do not tell.

    Parameters
    ----------
    model : with the phases of this run
    run : the past
    sensors : of the rig
    future : (n,) times after the past's, in its time
    seed : of the draws
    """
    cut = stretches([run])
    if len(cut) < FEWEST or any(isinstance(one, Tabulated) or one.name == YIELDS for one in model.effects):
        return None
    windows = BeltWindows(model, [run], cut, [], Declared(), sensors, POLICY)
    try:
        fit = fitted(begin(windows), POLICY)
    except (FloatingPointError, np.linalg.LinAlgError):
        return None
    # no model of these windows: its scatter is that of something else
    if unexplained(fit) > POLICY.noise_left:
        return None
    last = cut[-1]
    rest = float(np.median([one.rest for one in cut]))
    tail = Stretch(0, last.stop, len(run.t), last.dwell, rest)
    members = _Members(fit, _extended(run, future), np.random.default_rng(seed), rest)
    own = members.begun(_with(windows, [tail], run), fit)
    if own is None:
        return None
    whole = members.run(own, tail)[:, len(run.t) :]
    return _summed(whole, run, fit, members.rng)


def _summed(whole: Floats, run: Data, fit: Fit, rng: np.random.Generator) -> Distribution | None:
    """Mean and band of the members (m, n, channels), noise of the readings included."""
    members = standing(whole)
    if members is None:
        return None
    low, high = band(members, run.noise * np.sqrt(np.maximum(fit.noise, 1.0)), rng)
    return Distribution(members.mean(axis=0), low, high, _scatter(fit))


def _scatter(fit: Fit) -> float:
    """How much friction differs between the events of the past, over that of the model."""
    return float(np.std(fit.random[:, fit.windows.kinetic].mean(axis=1)))


def _extended(run: Data, future: Floats) -> Data:
    """The run with times to come, at which nothing is read."""
    n, c = len(future), run.readings.shape[1]
    pad = np.zeros((n, c))
    return replace(
        run,
        t=np.concatenate([run.t, future]),
        readings=np.concatenate([run.readings, pad]),
        weight=np.concatenate([run.weight, pad]),
        v=np.concatenate([run.v, np.zeros(n)]),
        held=np.concatenate([run.held, np.zeros((n, c), dtype=bool)]),
    )


def _with(windows: BeltWindows, cut: Sequence[Stretch], run: Data) -> BeltWindows:
    """The same windows elsewhere."""
    return BeltWindows(windows.model, [run], cut, [], Declared(), windows.sensors, windows.policy)


class _Members:
    """Members of an ensemble, simulated from stick to stick."""

    def __init__(self, fit: Fit, run: Data, rng: np.random.Generator, rest: float) -> None:
        assert isinstance(fit.windows, BeltWindows)
        self.run_, self.rng, self.rest, self.windows = run, rng, rest, fit.windows
        self.root = factor(fit.population, fit.windows.places)[0]
        found, error = memory(fit, KINETIC)
        # the past tells the correlation poorly: every member has one that may be the true one
        self.memory = np.clip(found + error * rng.standard_normal(MEMBERS), 0.0, MOST)
        # the law is that of other runs: what the events of this one have in common is known from them alone
        count = len(fit.random) * (1 - found) / (1 + found)
        # so few events tell their standard deviation roughly: each member has one that they may come from
        self.wide = np.sqrt(len(fit.random) / self.rng.chisquare(len(fit.random), MEMBERS))
        spread = self.wide[:, None] * (self.rng.standard_normal((MEMBERS, self.root.shape[1])) @ self.root.T)
        self.mean = fit.random.mean(axis=0) + spread / math.sqrt(max(count, 1.0))
        self.ahead = int(AHEAD * run.cycle / float(np.median(np.diff(run.t)))) + 2

    def begun(self, windows: BeltWindows, fit: Fit) -> Floats | None:
        """Numbers of the last window of the past, (members, own), drawn from what it leaves open."""
        base = begin(windows)
        mean = base.own[0].copy()
        common = fit.random.mean(axis=0)
        mean[windows.begins :] = common + float(self.memory.mean()) * (fit.random[-1] - common)
        found = window_posterior(
            replace(base, population=fit.population, noise=fit.noise, own=mean[None]), POLICY
        )
        if found is None:
            return None
        own, covariance = found
        size, turn = np.linalg.eigh(covariance)
        root = turn * np.sqrt(np.maximum(size, 0.0))
        return np.asarray(own + self.rng.standard_normal((MEMBERS, len(own))) @ root.T)

    def run(self, own: Floats, tail: Stretch) -> Floats:
        """Return the readings of all members over the whole run, (members, n, channels); NaN before and where lost."""
        n, channels = len(self.run_.t), self.run_.readings.shape[1]
        out = np.full((MEMBERS, n, channels), np.nan)
        own, at = own.copy(), [tail] * MEMBERS
        going = np.ones(MEMBERS, dtype=bool)
        first = tail.stop - tail.start + self.ahead
        while going.any():
            who = np.flatnonzero(going)
            cut = [
                replace(at[k], stop=min(at[k].start + (first if at[k] is tail else self.ahead), n))
                for k in who
            ]
            motions = self._simulated(cut, own[who])
            slow = [
                i
                for i, (one, m) in enumerate(zip(cut, motions, strict=True))
                if m is not None and one.stop < n and _stuck_again(m) is None
            ]
            if slow:  # no stick so soon
                longer = [replace(cut[i], stop=n) for i in slow]
                for i, one, m in zip(slow, longer, self._simulated(longer, own[who[slow]]), strict=True):
                    cut[i], motions[i] = one, m
            for k, one, m in zip(who.tolist(), cut, motions, strict=True):
                going[k] = self._kept(out[k], k, one, m, own, at)
        return out

    def _simulated(self, cut: Sequence[Stretch], own: Floats) -> list[Motion | None]:
        return _with(self.windows, cut, self.run_).motions(np.zeros(0), own)

    def _kept(
        self, out: Floats, k: int, one: Stretch, motion: Motion | None, own: Floats, at: list[Stretch]
    ) -> bool:
        """Keep what was simulated up to the next stick; whether there is more to come."""
        if motion is None:
            return False
        again = _stuck_again(motion)
        end = len(motion.t) if again is None else again
        out[one.start : one.start + end] = motion.readings[:end]
        if again is None or one.start + again >= len(self.run_.t):
            return False
        begins, state = self.windows.begins, motion.state[again]
        own[k, :begins] = state[list(self.windows.sensors.begins)]
        fresh = self.wide[k] * (self.root @ self.rng.standard_normal(self.root.shape[1]))
        apart = own[k, begins:] - self.mean[k]
        like = float(self.memory[k])
        own[k, begins:] = self.mean[k] + like * apart + math.sqrt(1 - like**2) * fresh
        at[k] = Stretch(0, one.start + again, len(self.run_.t), 0.0, self.rest)
        return True


def _stuck_again(motion: Motion) -> int | None:
    """The first sample of the stick that follows a slip, so later than the first of all."""
    slips = np.flatnonzero(motion.mode != 0)
    if not len(slips):
        return None
    stuck = np.flatnonzero(motion.mode[slips[0] :] == 0)
    return int(slips[0] + stuck[0]) if len(stuck) else None
