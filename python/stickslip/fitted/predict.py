"""Forecasting readings: the state, hidden states and phases from the past by the window fit, then a free run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import FormulaEffect
from stickslip.declared.model import Model
from stickslip.errors import StickslipError
from stickslip.fitted.data import Data
from stickslip.fitted.engine import ATOL, RTOL, Engine
from stickslip.fitted.readings import ReadingCurve, no_slopes, read, reading_rate
from stickslip.fitted.relax import relaxed
from stickslip.fitted.solve import fit
from stickslip.fitted.unknowns import Hypothesis, Unknown
from stickslip.fitted.window import AUTO, Window
from stickslip.fitted.windows import start_window

Floats = NDArray[np.float64]
PHASES = 12  # starts tried for an unknown phase
PAST = (1.5, 2.5, 0.8)  # cycles of the past that the state may be taken from, in order of preference
MORE = 3.5  # cycles that it is taken from if the model explains them as well


@dataclass(frozen=True)
class Prediction:
    """Readings (n, c), the rate of x1's (n,), states (n, 9) and contact modes (n,) at times t (n,)."""

    t: Floats
    readings: Floats
    rate: Floats
    state: Floats
    mode: NDArray[np.int8]


@dataclass
class Forecaster:
    """Forecasts one run with one model.

    Parameters
    ----------
    model : complete model; phases in it are starts only.
    run : the record.
    threads : threads over windows.
    learned : curves on the readings.
    """

    model: Model
    run: Data
    threads: int
    learned: tuple[ReadingCurve, ...] = ()

    def __post_init__(self) -> None:
        turns = (one for one in self.model.effects if not isinstance(one, FormulaEffect))
        self.periodic = [one for one in turns if "phi" in one.parameters]
        unknowns = tuple(
            Unknown(f"{one.name}.phi", one.parameters["phi"], False, 0.0, 30.0, per_run=True)
            for one in self.periodic
        )
        self.engine = Engine([self.run], Hypothesis(self.model, unknowns, {}), self.threads, self.learned)
        self.vector = self.engine.hypothesis.start(1)
        self.known = False

    def settle(self, stop: int) -> None:
        """Find the phases from samples before `stop`."""
        if not self.periodic:
            return
        windows = self._windows(stop)
        starts = [self.vector] if self.known else self._phase_grid()
        costs = [self.engine.cost(v, windows) for v in starts]
        best, least = self.vector, np.inf
        for i in np.argsort(costs)[: 1 if self.known else 3]:
            found = fit(self.engine, starts[i], windows, iterations=12, rounds=1)
            if found is not None and found.cost < least:
                best, least = found.vector, found.cost
        self.vector, self.known = best, True

    def _phase_grid(self) -> list[Floats]:
        angles = np.arange(PHASES) * 2 * np.pi / PHASES
        if len(self.periodic) == 1:
            return [np.array([a]) for a in angles]
        return [np.array([a, b]) for a in angles[::2] for b in angles[::2]]

    def _windows(self, stop: int) -> list[Window]:
        starts = [0, *(int(s) for s in self.run.slips if s < stop - 20)]
        ends = [*starts[1:], stop]
        return [
            start_window(self.run, 0, self.model, a, b)
            for a, b in zip(starts, ends, strict=True)
            if b - a > 9
        ]

    def state_window(self, stop: int) -> Window:
        """A window that ends at `stop`, its states fitted to the readings in it."""
        best: Window | None = None
        least = np.inf
        for cycles in PAST:
            wanted = self.run.t[stop - 1] - cycles * self.run.cycle
            before = [int(s) for s in self.run.slips if self.run.t[s] <= wanted]
            start = before[-1] if before else 0
            if stop - start < 12:
                continue
            window = self._relaxed(start, stop)
            r = self.engine.residual(self.vector, window)
            chi2 = np.inf if r is None else float(r @ r) / len(r)
            if best is None or chi2 < 0.8 * least:
                best, least = window, chi2
            if least < 1.5:
                break
        if best is None:
            raise StickslipError("the past is too short to tell the state from it: give at least one cycle")
        return self._longer(best, stop, least)

    def _relaxed(self, start: int, stop: int) -> Window:
        return relaxed(self.engine, self.vector, [start_window(self.run, 0, self.model, start, stop)], 15)[0]

    def _longer(self, best: Window, stop: int, least: float) -> Window:
        """A longer past says more of the state, as long as the model explains it as well."""
        wanted = self.run.t[stop - 1] - MORE * self.run.cycle
        before = [int(s) for s in self.run.slips if self.run.t[s] <= wanted and s < best.start]
        if not before:
            return best
        window = self._relaxed(before[-1], stop)
        r = self.engine.residual(self.vector, window)
        chi2 = np.inf if r is None else float(r @ r) / len(r)
        return window if chi2 < 1.15 * least else best

    def run_on(self, window: Window, t: Floats) -> Prediction:
        """Simulate from a window's start through times t after it."""
        numbers, p = self.engine.parameters(self.vector, 0)
        start = float(self.run.t[window.start]) - self.run.half
        raw = self.engine.lowered[0].run(
            parameters=numbers,
            initial=window.state,
            t=np.ascontiguousarray(t),
            contact=min(window.contact, AUTO),
            t_start=start,
            rtol=RTOL,
            atol=ATOL,
            max_transitions=100_000,
        )
        state = np.asarray(raw["state"])
        if len(state) != len(t):
            raise StickslipError("the model's run stopped before the horizon; its numbers make it ill-posed")
        channels = self.run.readings.shape[1]
        chain = read(t, state, no_slopes(len(t)), (), p, self.run.belt_speed, channels, self.engine.added)
        rate = reading_rate(t, state, p, self.engine.added)
        return Prediction(t, chain.values, rate, state, np.asarray(raw["mode"]))

    def forecast(self, stop: int, future: Floats) -> Prediction:
        """Readings at `future` times from samples before `stop`."""
        self.settle(stop)
        window = self.state_window(stop)
        past = self.run.t[window.start : window.stop]
        whole = self.run_on(window, np.concatenate([past, future]))
        part = slice(len(past), None)
        return Prediction(future, whole.readings[part], whole.rate[part], whole.state[part], whole.mode[part])


def stitched(
    forecaster: Forecaster, cycles: float, first: float = 3.0
) -> tuple[Prediction, NDArray[np.int64]]:
    """Forecasts of `cycles` from every cycle on, laid end to end, and the samples they are for.

    With `cycles` above 1 the stretches overlap; they are kept one after the other.
    """
    run = forecaster.run
    first = max(1.0, min(first, float(run.t[-1]) / run.cycle - cycles - 1.0))
    at = float(run.t[0]) + first * run.cycle
    pieces: list[Prediction] = []
    samples: list[NDArray[np.int64]] = []
    while at + cycles * run.cycle <= run.t[-1] + 1e-9:
        stop = int(np.searchsorted(run.t, at))
        end = int(np.searchsorted(run.t, at + cycles * run.cycle))
        if end > stop:
            try:
                pieces.append(forecaster.forecast(stop, run.t[stop:end]))
                samples.append(np.arange(stop, end))
            except StickslipError:
                pass
        at += run.cycle
    if not pieces:
        raise StickslipError(
            f"run '{run.name}' is too short for a forecast: it needs {first + cycles:g} cycles"
        )
    return joined(pieces), np.concatenate(samples)


def joined(pieces: Sequence[Prediction]) -> Prediction:
    """Predictions one after the other."""
    return Prediction(
        np.concatenate([p.t for p in pieces]),
        np.concatenate([p.readings for p in pieces]),
        np.concatenate([p.rate for p in pieces]),
        np.concatenate([p.state for p in pieces]),
        np.concatenate([p.mode for p in pieces]),
    )


def started(forecaster: Forecaster) -> Window:
    """The first quarter of the run, its states and the phases fitted."""
    run = forecaster.run
    forecaster.settle(len(run.t))
    start = start_window(run, 0, forecaster.model, 0, len(run.t) // 4)
    return relaxed(forecaster.engine, forecaster.vector, [start])[0]


def whole_run(forecaster: Forecaster) -> Prediction:
    """The model from the start of the run to its end, the state at the start fitted to all of it."""
    run = forecaster.run
    window = replace(started(forecaster), stop=len(run.t))
    return forecaster.run_on(relaxed(forecaster.engine, forecaster.vector, [window], 15)[0], run.t)


def free_run(forecaster: Forecaster, seed: int) -> Data:
    """The run as the model itself would have given it, with fresh noise: what the floor is measured on."""
    run = forecaster.run
    whole = forecaster.run_on(started(forecaster), run.t)
    noise = np.random.default_rng(seed).standard_normal(whole.readings.shape) * run.noise
    return replace(run, readings=whole.readings + noise)
