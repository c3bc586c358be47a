"""What the tracing shares: the data, the clock, what was tried; and how one hypothesis is fitted in earnest."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Concatenate, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.residual import LIMIT, left_over
from stickslip.discovery.rivals import Start
from stickslip.discovery.workers import Task, Workers
from stickslip.fitted.data import Data
from stickslip.fitted.engine import Engine
from stickslip.fitted.readings import Learned, as_terms
from stickslip.fitted.relax import relaxed, rephased
from stickslip.fitted.solve import Fit, Point, conclude, fit
from stickslip.fitted.unknowns import Hypothesis, of_law
from stickslip.fitted.window import Window
from stickslip.fitted.windows import cut, with_hidden

Floats = NDArray[np.float64]
Result = TypeVar("Result")
Rest = ParamSpec("Rest")
SHORT, LONG = 1.0, 2.0  # cycles in a window: to search, and to decide
CLEAN = LIMIT  # sampling errors of chi-squared above 1 that noise alone may leave
NEAR = 4.0  # chi-squared per reading beyond which a fit is not worth perfecting
ALMOST = 1.5  # and below which it is worth more turns
TRIM = 1.2  # chi-squared per reading of a window beyond which it may be on the wrong side of a transition
BESIDE = 1.03  # of a hopeless cost: a fit that stalls within that stands where it began, windows and all
SAME = 1e-3  # of a cost: fits that end this close together have found the same minimum
JUDGED = 4  # steps after which a fit may be given up
MORE = 6  # times that a fit goes on while it still falls fast
LONGEST = 12.0  # processor seconds of one fit: what takes longer is a motion far from any record, or stiff
LARGEST = 16.0  # and of what one process is given to do
SPARE = 5.0  # and of a fit that is needed though the time is up


@dataclass
class Trial:
    """A hypothesis fitted: `names` of its effects, the fit, its penalised -2 log likelihood."""

    names: tuple[str, ...]
    fit: Fit
    partial: bool = False  # on a part of the windows

    @property
    def chi2(self) -> float:
        """Per degree of freedom."""
        return self.fit.per_reading

    @property
    def hypothesis(self) -> Hypothesis:
        """The hypothesis with the fit's numbers in its model."""
        return self.fit.engine.hypothesis.at(self.fit.vector, len(self.fit.engine.data))

    @property
    def model(self) -> Model:
        """The fit's model, its curves on readings among its effects."""
        found, fit = self.hypothesis.model, self.fit
        curves = as_terms(fit.engine.learned, fit.engine.hypothesis.values(fit.vector, 0))
        return found.with_effects([*found.effects, *curves])

    @property
    def extra(self) -> int:
        """Numbers added to the law's."""
        h = self.fit.engine.hypothesis
        return len(self.fit.vector) - sum(of_law(u.name) for u in h.unknowns)

    @property
    def bic(self) -> float:
        """chi-squared with ln N for each added number, and 1 for each hidden state that a window starts from."""
        return self.fit.cost + self.extra * math.log(max(self.fit.readings, 2)) + self.hidden

    @property
    def hidden(self) -> int:
        """Hidden states that its windows start from: on noise each lowers the cost by 1."""
        return sum(k >= 4 for w in self.fit.windows for k in w.free)

    def bic_of(self, readings: int) -> float:
        """The same of a trial on a part of the windows, as if it were of all these readings."""
        return self.bic + self.cost_of(readings) - self.fit.cost

    def cost_of(self, readings: int) -> float:
        """Cost of a trial on a part of the windows, as if it were of all these readings."""
        return readings * self.mean if self.partial else self.fit.cost

    @property
    def mean(self) -> float:
        """Cost per reading: to compare trials of all windows with those of a part."""
        return self.fit.cost / max(self.fit.readings, 1)

    @property
    def excess(self) -> float:
        """chi-squared per reading above 1, in its sampling errors: of all readings, or of the channel with most."""
        return left_over(self.fit)


@dataclass
class Search:
    """Everything the tracing shares: data, threads, the clock, and what was tried."""

    data: list[Data]
    model: Model
    threads: int
    progress: Callable[[str], None]
    budget: float  # processor seconds that may be spent for now
    most: float = math.inf  # and in all
    length: float = SHORT  # cycles in a window
    began: float = field(default_factory=time.process_time)
    tried: dict[tuple[str, ...], Trial] = field(default_factory=dict)
    screened: list[Trial] = field(default_factory=list)
    freed: list[Trial] = field(default_factory=list)  # the declared law with numbers of the rig free
    # crude pairs by the name of their base, with the cost that it had
    pairs: dict[tuple[str, ...], tuple[float, list[Trial]]] = field(default_factory=dict)
    ripples: list[Start] | None = None  # lines that the readings themselves show, once they are looked for
    workers: Workers = field(default_factory=lambda: Workers(1))
    spent: float = 0.0  # processor seconds of other processes
    known: list[tuple[str, Trial, object]] = field(default_factory=list)  # what was computed of a trial

    @property
    def left(self) -> float:
        """Processor seconds of the budget that remain."""
        return self.budget - self.spent - (time.process_time() - self.began)

    @property
    def at_once(self) -> int:
        """How many fits run side by side."""
        return self.workers.count

    def submit(
        self,
        function: Callable[Concatenate[Search, Rest], Result],
        *args: Rest.args,
        **options: Rest.kwargs,
    ) -> Task[Result]:
        """Have function(search, ...) computed by another process where there is one, else when it is asked for."""
        return self.workers.submit(self, function, *args, **options)

    def away(self) -> Search:
        """The search as another process needs it: the data, the declared model, the time that is left."""
        return Search(self.data, self.model, 1, _silent, min(self.left, LARGEST), length=self.length)

    def back(self, value: object, seconds: float) -> None:
        """What came back from another process is on our data and threads, and its time is ours."""
        self.spent += seconds
        for one in value if isinstance(value, tuple) else (value,):
            if isinstance(one, Trial):
                one.fit.engine.data, one.fit.engine.threads = self.data, self.threads

    def once(self, what: str, of: Trial, compute: Callable[[], Result]) -> Result:
        """What is computed of a trial, from memory if it has been."""
        for name, trial, value in self.known:
            if name == what and trial is of:
                return cast(Result, value)
        found = compute()
        self.known.append((what, of, found))
        return found

    def extend(self, seconds: float) -> None:
        """See to it that at least so many processor seconds are left, as far as there are any."""
        self.budget = max(self.budget, min(self.most, self.budget + seconds - self.left))

    def afresh(self, data: list[Data], length: float = SHORT) -> Search:
        """A search on other readings, or in other windows, that goes on with the time of this one."""
        return Search(
            data, self.model, self.threads, self.progress, self.budget, self.most, length,
            began=self.began, workers=self.workers, spent=self.spent,
        )  # fmt: skip

    def run(
        self,
        h: Hypothesis,
        *,
        cycles: float | None = None,
        iterations: int = 40,
        tolerance: float = 1e-4,
        rounds: int = 3,
        windows_of: Trial | None = None,
        states_of: Trial | None = None,
        worst: float = math.inf,
        learned: tuple[Learned, ...] = (),
        vector: Floats | None = None,
        anyway: bool = False,
    ) -> Trial | None:
        """Fit one hypothesis.

        Windows are of `cycles`, the search's length if not given. `windows_of` lends its windows and states,
        `states_of` the states of windows that start at the same sample; `worst` is a hopeless cost; `anyway` goes on
        for a while when the time is up.
        """
        engine = Engine(self.data, h, self.threads, learned)
        if windows_of is None:
            windows = cut(self.data, h.model, self.length if cycles is None else cycles)
            if states_of is not None:
                known = {(w.run, w.start): w for w in states_of.fit.windows}
                windows = [_from(w, known.get((w.run, w.start))) for w in windows]
        else:
            windows = [_from(with_hidden(w, h.model, self.data[w.run]), w) for w in windows_of.fit.windows]
        found = fit(
            engine,
            h.start(len(self.data)) if vector is None else vector,
            windows,
            iterations=iterations,
            tolerance=tolerance,
            rounds=rounds,
            give_up=_Patience(worst, self._late(anyway)),
            worth=lambda cost: not stands(cost, worst),
        )
        part = windows_of is not None and windows_of.partial
        return None if found is None else Trial(_names(h, learned), found, part)

    def _late(self, anyway: bool) -> Callable[[], bool]:
        """Is there no time left for a fit that begins now?"""
        began = time.process_time()

        def late() -> bool:
            over = min(SPARE, LONGEST) if anyway else 0.0
            return time.process_time() - began > (LONGEST if self.left > 0 else over)

        return late

    def keep(self, trial: Trial | None, key: tuple[str, ...]) -> None:
        """Remember a trial if it is the best of its names."""
        if trial is not None and (key not in self.tried or trial.fit.cost < self.tried[key].fit.cost):
            self.tried[key] = trial

    def polish(self, trial: Trial, turns: int = 2, closed: bool = False, further: int = 2) -> Trial:
        """The trial closely fitted on short windows, if not yet; long ones in between shake it out of poor minima.

        One that comes near the noise has `further` turns.
        """
        best, idle = trial if closed else self.close(trial), 0
        for turn in range(turns + further):
            if best.excess < CLEAN or best.chi2 > (NEAR if turn < turns else ALMOST) or self.left < 0:
                break
            before = best.fit.cost
            for _ in range(3):
                last, best = best, self.trimmed(best)
                if best is last or best.fit.cost > 0.99 * last.fit.cost:
                    break
            if best.excess < CLEAN:
                break
            best = self._rephased(best)
            if best.excess < CLEAN:
                break
            long, ends = self._again(best, self.length + 1 + turn, None), [best.fit.cost]
            for origin in (long, self.with_declared_law(best)):
                if best.excess < CLEAN:
                    break
                short = None if origin is None else self._again(origin, None, None)
                if short is not None:
                    ends.append(short.fit.cost)
                    best = short if short.fit.cost < best.fit.cost else best
            if len(ends) == 3 and same(ends):
                break  # reached from three sides
            if best.fit.cost > 0.998 * before:
                idle += 1
                if idle > 1 or turn >= turns:
                    break
        return best

    def half(self, trial: Trial) -> Trial:
        """The trial on every other two of its windows, not fitted on."""
        fit, kept, last, at = trial.fit, [], -1, 0
        for window in trial.fit.windows:
            at, last = (at + 1 if window.run == last else 0), window.run
            if at % 4 < 2:
                kept.append(window)
        point = Point.at(fit.engine, fit.vector, kept)
        if point is None:
            return trial
        part = conclude(fit.engine, point.vector, kept, point.blocks, point.cost, 0)
        return Trial(trial.names, part, partial=True)

    def _rephased(self, trial: Trial) -> Trial:
        """The trial fitted from the best of many phases of each run that it leaves above the noise; or itself."""
        engine = trial.fit.engine
        vector, windows = rephased(engine, trial.fit.vector, trial.fit.windows)
        if np.array_equal(vector, trial.fit.vector):
            return trial
        again = fit(engine, vector, windows, iterations=30)
        return trial if again is None or again.cost > trial.fit.cost else Trial(trial.names, again)

    def trimmed(self, trial: Trial) -> Trial:
        """The trial fitted without the few windows on the wrong side of a transition, which then follow; or itself."""
        engine, windows = trial.fit.engine, trial.fit.windows
        good = [float(b.r @ b.r) < TRIM * len(b.r) for b in trial.fit.blocks]
        if not 0.6 * len(good) <= sum(good) < len(good):
            return trial
        part = fit(engine, trial.fit.vector, [w for w, g in zip(windows, good, strict=True) if g], rounds=0)
        if part is None:
            return trial
        kept = iter(part.windows)
        anew = iter(relaxed(engine, part.vector, [w for w, g in zip(windows, good, strict=True) if not g]))
        every = [next(kept) if g else next(anew) for g in good]
        again = fit(engine, part.vector, every, iterations=20, rounds=1)
        return trial if again is None or again.cost > trial.fit.cost else Trial(trial.names, again)

    def close(self, trial: Trial) -> Trial:
        """The better of both `sides`."""
        return min(self.sides(trial), key=lambda one: one.fit.cost)

    def sides(self, trial: Trial) -> list[Trial]:
        """The trial fitted on from where it is; and, above the noise, afresh with its law from the declared start."""
        done = False
        if trial.partial and (whole := self._again(trial, None, None, 25, trial)):
            done = whole.fit.iterations < 25 and _tolerance(whole) == _tolerance(trial)
            trial = whole
        last, best = trial, trial if done else self._again(trial, None, trial, 25) or trial
        for _ in range(MORE):
            if best.excess < CLEAN or best.fit.iterations < 25 or best.fit.cost > 0.7 * last.fit.cost:
                break
            if self.left < 0:
                break
            last, best = best, self._again(best, None, best, 25) or best
        if best.excess < CLEAN or not trial.names:
            return [best]
        fresh = self._again(self.with_declared_law(trial), None, None, 25)
        return [best] if fresh is None else [best, fresh]

    def with_declared_law(self, trial: Trial) -> Trial:
        """The trial with its law back at the declared start: another way into the minimum."""
        vector = trial.fit.vector.copy()
        for i, u in enumerate(trial.fit.engine.hypothesis.shared):
            if of_law(u.name):
                vector[i] = u.coordinate(self.model.parameters[u.name])
        return Trial(trial.names, replace(trial.fit, vector=vector))

    def _again(
        self,
        trial: Trial,
        cycles: float | None,
        windows_of: Trial | None,
        iterations: int = 40,
        states_of: Trial | None = None,
    ) -> Trial | None:
        return self.run(
            trial.hypothesis,
            cycles=cycles,
            iterations=iterations,
            tolerance=_tolerance(trial),
            windows_of=windows_of,
            states_of=states_of,
            learned=trial.fit.engine.learned,
            vector=trial.fit.vector,
        )


def _tolerance(trial: Trial) -> float:
    """Of a close fit from a trial."""
    return 2e-5 if trial.chi2 < NEAR else 1e-3


def same(costs: Sequence[float]) -> bool:
    """Have fits found the same minimum?"""
    return max(costs) < (1 + SAME) * min(costs)


def stands(cost: float, worst: float) -> bool:
    """Is a cost just beyond the hopeless one, so that the fit stands where it began, windows and all?"""
    return worst < cost < BESIDE * worst


def _silent(_: str) -> None:
    """Tell nobody."""


def _from(window: Window, known: Window | None) -> Window:
    """The window with the state of another that starts where it does."""
    if known is None or known.free != window.free:
        return window
    return replace(window, state=known.state, contact=known.contact)


@dataclass
class _Patience:
    """When to give a fit up: no better than `worst` after a few turns and no longer falling fast, or out of time."""

    worst: float
    late: Callable[[], bool]
    last: float = math.inf

    def __call__(self, done: int, cost: float) -> bool:
        falling, self.last = cost < 0.8 * self.last, cost
        return (done >= JUDGED and cost > self.worst and not falling) or self.late()


def _names(h: Hypothesis, learned: tuple[Learned, ...]) -> tuple[str, ...]:
    return (*h.effects, *(one.name for one in learned))
