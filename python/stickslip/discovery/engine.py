"""Windows linearised: residuals of a hypothesis against the readings, with exact derivatives from the core."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.discovery.data import Data
from stickslip.discovery.readings import Learned, read
from stickslip.discovery.unknowns import Hypothesis
from stickslip.lowering import SLOTS, WIDTH, lower

Floats = NDArray[np.float64]
RTOL, ATOL = 1e-7, 1e-8
ATTEMPTS = ((0.0, 0, RTOL), (1e-9, 20, RTOL), (0.0, 24, 1e-12), (1e-6, 24, 1e-12), (-5e-6, 0, RTOL))
MOST_TRANSITIONS, MOST_STEPS = 500, 20_000  # in a window: beyond, its parameters are no rig's
HOPELESS = (_core.Outcome.too_many_transitions, _core.Outcome.too_many_steps)
STATES = len(_core.STATES)
W, Z, BELT, LAGGED, DWELL = 4, 5, 6, 7, 8
AUTO, STICK = 2, 0
REACH = 0.75  # of an unknown's spread: the most that one step may move it
FAILED, MOST_FAILED = 10.0, 0.15  # residual of a window that cannot be simulated; share of windows that may
VISIBLE = np.array([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True)
class Window:
    """Samples start <= i < stop of a run, met by one simulation.

    `state` (9,) is its initial state, hidden states included; `free` the entries estimated; `spread` (9,) the
    weak Gaussian that holds free hidden states about `centre`; `contact` the mode it starts in.
    """

    run: int
    start: int
    stop: int
    state: Floats
    free: tuple[int, ...]
    centre: Floats
    spread: Floats
    contact: int = AUTO


@dataclass
class Block:
    """One window linearised: r = (reading - model)/noise, -dr/d shared, -dr/d own; (m,), (m, p), (m, q)."""

    r: Floats
    J: Floats
    K: Floats
    mode: NDArray[np.int8]

    def __post_init__(self) -> None:
        both = np.column_stack([self.J, self.K, self.r])
        self.products = both.T @ both  # taken here, in the window's own thread


class Engine:
    """Evaluates one hypothesis on the runs; everything that does not change between calls is done once.

    Parameters
    ----------
    data : the runs.
    hypothesis : what is fitted.
    pool : threads over windows; the core runs without the interpreter's lock.
    """

    def __init__(
        self,
        data: Sequence[Data],
        hypothesis: Hypothesis,
        pool: ThreadPoolExecutor,
        learned: tuple[Learned, ...] = (),
    ) -> None:
        self.data = list(data)
        self.hypothesis = hypothesis
        self.learned = learned
        self.pool = pool
        self.lowered = [lower(hypothesis.model, run.belt_speed) for run in data]
        self.order = (*hypothesis.shared, *hypothesis.own)
        self.names = tuple(u.name for u in self.order)
        slots = self.lowered[0].slots
        self.slots = [slots.get(name, ()) for name in self.names]
        self.fixed = {n: v for n, v in hypothesis.model.parameters.items() if n not in self.names}
        self.seeds = np.zeros((len(self.names) + STATES, WIDTH + STATES))
        for row, places in zip(self.seeds, self.slots, strict=False):
            row[list(places)] = 1.0
        for k in range(STATES):
            self.seeds[len(self.names) + k, WIDTH + k] = 1.0
        self.moving = [i for i, places in enumerate(self.slots) if places]
        self.still = [i for i, places in enumerate(self.slots) if not places]
        self.centre, self.precision = hypothesis.prior(len(self.data))
        self.low, self.high = hypothesis.limits(len(self.data))
        self.reach = np.minimum(REACH / np.sqrt(self.precision), hypothesis.turns(len(self.data)))
        self.columns = [hypothesis.columns(run) for run in range(len(self.data))]
        self.none = np.zeros((0, WIDTH + STATES))
        self._last: tuple[bytes, dict[int, tuple[Floats, dict[str, float]]]] = (b"", {})

    def parameters(self, vector: Floats, run: int) -> tuple[Floats, dict[str, float]]:
        """The core's parameter vector and the values by name (kept for the latest vector)."""
        key = vector.tobytes()
        last = self._last
        if last[0] != key:
            last = self._last = (key, {})
        if run not in last[1]:
            last[1][run] = self._parameters(vector, run)
        return last[1][run]

    def _parameters(self, vector: Floats, run: int) -> tuple[Floats, dict[str, float]]:
        picked = vector[self.columns[run]].tolist()
        values = {u.name: u.value(c) for u, c in zip(self.order, picked, strict=True)}
        numbers = self.lowered[run].parameters.copy()
        for name, places in zip(self.names, self.slots, strict=True):
            for place in places:
                numbers[place] = values[name]
        return numbers, {**self.fixed, **values}

    def simulate(self, vector: Floats, window: Window, seeds: Floats) -> dict[str, object] | None:
        """The core's raw record of one window; None where the simulation fails."""
        run = self.data[window.run]
        numbers, _ = self.parameters(vector, window.run)
        if not np.isfinite(numbers).all() or not np.isfinite(window.state).all():
            return None
        t = run.t[window.start : window.stop]
        for nudge, order, rtol in ATTEMPTS:  # what rounding decided badly once
            raw: dict[str, object] = _core.simulate(
                structure=self.lowered[window.run].structure,
                parameters=numbers,
                initial=window.state + nudge * VISIBLE,
                t_start=float(t[0]),
                t_end=float(t[-1]),
                contact=window.contact,
                t_eval=t,
                rtol=rtol,
                atol=ATOL,
                locator=_core.Locator.henon,
                seeds=seeds,
                max_transitions=MOST_TRANSITIONS,
                max_steps=MOST_STEPS,
                order=order,
            )
            if raw["outcome"] == _core.Outcome.finished:
                return raw
            if raw["outcome"] in HOPELESS:
                break
        return None

    def end(self, vector: Floats, window: Window) -> Floats | None:
        """State (9,) at the sample after a window's last; None at the end of the run or where it fails."""
        if window.stop >= len(self.data[window.run].t):
            return None
        raw = self.simulate(vector, replace(window, stop=window.stop + 1), self.none)
        return None if raw is None else np.asarray(raw["state"])[-1]

    def residual(self, vector: Floats, window: Window) -> Floats | None:
        """r alone, (n c,)."""
        raw = self.simulate(vector, window, self.none)
        if raw is None:
            return None
        state = np.asarray(raw["state"])
        return self._weigh(self._chain(vector, window, state, np.zeros((len(state), STATES, 0)))[0], window)

    def linearise(self, vector: Floats, window: Window, own_only: bool = False) -> Block | None:
        """r, J and K of one window; J is 0 with `own_only`."""
        moving = [] if own_only else self.moving
        asked = [*moving, *(len(self.names) + k for k in window.free)]
        raw = self.simulate(vector, window, np.ascontiguousarray(self.seeds[asked]))
        if raw is None:
            return None
        state, sens = np.asarray(raw["state"]), np.asarray(raw["sensitivity"])
        n, p, q = len(state), len(self.names), len(window.free)
        still = [] if own_only else self.still  # what bears on the reading alone
        names = (*(self.names[i] for i in moving), *("",) * q, *(self.names[i] for i in still))
        if still:
            sens = np.concatenate([sens, np.zeros((n, STATES, len(still)))], axis=2)
        values, slopes = self._chain(vector, window, state, sens, names)
        if not np.isfinite(slopes).all():
            return None
        weight = self.data[window.run].weight[window.start : window.stop]
        D = (slopes * weight[:, :, None]).reshape(-1, len(names))
        k = len(moving)
        J = np.zeros((len(D), p))
        if not own_only:
            _, by_name = self.parameters(vector, window.run)
            scale = np.array([u.slope(by_name[u.name]) for u in self.order])
            J[:, moving] = D[:, :k] * scale[moving]
            J[:, still] = D[:, k + q :] * scale[still]
        return Block(self._weigh(values, window), J, D[:, k : k + q], np.asarray(raw["mode"]))

    def _chain(
        self, vector: Floats, window: Window, state: Floats, sens: Floats, names: tuple[str, ...] = ()
    ) -> tuple[Floats, Floats]:
        run = self.data[window.run]
        _, p = self.parameters(vector, window.run)
        t = run.t[window.start : window.stop]
        chain = read(t, state, sens, names, p, run.belt_speed, run.readings.shape[1], self.learned)
        return chain.values, chain.slopes

    def _weigh(self, values: Floats, window: Window) -> Floats:
        run = self.data[window.run]
        part = slice(window.start, window.stop)
        return np.asarray(((run.readings[part] - values) * run.weight[part]).ravel())

    def blocks(self, vector: Floats, windows: Sequence[Window]) -> list[Block] | None:
        """All windows linearised; None if more than a few cannot be simulated (those few carry a large residual)."""
        out = list(self.pool.map(lambda w: self.linearise(vector, w), windows))
        if sum(b is None for b in out) > MOST_FAILED * len(out):
            return None
        return [self._failed(w) if b is None else b for w, b in zip(windows, out, strict=True)]

    def _failed(self, window: Window) -> Block:
        m = (window.stop - window.start) * self.data[window.run].readings.shape[1]
        zeros = np.zeros((m, len(self.names)))
        mode = np.ones(window.stop - window.start, dtype=np.int8)
        return Block(np.full(m, FAILED), zeros, np.zeros((m, len(window.free))), mode)

    def costs(self, vector: Floats, windows: Sequence[Window]) -> Floats:
        """chi-squared by window, its own priors included; infinite throughout where too many cannot be simulated."""
        out, failed = np.empty(len(windows)), 0
        for i, (w, r) in enumerate(
            zip(windows, self.pool.map(lambda w: self.residual(vector, w), windows), strict=True)
        ):
            failed += r is None
            m = (w.stop - w.start) * self.data[w.run].readings.shape[1]
            out[i] = (FAILED**2 * m if r is None else float(r @ r)) + window_penalty(w)
        return np.full(len(windows), np.inf) if failed > MOST_FAILED * len(windows) else out

    def penalty(self, vector: Floats) -> float:
        """What the weak priors of the unknowns cost."""
        return float(self.precision @ (vector - self.centre) ** 2)

    def cost(self, vector: Floats, windows: Sequence[Window]) -> float:
        """chi-squared with the weak priors; infinite where too many windows cannot be simulated."""
        total = float(self.costs(vector, windows).sum()) + self.penalty(vector)
        return total if np.isfinite(total) else np.inf


def window_penalty(window: Window) -> float:
    """Prior of a window's own free states."""
    free = list(window.free)
    return float(np.sum(((window.state[free] - window.centre[free]) / window.spread[free]) ** 2))


def moved(window: Window, step: Floats) -> Window:
    """The window with its free states shifted."""
    state = window.state.copy()
    state[list(window.free)] += step
    return replace(window, state=state)


__all__ = ["SLOTS", "Block", "Engine", "Window", "moved", "window_penalty"]
