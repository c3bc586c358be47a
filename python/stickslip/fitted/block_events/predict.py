"""Forecasts of a block on a belt: the state and the level of friction from the past alone, then the model's own run."""

from __future__ import annotations

import functools
from dataclasses import InitVar, dataclass, field, fields, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.effect import FormulaEffect
from stickslip.declared.model import Model
from stickslip.errors import StickslipError
from stickslip.fitted.block_events.cycle import S
from stickslip.fitted.block_events.levels import carried
from stickslip.fitted.block_events.past import BlockStart, Leg, Past
from stickslip.fitted.block_events.sensor import BlockChannel, reading_of
from stickslip.fitted.block_events.table import MeasuredBlock, measure, natural_rate, prepare
from stickslip.measured.recording import Recording
from stickslip.measured.sticks import CLEAR

Floats = NDArray[np.float64]
RECENT = 3  # events whose mean level is carried on
LAST = 16  # readings that a state at the end is held against
PHASES = 24  # of a turn, tried for an unknown phase, and legs that they are tried on
ROUNDS = 3  # of phases and states by turns
PERIODS = 2  # natural ones, of a past without sticks that its state is taken from


@dataclass(frozen=True)
class BlockPrediction:
    """Readings x, deflections and velocities, and modes at times t, (n,), as `BlockRun` has them."""

    t: Floats
    reading: Floats
    state: Floats
    mode: NDArray[np.int8]


@dataclass(frozen=True)
class PastStick:
    """A stick of the past and the way from it to the next: chi-squared plain and at the level of the events before.

    `ratio` is the friction at its breakaway over the model's; `tried`: a level was known before it.
    """

    start: BlockStart
    misfit: float = 0.0
    sized: float = 0.0
    readings: int = 0
    ratio: float = np.nan
    tried: bool = False


@dataclass
class BlockForecaster:
    """Forecasts one run with one model.

    Parameters
    ----------
    model : of a `BlockOnBelt`; its phases are kept unless the past says otherwise.
    measured : the run; x rises in its sticks, as in `BlockRun`.
    reading : of the measured run's channel; the model's own if none is given.
    sensor : of the readings to come; that of the measured run if none is given.
    """

    model: Model
    measured: MeasuredBlock
    reading: InitVar[BlockChannel | None] = None
    sensor: BlockChannel | None = None
    past: Past = field(init=False)
    walk: list[PastStick] = field(init=False, default_factory=list)
    turned: int = field(init=False, default=0)  # legs that the phases are from

    def __post_init__(self, reading: BlockChannel | None) -> None:
        run = self.measured.run
        self.chain = reading or reading_of(self.model, run.force_channel)
        m, noise = self.chain.motion(run.t, run.sign * run.x, run.noise)
        self.past = Past(run.t, m, noise, run.sign * run.belt_speed, run.track, self.chain)
        self.sticks = run.track.clear_sticks

    @classmethod
    def of(cls, model: Model, recording: Recording, *, at_rest: bool = False) -> BlockForecaster:
        """Forecast a recording, its events found behind the sensor; only the lag is left to the forecast.

        Raises
        ------
        InputError
            A curve of the reading in x2, a record too short, or a belt that stands still where that is not allowed for.
        """
        sensor = reading_of(model, recording.channel("x1") == "spring_force")
        measured = measure(prepare(bare(recording, sensor), at_rest=at_rest))
        return cls(model, measured, BlockChannel(lag=sensor.lag), sensor)

    def free(self, at: int) -> BlockPrediction:
        """The model from sample `at` to the end, its phases from the whole run, its state from the readings there.

        Raises
        ------
        StickslipError
            The model cannot be simulated so far.
        """
        run = self.measured.run
        self.settle(len(run.t))
        stick = next((s for s in self.sticks if s.start <= at < s.stop), None)
        if stick is not None:
            start = self.past.resting(self.model, at, stick, None)
        else:
            start = self.past.sliding(self.model, at)
            most = PERIODS * 2 * np.pi / natural_rate(run.rig)
            stop = min(int(np.searchsorted(run.t, run.t[at] + most)), len(run.t) - 1)
            leg = self.past.fitted(self.model, start, stop)
            start = start if leg is None else leg.start
        return self._predicted(self.model, start, run.t[at:])

    def _predicted(self, model: Model, start: BlockStart, t: Floats) -> BlockPrediction:
        out = self.past.simulated(model, start, t)
        sign, sensor = self.measured.run.sign, self.sensor or self.chain
        read = sensor.read(out.state[:, 0], out.hidden.get("m"), t)
        return BlockPrediction(t, sign * read, sign * out.state, np.asarray(sign * out.mode, dtype=np.int8))

    def forecast(self, stop: int, future: Floats) -> BlockPrediction:
        """Readings at `future` times from samples before `stop`.

        Raises
        ------
        StickslipError
            The model cannot be simulated over the past or to the last time.
        """
        self.settle(stop)
        start, walk = self._last(stop)
        model = self._levelled(walk)
        leg = self.past.fitted(model, start, stop - 1)
        if leg is None:
            raise StickslipError("the model cannot be simulated over the end of the past")
        # from where the leg began, unless the readings are elsewhere: what is hidden goes on to the last digit
        return self._predicted(model, self._elsewhere(leg, stop) or leg.start, future)

    def _sliding(self, model: Model, stop: int) -> BlockStart:
        """A state some natural periods before a sample, of a past without sticks."""
        run = self.measured.run
        back = PERIODS * 2 * np.pi / natural_rate(run.rig)
        first = int(np.searchsorted(run.t, run.t[stop - 1] - back))
        return self.past.sliding(model, max(0, min(first, stop - LAST)))

    def _last(self, stop: int) -> tuple[BlockStart, list[PastStick]]:
        """Where the model starts to reach a sample, the middle of the last stick if there is one; and the way there."""
        walk = self._walked(stop)
        begun = next((s for s in self.sticks if s.start + CLEAR <= stop < s.stop), None)
        if begun is not None:
            at = (begun.start + stop) // 2
            before = self.past.leg(self.model, walk[-1].start, at) if walk else None
            if before is not None:
                walk = [*walk[:-1], self._held_against(walk, before)]
            return self.past.resting(self.model, at, replace(begun, stop=stop), before), walk
        if walk:
            return walk[-1].start, walk
        return self._sliding(self.model, stop), walk

    def _walked(self, stop: int) -> list[PastStick]:
        """The sticks that end before a sample, each entered as the model comes from the one before."""
        count = sum(s.stop <= stop for s in self.sticks)
        for stick in self.sticks[len(self.walk) : count]:
            at = stick.middle
            before = self.past.leg(self.model, self.walk[-1].start, at) if self.walk else None
            if before is not None:
                self.walk[-1] = self._held_against(self.walk, before)
            self.walk.append(PastStick(self.past.resting(self.model, at, stick, before)))
        # the way on from the last of them is not past yet
        done = self.walk[:count]
        return [*done[:-1], *(PastStick(one.start) for one in done[-1:])]

    def _held_against(self, walk: list[PastStick], leg: Leg) -> PastStick:
        """What friction's level of the events before would have made of a leg, and what its own event says of it."""
        e, run, law = self.measured.events, self.measured.run, self.model.friction
        inside = np.flatnonzero((e.t > run.t[leg.start.at]) & (e.t < run.t[leg.stop]))
        ratio = np.nan
        if len(inside):
            lag = self.chain.lag * self.past.speed
            top = self.chain.bend.undone(run.sign * e.p[inside[:1], S], e.t[inside[:1]]) + lag
            ours = float(carried(self.model, np.array([leg.released]), self.past.speed)[0])
            limit = law.static_limits[0] if run.sign > 0 else -law.static_limits[1]
            ratio = float(carried(self.model, top, self.past.speed)[0]) / (
                ours if np.isfinite(ours) else limit
            )
        factor, sized = self._level(walk), leg
        if factor is not None:
            sized = self.past.leg(scaled(self.model, factor), leg.start, leg.stop) or leg
        return PastStick(
            leg.start, leg.misfit, sized.misfit, leg.stop - leg.start.at, ratio, factor is not None
        )

    @staticmethod
    def _level(walk: list[PastStick]) -> float | None:
        """Friction of the last events over the model's; None where none is known."""
        ratios = [one.ratio for one in walk if np.isfinite(one.ratio)][-RECENT:]
        level = float(np.mean(ratios)) if ratios else 0.0
        return level if level > 0 else None

    def _levelled(self, walk: list[PastStick]) -> Model:
        """The model, its friction at the level of the last events where that has foretold the past better.

        No law predicts how runs and places differ; but the level is one more number, and must be worth it.
        """
        tried, factor = [one for one in walk if one.tried], self._level(walk)
        plain, sized, n = (sum(getattr(one, key) for one in tried) for key in ("misfit", "sized", "readings"))
        if factor is None or not n or not worth(plain, sized, 1, n):
            return self.model
        return scaled(self.model, factor)

    def settle(self, stop: int) -> None:
        """Phases of this run, which no other run tells; those of the model where the past fits them."""
        turns = (one for one in self.model.effects if not isinstance(one, FormulaEffect))
        names = [f"{one.name}.phi" for one in turns if "phi" in one.parameters]
        if not names or len(self._walked(stop)) < 2 * self.turned:
            return
        self.turned = len(self.walk)
        for _ in range(ROUNDS):  # the states at the sticks were those of the phases before
            legs = [step for step in self._walked(stop) if step.readings][-PHASES:]
            if len(legs) < 2 * len(names) or not self._turned(names, legs):
                return

    def _turned(self, names: list[str], legs: list[PastStick]) -> bool:
        """Take the phases that meet the legs best, if they are worth it."""

        def misfit(model: Model) -> float:
            made = [self.past.leg(model, one.start, one.start.at + one.readings) for one in legs]
            return sum(np.inf if one is None else one.misfit for one in made)

        start, model, step = misfit(self.model), self.model, 2 * np.pi / PHASES
        for name in names:
            put = functools.partial(_put, model, name)
            angles = model.parameters[name] + step * np.arange(PHASES)
            nearest = float(angles[int(np.argmin([misfit(put(a)) for a in angles]))])
            found = scipy.optimize.minimize_scalar(
                lambda a, put=put: misfit(put(a)),
                bounds=(nearest - step, nearest + step),
                options={"xatol": 1e-6},
            )
            model = put(float(found.x))
        if worth(start, misfit(model), len(names), sum(one.readings for one in legs)):
            self.model, self.walk = model, []
            return True
        return False

    def _elsewhere(self, leg: Leg, stop: int) -> BlockStart | None:
        """A state from the last readings alone; None where the model passes through them as well.

        In a stick the block is carried; in a slip a parabola of what the lag leaves is m, and x is m + lag m'.
        """
        run, past, lag = self.measured.run, self.past, self.chain.lag
        first = max(leg.start.at, stop - LAST)
        r = (past.m[first:stop] - past.lagged(leg.end)[first - leg.start.at :]) / past.noise
        good = np.isfinite(r)
        stuck = any(s.start <= first and stop <= s.stop for s in run.track.sticks)
        degree = 0 if stuck else 2
        if good.sum() <= degree + 1:
            return None
        t, rides = (run.t[first:stop] - run.t[stop - 1])[good], past.speed if stuck else 0.0
        m = past.m[first:stop][good] - rides * t
        local = np.polynomial.Polynomial.fit(t, m, degree).convert()
        own = float(np.sum(((m - local(t)) / past.noise) ** 2))
        if not worth(float(np.sum(r[good] ** 2)), own, degree + 1, len(t)):
            return None
        hidden = dict(leg.start.hidden) | {name: float(x[-1]) for name, x in leg.end.hidden.items()}
        start = BlockStart(stop - 1, float(leg.end.state[-1, 0]), 0.0, hidden, leg.start.contact)
        x, v = state_behind(local, rides, lag)
        contact = start.contact if stuck else "auto"
        v = past.speed if stuck else run.sign * min(run.sign * v, run.belt_speed)
        moved = replace(start.moved(self.model, x), v=v, contact=contact)
        return replace(moved, hidden=moved.hidden | {"m": float(local(0.0))})


def bare(recording: Recording, sensor: BlockChannel) -> Recording:
    """The recording as if its sensor added nothing but its lag."""
    t = recording.t - recording.t[0]
    m, _ = sensor.behind(recording.x1, np.gradient(recording.x1, t), t)
    noise = {
        name: size / (abs(sensor.gain) if name == "x1" else 1.0) for name, size in recording.noise.items()
    }
    return replace(recording, x1=m, noise=noise)


def _put(model: Model, name: str, value: float) -> Model:
    return model.replace({name: float(value)})


def state_behind(m: np.polynomial.Polynomial, rides: float, lag: float) -> tuple[float, float]:
    """Deflection and velocity at time 0 behind the lagged deflection m(t) + rides t."""
    rate = rides + float(m.deriv()(0.0))
    return float(m(0.0)) + lag * rate, rate + lag * float(m.deriv(2)(0.0))


def worth(before: float, after: float, numbers: int, readings: int) -> bool:
    """Is a fall of chi-squared worth so many more numbers (BIC)? What is left after it is counted as noise."""
    left = max(after / max(readings - numbers, 1), 1.0)
    return bool((before - after) / left > numbers * np.log(readings))


def scaled(model: Model, factor: float) -> Model:
    """The model with friction a factor as large."""
    law = model.friction
    values = {one.name: getattr(law, one.name) for one in fields(law)}
    sized = {n: v if v is None or n.startswith("decay") else v * factor for n, v in values.items()}
    return replace(model, friction=type(law)(**sized))


def instants(measured: MeasuredBlock, cycle: float, most: int) -> list[int]:
    """Samples to forecast from: the middles of sticks, after the first few events and before the last cycle."""
    run, e = measured.run, measured.events
    if len(e) < RECENT + 1:
        return []
    first, last = float(e.t[RECENT - 1]), float(run.t[-1]) - cycle
    middles = [s.middle for s in run.track.clear_sticks]
    kept = [i for i in middles if first < run.t[i] < last]
    if len(kept) > most:
        kept = [kept[i] for i in np.unique(np.linspace(0, len(kept) - 1, most).astype(int))]
    return kept


def cycle_of(measured: MeasuredBlock) -> float:
    """Mean time from event to event."""
    e = measured.events
    gaps = np.diff(e.t)
    return float(np.median(gaps)) if len(gaps) else float(measured.run.t[-1])
