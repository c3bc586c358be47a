"""Windows linearised: residuals of a hypothesis against the readings, with exact derivatives from the core.

Windows are evaluated many at a time: one call of the core runs them on all threads, and the measurement chain is
gone through once for all windows of a run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.fitted.data import Data
from stickslip.fitted.formula_reading import formulas_of
from stickslip.fitted.means import instants, pooled
from stickslip.fitted.readings import Added, Chain, ReadingCurve, read, states_read
from stickslip.fitted.unknowns import Hypothesis
from stickslip.fitted.window import AUTO, Window, by_free, window_penalties
from stickslip.simulated.lowering import SLOTS, WIDTH, lower
from stickslip.simulated.states import COUNT

Floats = NDArray[np.float64]
RTOL, ATOL = 1e-7, 1e-8
ATTEMPTS = ((0.0, 0, RTOL), (1e-9, 20, RTOL), (0.0, 24, 1e-12), (1e-6, 24, 1e-12), (-5e-6, 0, RTOL))
MOST_TRANSITIONS, MOST_STEPS = 500, 20_000  # in a window: beyond, its parameters are no rig's
HOPELESS = (_core.Outcome.too_many_transitions, _core.Outcome.too_many_steps)
REACH = 0.75  # of an unknown's spread: the most that one step may move it
FAILED, MOST_FAILED = 10.0, 0.15  # residual of a window that cannot be simulated; share of windows that may
VISIBLE = np.array([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])


@dataclass
class Block:
    """One window linearised: r = (reading - model)/noise, -dr/d shared, -dr/d own; (m,), (m, p), (m, q).

    `products` (p + q + 1, p + q + 1) are the inner products of the columns of [J K r].
    """

    r: Floats
    J: Floats
    K: Floats
    mode: NDArray[np.int8]
    products: Floats


@dataclass
class Simulated:
    """Windows as the core leaves them, one after the other: state (n, 9), mode (n,), slopes by state (n, k).

    `offset` (w + 1,) says where each begins, `ok` (w,) which could be simulated.
    """

    offset: NDArray[np.int64]
    state: Floats
    slopes: dict[int, Floats]
    mode: NDArray[np.int8]
    ok: NDArray[np.bool_]

    def of(self, window: int) -> slice:
        """Samples of a window."""
        return slice(int(self.offset[window]), int(self.offset[window + 1]))


@dataclass(eq=False)
class Engine:
    """Evaluates one hypothesis on the runs; everything that does not change between calls is done once.

    Parameters
    ----------
    data : the runs.
    hypothesis : what is fitted.
    threads : threads over windows; the core runs without the interpreter's lock.
    learned : curves on readings.
    """

    data: list[Data]
    hypothesis: Hypothesis
    threads: int
    learned: tuple[ReadingCurve, ...] = ()
    most_steps: int = MOST_STEPS
    _last: tuple[bytes, Floats, list[dict[str, float]]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        hypothesis, runs = self.hypothesis, len(self.data)
        self.lowered = [lower(hypothesis.model, run.belt_speed) for run in self.data]
        self.order = (*hypothesis.shared, *hypothesis.own)
        self.names = tuple(u.name for u in self.order)
        slots = self.lowered[0].slots
        self.slots = [slots.get(name, ()) for name in self.names]
        self.fixed = {n: v for n, v in hypothesis.model.parameters.items() if n not in self.names}
        self.moving = [i for i, places in enumerate(self.slots) if places]  # others bear on the reading alone
        self.seeds = np.zeros((len(self.names) + COUNT, WIDTH + COUNT))
        self.factors = [self.lowered[0].factors.get(name, 1.0) for name in self.names]
        for row, places, factor in zip(self.seeds, self.slots, self.factors, strict=False):
            row[list(places)] = factor
        for k in range(COUNT):
            self.seeds[len(self.names) + k, WIDTH + k] = 1.0
        self.centre, self.precision = hypothesis.prior(runs)
        self.low, self.high = hypothesis.limits(runs)
        self.reach = np.minimum(REACH / np.sqrt(self.precision), hypothesis.turns(runs))
        self.columns = [hypothesis.columns(run) for run in range(runs)]
        self.added: tuple[Added, ...] = (*self.learned, *formulas_of(hypothesis.model))
        known = {*self.names, *self.fixed}
        channels = self.data[0].readings.shape[1]
        self.kept = np.array(states_read(known, channels, self.added), dtype=np.int32)
        self._last = (b"none", np.empty((0, 0)), [])

    def __reduce__(self) -> tuple[object, ...]:
        # what the core takes does not cross processes; it is made again
        return type(self), (self.data, self.hypothesis, self.threads, self.learned, self.most_steps)

    def parameters(self, vector: Floats, run: int) -> tuple[Floats, dict[str, float]]:
        """The core's parameter vector and the values by name."""
        numbers, values = self._parameters(vector)
        return numbers[run], values[run]

    def _parameters(self, vector: Floats) -> tuple[Floats, list[dict[str, float]]]:
        """Of all runs; kept for the latest vector."""
        key = vector.tobytes()
        if self._last[0] != key:
            numbers = np.stack([one.parameters for one in self.lowered])
            every: list[dict[str, float]] = []
            for run, columns in enumerate(self.columns):
                picked = vector[columns].tolist()
                values = {u.name: u.value(c) for u, c in zip(self.order, picked, strict=True)}
                for name, places, factor in zip(self.names, self.slots, self.factors, strict=True):
                    numbers[run, list(places)] = values[name] * factor
                every.append({**self.fixed, **values})
            self._last = (key, numbers, every)
        return self._last[1], self._last[2]

    def simulate(
        self,
        vector: Floats,
        windows: Sequence[Window],
        states: Floats | None = None,
        seeds: Sequence[int] = (),
        columns: int = 0,
        places: Sequence[int] = (),
    ) -> Simulated:
        """The windows from their states, or from `states` (w, 9), with derivatives by rows of `self.seeds`.

        `places` are the columns of the slopes that these go to, of `columns` in all.
        """
        numbers, _ = self._parameters(vector)
        initial = np.stack([w.state for w in windows]) if states is None else states
        lengths = np.array([w.stop - w.start for w in windows])
        twice = np.array([self.data[w.run].half > 0 for w in windows])
        offset = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        n, kept = int(offset[-1]), self.kept
        sane = np.asarray(np.isfinite(numbers).all(axis=1))
        ok = np.isfinite(initial).all(axis=1) & sane[[w.run for w in windows]]
        out = Simulated(offset, np.zeros((n, COUNT)), {}, np.zeros(n, dtype=np.int8), np.zeros_like(ok))
        left = np.flatnonzero(ok)
        for nudge, order, rtol in ATTEMPTS:  # what rounding decided badly once
            if not left.size:
                break
            chosen = [windows[i] for i in left.tolist()]
            made = self.lowered[0].windows(
                parameters=numbers,
                set=np.array([w.run for w in chosen], dtype=np.int32),
                initial=np.ascontiguousarray(initial[left] + nudge * VISIBLE),
                contact=np.array([min(w.contact, AUTO) for w in chosen], dtype=np.int32),
                t=np.concatenate([instants(self.data[w.run], w.start, w.stop) for w in chosen]),
                offset=np.concatenate([[0], np.cumsum((lengths * (1 + twice))[left])]).astype(np.int64),
                rtol=rtol,
                atol=ATOL,
                seeds=np.ascontiguousarray(self.seeds[list(seeds)]),
                column=np.array(places, dtype=np.int32),
                columns=columns,
                kept=kept,
                max_transitions=MOST_TRANSITIONS,
                max_steps=self.most_steps,
                order=order,
                threads=self.threads,
            )
            raw = pooled(made, twice[left], lengths[left])
            done = _into(out, raw, left, kept)
            out.ok[left[done]] = True
            if done.all():
                break
            hopeless = np.isin(np.asarray(raw["outcome"]), HOPELESS)
            left = left[~done & ~hopeless]
        return out

    def ends(self, vector: Floats, windows: Sequence[Window]) -> list[Floats | None]:
        """State (9,) at the sample after each window's last; None at the end of the run or where it fails."""
        inside = [i for i, w in enumerate(windows) if w.stop < len(self.data[w.run].t)]
        out: list[Floats | None] = [None] * len(windows)
        if inside:
            done = self.simulate(vector, [replace(windows[i], stop=windows[i].stop + 1) for i in inside])
            for j, i in enumerate(inside):
                if done.ok[j]:
                    out[i] = done.state[done.offset[j + 1] - 1]
        return out

    def residuals(
        self, vector: Floats, windows: Sequence[Window], states: Floats | None = None
    ) -> list[Floats | None]:
        """r of each window, (n c,); None where it cannot be simulated."""
        if not windows:
            return []
        done, r = self._residuals(vector, windows, states)
        parts = (r[done.of(i)].ravel() for i in range(len(windows)))
        return [part if good else None for part, good in zip(parts, done.ok.tolist(), strict=True)]

    def _residuals(
        self, vector: Floats, windows: Sequence[Window], states: Floats | None
    ) -> tuple[Simulated, Floats]:
        """r of all samples, (n, c)."""
        done = self.simulate(vector, windows, states)
        parts = [
            (run.readings[rows] - chain.values) * run.weight[rows]
            for run, rows, chain in self._chains(vector, windows, done, ())
        ]
        return done, np.concatenate(parts)

    def chi2(self, vector: Floats, windows: Sequence[Window], states: Floats | None = None) -> Floats:
        """chi-squared of each window (w,), without priors; infinite where it cannot be simulated."""
        if not windows:
            return np.empty(0)
        done, r = self._residuals(vector, windows, states)
        sums = np.add.reduceat(np.einsum("ij,ij->i", r, r), done.offset[:-1])
        return np.where(done.ok, sums, np.inf)

    def residual(self, vector: Floats, window: Window) -> Floats | None:
        """r of one window, (n c,)."""
        return self.residuals(vector, [window])[0]

    def linearised(
        self,
        vector: Floats,
        windows: Sequence[Window],
        states: Floats | None = None,
        own_only: bool = False,
    ) -> list[Block | None]:
        """r, J and K of each window, None where it cannot be simulated; J has no columns with `own_only`."""
        out: list[Block | None] = [None] * len(windows)
        for free, at in by_free(windows).items():
            some = [windows[i] for i in at]
            found = self._linearised(vector, some, free, None if states is None else states[at], own_only)
            for i, block in zip(at, found, strict=True):
                out[i] = block
        return out

    def _linearised(
        self,
        vector: Floats,
        windows: Sequence[Window],
        free: tuple[int, ...],
        states: Floats | None,
        own_only: bool,
    ) -> list[Block | None]:
        p, q = 0 if own_only else len(self.names), len(free)
        moving = [] if own_only else self.moving
        seeds = [*moving, *(len(self.names) + k for k in free)]
        places = [*moving, *range(p, p + q)]
        done = self.simulate(vector, windows, states, seeds, p + q, places)
        names = (*self.names[:p], *("",) * q)
        c = self.data[0].readings.shape[1]
        full = np.empty((int(done.offset[-1]), c, p + q + 1))
        at = 0
        for run, rows, chain in self._chains(vector, windows, done, names):
            part = full[at : at + len(chain.values)]
            weight = run.weight[rows]
            np.multiply(chain.slopes, weight[:, :, None], out=part[:, :, :-1])
            part[:, :, -1] = (run.readings[rows] - chain.values) * weight
            at += len(part)
        if p:
            values = self._parameters(vector)[1]
            scale = np.ones((len(self.data), p + q + 1))
            for number in {w.run for w in windows}:
                scale[number, :p] = [u.slope(values[number][u.name]) for u in self.order]
            for number, part_of in _runs(windows):
                full[done.offset[part_of[0]] : done.offset[part_of[-1] + 1]] *= scale[number]
        out: list[Block | None] = []
        for i in range(len(windows)):
            both = full[done.of(i)].reshape(-1, p + q + 1)
            products = both.T @ both if done.ok[i] else np.array([np.nan])
            if not np.isfinite(products).all():
                out.append(None)
                continue
            out.append(Block(both[:, -1].copy(), both[:, :p], both[:, p:-1], done.mode[done.of(i)], products))
        return out

    def _chains(
        self, vector: Floats, windows: Sequence[Window], done: Simulated, names: tuple[str, ...]
    ) -> Iterator[tuple[Data, NDArray[np.int64], Chain]]:
        """Readings of the windows, run by run: the run, its samples, and what the chain makes of them."""
        values = self._parameters(vector)[1]
        for number, part in _runs(windows):
            run = self.data[number]
            rows = np.concatenate([np.arange(windows[i].start, windows[i].stop) for i in part])
            span = slice(int(done.offset[part[0]]), int(done.offset[part[-1] + 1]))
            offset = done.offset[part[0] : part[-1] + 2] - done.offset[part[0]]
            slopes = {k: one[span] for k, one in done.slopes.items()}
            chain = read(
                run.t[rows],
                done.state[span],
                slopes,
                names,
                values[number],
                run.belt_speed,
                run.readings.shape[1],
                self.added,
                offset,
            )
            yield run, rows, chain

    def blocks(self, vector: Floats, windows: Sequence[Window]) -> list[Block] | None:
        """All windows linearised; None if more than a few cannot be simulated (those few carry a large residual)."""
        out = self.linearised(vector, windows)
        if sum(b is None for b in out) > MOST_FAILED * len(out):
            return None
        return [self._failed(w) if b is None else b for w, b in zip(windows, out, strict=True)]

    def _failed(self, window: Window) -> Block:
        m = (window.stop - window.start) * self.data[window.run].readings.shape[1]
        p, q = len(self.names), len(window.free)
        products = np.zeros((p + q + 1, p + q + 1))
        products[-1, -1] = FAILED**2 * m
        mode = np.ones(window.stop - window.start, dtype=np.int8)
        return Block(np.full(m, FAILED), np.zeros((m, p)), np.zeros((m, q)), mode, products)

    def costs(self, vector: Floats, windows: Sequence[Window]) -> Floats:
        """chi-squared by window, its own priors included; infinite throughout where too many cannot be simulated."""
        out = self.chi2(vector, windows)
        failed = np.flatnonzero(~np.isfinite(out))
        if len(failed) > MOST_FAILED * len(windows):
            return np.full(len(windows), np.inf)
        for i in failed.tolist():
            out[i] = FAILED**2 * (windows[i].stop - windows[i].start) * self.data[0].readings.shape[1]
        return out + window_penalties(windows)

    def penalty(self, vector: Floats) -> float:
        """What the weak priors of the unknowns cost."""
        return float(self.precision @ (vector - self.centre) ** 2)

    def cost(self, vector: Floats, windows: Sequence[Window]) -> float:
        """chi-squared with the weak priors; infinite where too many windows cannot be simulated."""
        total = float(self.costs(vector, windows).sum()) + self.penalty(vector)
        return total if np.isfinite(total) else np.inf


def _into(
    out: Simulated, raw: Mapping[str, object], at: NDArray[np.int64], kept: NDArray[np.int32]
) -> NDArray[np.bool_]:
    """Copy what the core made of the windows `at` into place; which of them it finished."""
    done = np.asarray(np.asarray(raw["outcome"]) == _core.Outcome.finished)
    state, slopes, mode = (np.asarray(raw[key]) for key in ("state", "slopes", "mode"))
    if len(at) == len(out.ok):
        out.state, out.mode = state, mode
        out.slopes = {int(k): slopes[i] for i, k in enumerate(kept)}
    else:
        if not out.slopes:
            out.slopes = {int(k): np.zeros((len(out.state), slopes.shape[2])) for k in kept}
        begin = 0
        for i in at.tolist():
            rows = out.of(i)
            some = slice(begin, begin + rows.stop - rows.start)
            out.state[rows], out.mode[rows] = state[some], mode[some]
            for j, k in enumerate(kept.tolist()):
                out.slopes[k][rows] = slopes[j, some]
            begin = some.stop
    for i, good in zip(at.tolist(), done.tolist(), strict=True):
        if not good:  # not all samples were written
            rows = out.of(i)
            out.state[rows], out.mode[rows] = 0.0, 0
            for one in out.slopes.values():
                one[rows] = 0.0
    return done


def _runs(windows: Sequence[Window]) -> Iterator[tuple[int, list[int]]]:
    """Stretches of windows of one run: the run and their indices."""
    for number, part in groupby(range(len(windows)), key=lambda i: windows[i].run):
        yield number, list(part)


__all__ = ["SLOTS", "Block", "Engine", "Simulated"]
