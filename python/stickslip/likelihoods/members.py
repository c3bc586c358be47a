"""Members of an ensemble of runs to come, simulated from stick to stick, each event with friction of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.fit_state import begin
from stickslip.likelihoods.motion import WindowMotion
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.population import Population
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.single_windows import window_posterior
from stickslip.likelihoods.stretches import Stretch
from stickslip.likelihoods.symmetric_root import symmetric_root
from stickslip.simulated.states import BELT, COUNT, DWELL, LAGGED, X1, W, Z

Floats = NDArray[np.float64]
HIDING = [W, Z, BELT, LAGGED, DWELL]  # states that no event begins anew
AHEAD = 2.0  # cycles that members are simulated at once


@dataclass(frozen=True)
class ComingEvents:
    """
    What is known of the events to come, for each of m members.

    Parameters
    ----------
    root : (effects, white) factor of the covariance of their random effects
    memory : (m, effects) correlation with the event before
    mean : (m, effects) what they have in common
    wide : (m,) factor of their standard deviations
    mean_only : how many of the members, the first ones, have no friction of their own
    ahead : (m,) by how much x1 is ahead of the model where the next event begins, beside friction; None for nothing
    """

    root: Floats
    memory: Floats
    mean: Floats
    wide: Floats
    mean_only: int = 0
    ahead: Floats | None = None

    def next(self, k: int, last: Floats, rng: np.random.Generator) -> Floats:
        """Return the random effects of member k's next event, after those of its last."""
        like = self.memory[k]
        drawn = np.sqrt(1 - like**2) * self.wide[k] if k >= self.mean_only else 0.0
        fresh = self.root @ rng.standard_normal(self.root.shape[1])
        return np.asarray(self.mean[k] + like * (last - self.mean[k]) + drawn * fresh)


@dataclass(frozen=True)
class Flown:
    """
    Members as simulated over the n samples from a window's start on; NaN where a member is lost.

    Parameters
    ----------
    readings : (m, n, channels)
    state, mode : (kept, n, 9), (kept, n) of the first members
    """

    readings: Floats
    state: Floats
    mode: NDArray[np.int8]


class Members:
    """
    Members of an ensemble.

    Parameters
    ----------
    windows : of the run, for its model and its sensors
    at : (p,) coordinates of the windows' shared numbers
    run : the run, at least as long as what is to come
    events : what is known of those to come
    rest : how long a stick lasts
    rng : draws
    """

    def __init__(
        self,
        windows: BeltWindows,
        at: Floats,
        run: Data,
        events: ComingEvents,
        rest: float,
        rng: np.random.Generator,
    ) -> None:
        self.windows, self.at, self.data, self.events = windows, at, run, events
        self.rest, self.rng, self.count = rest, rng, len(events.memory)
        self.ahead = int(AHEAD * run.cycle / float(np.median(np.diff(run.t)))) + 2

    def begun(self, tail: Stretch, population: Population, noise: Floats, expected: Floats) -> Floats | None:
        """
        Return the own numbers of the window that the forecast begins in, (m, own), drawn from what it leaves open.

        Parameters
        ----------
        tail : that window, up to the last reading that is known
        population, noise : what scatters
        expected : (effects,) its random effects as the windows before let expect
        """
        base = begin(with_windows(self.windows, [tail], self.data))
        mean = base.own[0].copy()
        mean[self.windows.begins :] = expected
        found = window_posterior(
            replace(base, at=self.at, population=population, noise=noise, own=mean[None]), POLICY
        )
        if found is None:
            return None
        own, covariance = found
        drawn = self.rng.standard_normal((self.count, len(own))) @ symmetric_root(covariance)
        out = np.asarray(own + drawn)
        out[: self.events.mean_only] = own
        return out

    def run(self, own: Floats, tail: Stretch, end: int, kept: int = 0) -> Flown:
        """
        Return the members from a window's start to the sample `end`.

        Parameters
        ----------
        own : (m, own) numbers of the window
        tail : the window, up to where what is to come begins
        end : the sample behind the last
        kept : how many members' states are kept
        """
        n, channels = end - tail.start, self.data.readings.shape[1]
        out = Flown(
            np.full((self.count, n, channels), np.nan),
            np.full((kept, n, 9), np.nan),
            np.zeros((kept, n), dtype=np.int8),
        )
        own, at = own.copy(), [tail] * self.count
        onward = np.full((self.count, COUNT), np.nan)
        going = np.ones(self.count, dtype=bool)
        first = tail.stop - tail.start + self.ahead
        while going.any():
            who = np.flatnonzero(going)
            cut = [
                replace(at[k], stop=min(at[k].start + (first if at[k] is tail else self.ahead), end))
                for k in who
            ]
            motions = self._simulated(cut, own[who], onward[who])
            slow = [
                i
                for i, (one, m) in enumerate(zip(cut, motions, strict=True))
                if m is not None and one.stop < end and _stuck_again(m) is None
            ]
            if slow:  # no stick so soon
                longer = [replace(cut[i], stop=end) for i in slow]
                again = self._simulated(longer, own[who[slow]], onward[who[slow]])
                for i, one, m in zip(slow, longer, again, strict=True):
                    cut[i], motions[i] = one, m
            for k, one, m in zip(who.tolist(), cut, motions, strict=True):
                going[k] = self._kept(out, k, replace(one, start=one.start - tail.start), m, own)
                if going[k]:
                    assert m is not None
                    stick = _stuck_again(m) or 0
                    at[k] = Stretch(0, one.start + stick, end, 0.0, self.rest)
                    onward[k, HIDING] = m.state[stick, HIDING]
        return out

    def _simulated(self, cut: Sequence[Stretch], own: Floats, onward: Floats) -> list[WindowMotion | None]:
        return with_windows(self.windows, cut, self.data, onward=onward).motions(self.at, own)

    def _kept(self, out: Flown, k: int, one: Stretch, motion: WindowMotion | None, own: Floats) -> bool:
        """Keep what was simulated up to the next stick, `one` counted from the first sample; whether more comes."""
        if motion is None:
            return False
        again = _stuck_again(motion)
        last = len(motion.t) if again is None else again
        part = slice(one.start, one.start + last)
        out.readings[k, part] = motion.readings[:last]
        if k < len(out.state):
            out.state[k, part], out.mode[k, part] = motion.state[:last], motion.mode[:last]
        if again is None or one.start + again >= out.readings.shape[1]:
            return False
        begins, states = self.windows.begins, list(self.windows.sensors.begins)
        own[k, :begins] = 0.0
        own[k, : len(states)] = motion.state[again][states]
        if self.events.ahead is not None:
            own[k, states.index(X1)] += self.events.ahead[k]
        own[k, begins:] = self.events.next(k, own[k, begins:], self.rng)
        return True


def with_windows(
    windows: BeltWindows,
    cut: Sequence[Stretch],
    run: Data,
    common: Floats | None = None,
    onward: Floats | None = None,
) -> BeltWindows:
    """Return the same windows elsewhere, on one run; with something else in common or `onward`, if that is given."""
    return BeltWindows(
        windows.model,
        [run],
        cut,
        windows.numbers,
        Declared(),
        windows.sensors,
        windows.policy,
        loose=windows.loose,
        common=windows.common if common is None else common,
        onward=onward,
    )


def _stuck_again(motion: WindowMotion) -> int | None:
    """The first sample of the stick that follows a slip, so later than the first of all."""
    slips = np.flatnonzero(motion.mode != 0)
    if not len(slips):
        return None
    stuck = np.flatnonzero(motion.mode[slips[0] :] == 0)
    return int(slips[0] + stuck[0]) if len(stuck) else None
