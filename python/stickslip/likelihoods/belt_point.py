"""Windows of a rig on a belt at one point: what their sensors read there, and its derivatives.

The windows are of runs that are alike but for how fast their belt is (see `BeltLayout.batches`), and are simulated
together. One file, as the motion and all its derivatives share the columns of one simulation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.fitted.means import pooled
from stickslip.fitted.readings import Chain, Slopes, beside, no_slopes
from stickslip.fitted.window import AUTO, STICK
from stickslip.likelihoods import belt_waves
from stickslip.likelihoods.begun import DERIVED, acting, derived, past_of, simple
from stickslip.likelihoods.belt_layout import AT_ONCE, BeltLayout
from stickslip.likelihoods.motion import WindowMotion
from stickslip.likelihoods.sensors import Samples
from stickslip.likelihoods.static_limit import StaticLimit
from stickslip.likelihoods.threads import threads
from stickslip.measured.sticks import rides
from stickslip.simulated.lowering import SLOTS, WIDTH, simulated_windows
from stickslip.simulated.states import BELT, COUNT, DWELL, X2

Floats = NDArray[np.float64]
Values = dict[str, Any]  # numbers by name: floats, or (w,) of what each run has for itself
NEARBY = 1e-6  # step of the derivatives of the derived states
ALIKE = 1e-8  # of those derivatives over the largest: they are the same in all windows


class BeltPoint:
    """
    Chosen windows at one point.

    Parameters
    ----------
    windows, chosen : of runs that are alike; windows of a run follow one another
    at, own : coordinates of the shared numbers, and the chosen windows' own numbers
    shared : shared numbers with columns
    local : whether the windows' own numbers have columns
    whole : whether what is left of the readings is asked for, too
    """

    def __init__(
        self,
        windows: BeltLayout,
        chosen: NDArray[np.int64],
        at: Floats,
        own: Floats,
        shared: tuple[int, ...],
        local: bool,
        whole: bool = True,
    ) -> None:
        self.of, self.chosen, self.at, self.local, self.whole = windows, chosen, at, local, whole
        self.own = own.copy()
        self.own[:, windows.begins :] += windows.common + windows.added[chosen]
        self.shared = list(shared)
        self.places = [windows.stretches[i] for i in chosen]
        self.runs = np.array([w.run for w in self.places])
        self.first = windows.data[self.places[0].run]  # what is alike in all
        self.belt_speed = np.array([windows.data[r].belt_speed for r in self.runs])
        self.values = self._values()
        self.lengths = windows.sizes[chosen]
        self.offset = np.concatenate([[0], np.cumsum(self.lengths)]).astype(np.int64)
        samples = windows.samples
        self.samples = np.concatenate([samples.rows[i] for i in chosen])
        self.t = samples.t[self.samples]
        self.slips = np.array([windows.soft or not w.stuck for w in self.places])
        self.begins = self.t[self.offset[:-1]] - self.first.half

    def _values(self) -> Values:
        out: Values = dict(self.of.fixed)
        for one, x in zip(self.of.numbers, self.at, strict=True):
            value = one.value(float(x))
            if one.run is None:
                out[one.name] = value
                continue
            each = out.get(one.name, 0.0)
            each = np.full(len(self.runs), each) if isinstance(each, float) else each
            each[self.runs == one.run] = value
            out[one.name] = each
        return out | dict(self.first.constants)

    def _spread(self, each: Floats) -> Floats:
        """What windows have, (w,), at their samples."""
        return np.repeat(each, self.lengths)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the columns of shared numbers; "" where another has the same name already, or nothing moves with it."""
        out = list[str]()
        for j in self.shared:
            one = self.of.numbers[j]
            acts = one.name not in self.first.constants and (one.run is None or (self.runs == one.run).any())
            out.append(one.name if acts and one.name not in out else "")
        return tuple(out)

    def blocks(self) -> list[Floats | None]:
        """Simulate, read, weigh."""
        p, columns = len(self.shared), len(self.shared) + (self.of.own if self.local else 0)
        seeds, owner, apart = self._seeds(columns)
        raw = self._simulated(self._derived(self.values, self.own), seeds, owner, columns + len(apart))
        slopes = {}
        for k, one in zip(self.of.kept.tolist(), np.asarray(raw["slopes"]), strict=True):
            folded = one[:, :columns]
            if apart:
                self._chained(folded, one[:, columns:], apart)
            if self.local:
                folded[:, -1] *= self._spread(self.belt_speed)
                if self.of.aging is not None:
                    folded[:, p + self.of.begins] *= self._spread(self._limit)
                for i, by in self._moves_limit.items():
                    folded[:, i] += folded[:, p + self.of.begins] * self._spread(by)
                if self.of.beyond:  # what sticks has no speed of its own
                    beyond = slice(p + len(self.of.sensors.begins), p + self.of.begins)
                    folded[:, beyond] *= self._spread(self.slips)[:, None]
            slopes[k] = folded
        chain = self._read(np.asarray(raw["state"]), slopes, self.names + ("",) * (columns - p))
        if self.whole:
            self._own_belt(chain, np.asarray(raw["state"]), np.asarray(raw["mode"]))
        self._stretched(chain)
        self._by_run(chain)
        by = np.array([self.of.numbers[j].slope(float(self.at[j])) for j in self.shared])
        chain.slopes[:, :, : len(by)] *= by
        self._gains(chain)
        return self._weighed(chain, np.asarray(raw["outcome"]) == _core.Outcome.finished)

    def motions(self) -> list[WindowMotion | None]:
        """Simulate and read."""
        none = np.zeros((0, WIDTH + COUNT)), np.zeros(0, dtype=np.int32)
        raw = self._simulated(self._derived(self.values, self.own), *none, 0)
        chain = self._read(state := np.asarray(raw["state"]), no_slopes(len(self.samples)), ())
        self._own_belt(chain, state, mode := np.asarray(raw["mode"]))
        self._gains(chain)
        done = np.asarray(raw["outcome"]) == _core.Outcome.finished
        parts = zip(self.offset[:-1], self.offset[1:], done, strict=True)
        return [
            WindowMotion(self.t[a:b], state[a:b], mode[a:b], chain.values[a:b]) if ok else None
            for a, b, ok in parts
        ]

    def _read(self, state: Floats, slopes: Slopes, names: tuple[str, ...]) -> Chain:
        """What the sensors make of the states."""
        samples = Samples(self.t, state, slopes, names, self.offset)
        values: Values = {
            k: self._spread(v) if isinstance(v, np.ndarray) else v for k, v in self.values.items()
        }
        chain = self.of.sensors.on(self.first.constants).read(
            samples, values, self._spread(self.belt_speed), self.of.channels
        )
        for one in self.of.beside:
            beside(chain, one, samples.t, state, slopes, names, values)
        return chain

    def _derived(self, values: Values, own: Floats) -> Floats:
        """Return the states at the start that follow from the numbers, (w, 5): see `derived`."""
        begun = np.zeros((COUNT, len(own)))
        n = len(self.of.sensors.begins)
        begun[list(self.of.sensors.begins)] = own[:, :n].T
        if self.of.beyond:
            begun[X2] = own[:, n] * self.slips
        past = partial(past_of, self.of.data, self.places)
        return derived(values, begun, self.belt_speed, own[:, -1], self.begins, past)

    def _parameters(self) -> Floats:
        """Return the core's numbers, one set a window."""
        of, rows = self.of, np.array([self.of.made[i].parameters for i in self.chosen])
        factors = of.lowered[0].factors
        for one in {one.name: one for one in of.numbers if one.name not in self.first.constants}.values():
            value = self.values[one.name]
            each = value[:, None] if isinstance(value, np.ndarray) else value
            if places := of.slots.get(one.name):
                rows[:, places] = each * factors.get(one.name, 1.0)
        if of.aging is not None:
            rows[:, of.aging[0]] += self._limit * self.own[:, of.begins] / self._aged(rows[0, of.aging[1]])
        rows[:, of.curve] = self.own[:, of.begins :][:, of.kinetic]
        rows[:, SLOTS["belt_speed"]] = self.belt_speed * (1 + self.own[:, -1])
        return rows

    @cached_property
    def _limit(self) -> Floats:
        """The static limit of the law as it is here, to which a window's own is relative, (w,)."""
        return self._each_way(lambda one: one.at(self.values))

    def _each_way(self, of: Callable[[StaticLimit], float]) -> Floats:
        """A number of each window's static limit, which depends on the way its belt goes, (w,)."""
        forward = self.belt_speed > 0
        ways = {way: of(self.of.limits[1 if way else -1]) for way in set(forward.tolist())}
        return np.array([ways[way] for way in forward.tolist()])

    @cached_property
    def _moves_limit(self) -> dict[int, Floats]:
        """
        By how much of itself each shared number moves the windows' own limits, by column, (w,), where it does.

        It goes with the columns of these: asked for alone, none of a law is.
        """
        of = self.of
        if of.aging is None or not self.local:
            return {}
        own = self.own[:, of.begins] / self._aged(self._growth) / self._limit
        if not own.any():
            return {}
        slopes = {
            i: self._each_way(lambda one, name=name: one.slope(self.values, name))  # type: ignore[misc]
            for i, name in enumerate(self.names)
            if name
        }
        return {i: rate * own for i, rate in slopes.items() if rate.any()}

    @property
    def _growth(self) -> float:
        """Time constant of the static limit's growth."""
        return float(self.values.get("static_aging.tau", AT_ONCE))

    def _aged(self, tau: float) -> Floats:
        """Return what of a growing static limit is there at the breakaway."""
        return -np.expm1(-np.maximum([w.rest for w in self.places], AT_ONCE) / tau)

    def _simulated(
        self, derived: Floats, seeds: Floats, owner: NDArray[np.int32], columns: int
    ) -> dict[str, object]:
        """Run the core: the slopes of each seed are in the column of its owner."""
        policy, half = self.of.policy, self.first.half > 0
        initial = np.zeros((len(self.places), COUNT))
        begins = self.of.sensors.begins
        initial[:, begins] = self.own[:, : len(begins)]
        initial[:, DERIVED] = derived
        initial[:, self.of.beyond] += self.own[:, len(begins) : self.of.begins] * self.slips[:, None]
        initial[:, DWELL] = [w.dwell for w in self.places]
        onward = self.of.onward[self.chosen]
        # what sticks rides a belt that droops as it did
        initial[:, X2] += np.nan_to_num(onward[:, BELT] - initial[:, BELT])
        initial = np.where(np.isnan(onward), initial, onward)
        raw = simulated_windows(
            [self.of.made[i] for i in self.chosen],
            parameters=np.nan_to_num(self._parameters()),
            set=np.arange(len(self.places), dtype=np.int32),
            initial=np.nan_to_num(initial),
            contact=np.where(self.slips, AUTO, STICK).astype(np.int32),
            t=np.concatenate([self.of.samples.instants[i] for i in self.chosen]),
            offset=self.offset * (2 if half else 1),
            rtol=policy.tolerance,
            atol=0.01 * policy.tolerance,
            seeds=seeds,
            column=owner,
            columns=columns,
            kept=self.of.kept,
            max_transitions=policy.most_transitions,
            max_steps=policy.most_integration_steps,
            order=0,
            threads=threads(),
        )
        return dict(pooled(raw, half, self.lengths))

    def _seeds(self, columns: int) -> tuple[Floats, NDArray[np.int32], list[int]]:
        """
        Return seeds, the column of each, and which of the derived states have seeds of their own after the columns.

        What moves a derived state alike in all windows moves it by its own seed. The columns of the windows' own belts
        and static limits are of a speed and a limit that are not relative.
        """
        rows: dict[int, dict[int, float]] = {}
        for i, name in enumerate(self.names):
            if places := self.of.slots.get(name, ()):
                weights = np.broadcast_to(self.of.lowered[0].factors.get(name, 1.0), len(places))
                rows[i] = dict(zip(places, weights.tolist(), strict=True))
        if self.local:
            rows |= {len(self.shared) + k: {entry: size} for k, entry, size in self._entries()}
        apart = list[int]()
        for place in acting(self.values):
            state = WIDTH + DERIVED[place]
            moved = {i: rate[:, place] for i, rate in self._rates.items() if rate[:, place].any()}
            if any(np.ptp(rate) > ALIKE * np.abs(rate).max() for rate in moved.values()):
                rows[columns + len(apart)] = {state: 1.0}
                apart.append(place)
                continue
            for i, rate in moved.items():
                rows.setdefault(i, {})[state] = float(rate.mean())
        seeds = np.zeros((len(rows), WIDTH + COUNT))
        for row, entries in zip(seeds, rows.values(), strict=True):
            row[[*entries]] = [*entries.values()]
        return seeds, np.array([*rows], dtype=np.int32), apart

    def _entries(self) -> Iterator[tuple[int, int, float]]:
        """Own numbers that are numbers of the core: which, where, and how large one is there."""
        of = self.of
        yield from ((k, WIDTH + state, 1.0) for k, state in enumerate((*of.sensors.begins, *of.beyond)))
        if of.aging is not None:
            yield of.begins, of.aging[0], 1.0
        yield from ((of.begins + 1 + k, entry, 1.0) for k, entry in enumerate(of.curve))
        yield of.own - 1, SLOTS["belt_speed"], 1.0

    def _chained(self, folded: Floats, along: Floats, apart: list[int]) -> None:
        """Add what reaches a state through the derived states at the start that have seeds of their own."""
        for column, rate in self._rates.items():
            folded[:, column] += (along * np.repeat(rate[:, apart], self.lengths, axis=0)).sum(axis=1)

    @cached_property
    def _rates(self) -> dict[int, Floats]:
        """Derivatives of the derived states by column, (w, 5) each, where they are any."""
        out = {}
        plain, last = simple(self.values), len(self.shared) + self.of.own - 1
        if plain:  # the speed is the belt's
            return {last: np.tile(np.eye(len(DERIVED))[0], (len(self.own), 1))} if self.local else {}
        here = self._derived(self.values, self.own)
        for i, name in enumerate(self.names):
            if name not in self.values or name in self.of.sensors.gains:
                continue
            step = NEARBY * np.maximum(np.abs(self.values[name]), 1e-3)
            moved = self._derived({**self.values, name: self.values[name] + step}, self.own)
            if (moved != here).any():
                out[i] = (moved - here) / np.reshape(step, (-1, 1))
        states = len(self.of.sensors.begins) + bool(self.of.beyond)
        for k in (*range(states), self.of.own - 1) if self.local else ():
            nudge = np.zeros(self.of.own)
            nudge[k] = NEARBY
            out[len(self.shared) + k] = (self._derived(self.values, self.own + nudge) - here) / NEARBY
        if self.local:
            out[last] /= self.belt_speed[:, None]
        return out

    def _own_belt(self, chain: Chain, state: Floats, mode: NDArray[np.int8]) -> None:
        """Let the window's own belt be seen: where the block rides it, and by its own sensor."""
        v_b, k = self._spread(self.belt_speed), self.of.policy.knots
        waves = slice(chain.slopes.shape[2] - 1 - k, chain.slopes.shape[2] - 1)
        shapes, passed = (
            np.concatenate(one) for one in zip(*(self.of.lines[i] for i in self.chosen), strict=True)
        )
        line = np.repeat(self.own[:, -1 - k : -1], self.lengths, axis=0)
        if not self.local:  # the line itself is all that is asked for
            shapes, passed = (np.einsum("nk,nk->n", one, line)[:, None] for one in (shapes, passed))
            line = np.ones((len(line), 1))
        rode = ~rides(state[:, X2], v_b) if self.of.soft else mode
        shown = {0: belt_waves.ridden(state[:, X2], rode, v_b, passed, self.offset[:-1])}
        if "alpha2" in self.values:
            shown[1] = self._leg(shown[0])
        if chain.values.shape[1] == 3:
            shown[2] = v_b[:, None] * shapes
            chain.values[:, 2] += self._spread(self.belt_speed * self.own[:, -1])
            chain.slopes[:, 2, -1:] += v_b[:, None] if self.local else 0.0
        for channel, columns in shown.items():
            chain.values[:, channel] += np.einsum("nk,nk->n", columns, line)
            if self.local:
                chain.slopes[:, channel, waves] += columns

    def _leg(self, place: Floats) -> Floats:
        """What the leg makes of the block's place, (n, k), of runs that are sampled alike at once."""
        out = np.empty_like(place)
        steps = np.array([self.of.sampling[r] for r in self.runs])
        first = np.flatnonzero(np.diff(steps, prepend=-1.0))
        for a, b in zip(first, [*first[1:], len(steps)], strict=True):
            part, offset = slice(self.offset[a], self.offset[b]), self.offset[a : b + 1] - self.offset[a]
            out[part] = belt_waves.leg(place[part], float(steps[a]), self.values, offset)
        return out

    def _stretched(self, chain: Chain) -> None:
        """Let a window's own static limit be what is there at its breakaway, however fast it grows."""
        if not self.local or self.of.aging is None:
            return
        tau = self._growth
        aged, rest = self._aged(tau), np.maximum([w.rest for w in self.places], AT_ONCE)
        column = len(self.shared) + self.of.begins
        chain.slopes[:, :, column] /= self._spread(aged)[:, None]
        if "static_aging.tau" in self.names:
            falls = self.own[:, self.of.begins] * np.exp(-rest / tau) * rest / tau**2 / aged
            i = self.names.index("static_aging.tau")
            chain.slopes[:, :, i] += chain.slopes[:, :, column] * self._spread(falls)[:, None]

    def _by_run(self, chain: Chain) -> None:
        """Give numbers that each run has for itself their columns: those of their name where they are the run's."""
        for i, name in enumerate(self.names):
            if name and self.of.numbers[self.shared[i]].run is not None:
                of_name = chain.slopes[:, :, i].copy()
                for column, j in enumerate(self.shared):
                    one = self.of.numbers[j]
                    if one.name == name:
                        chain.slopes[:, :, column] = of_name * self._spread(self.runs == one.run)[:, None]

    def _gains(self, chain: Chain) -> None:
        for c, name in enumerate(self.of.sensors.gains):
            if name not in self.values or c >= chain.values.shape[1]:
                continue
            gain = 1.0 + self.values[name]
            plain = chain.values[:, c].copy()
            chain.values[:, c] *= gain
            chain.slopes[:, c] *= gain
            for i, j in enumerate(self.shared):
                if self.of.numbers[j].name == name:
                    chain.slopes[:, c, i] = plain

    def _weighed(self, chain: Chain, done: NDArray[np.bool_]) -> list[Floats | None]:
        weight, readings = (getattr(self.of.samples, name)[self.samples] for name in ("weight", "readings"))
        block = np.empty((*chain.values.shape, chain.slopes.shape[2] + 1))
        np.multiply(chain.slopes, weight[:, :, None], out=block[:, :, :-1])
        block[:, :, -1] = (readings - chain.values) * weight
        rows = block.reshape(len(block), -1)
        good = done & np.isfinite(np.add.reduceat(rows @ np.ones(rows.shape[1]), self.offset[:-1]))
        return [
            block[a:b] if ok else None
            for a, b, ok in zip(self.offset[:-1], self.offset[1:], good, strict=True)
        ]
