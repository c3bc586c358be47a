"""Windows of a rig on a belt linearised, each with friction and a belt speed of its own.

What a rig records, and where a window of it begins, its sensors say: see `stickslip.likelihoods.sensors`. The windows
and their simulation at one point stay in one file: each is made of the other's numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.effect import effect, tabulated
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, BlockOnBelt
from stickslip.fitted.data import Data
from stickslip.fitted.formula_reading import formulas_of
from stickslip.fitted.means import instants, pooled
from stickslip.fitted.readings import Added, Chain, Slopes, beside, curves_of, no_slopes
from stickslip.fitted.window import AUTO, STICK
from stickslip.likelihoods import belt_waves
from stickslip.likelihoods.begun import DERIVED, Past, acting, derived, lagged, simple
from stickslip.likelihoods.declared_numbers import BESIDE
from stickslip.likelihoods.event_windows import EventWindows
from stickslip.likelihoods.motion import Motion
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.likelihoods.population import STATIC, Population, start
from stickslip.likelihoods.sensors import Samples, Sensors
from stickslip.likelihoods.shared import Declared, Number
from stickslip.likelihoods.static_limit import StaticLimit
from stickslip.likelihoods.stretches import Stretch, knots, lasts, slipped
from stickslip.measured.sticks import rides
from stickslip.simulated.lowering import SLOTS, WIDTH, lower
from stickslip.simulated.states import AT, COUNT, DWELL, VISIBLE, X2, Z

Floats = NDArray[np.float64]
PROFILE = "tabulated_contact_x1"  # a window's own friction
AT_ONCE = 0.02  # time constant of a static limit that is there as soon as the block sticks
NEARBY = 1e-6  # step of the derivatives of the derived states
ALIKE = 1e-8  # of those derivatives over the largest: they are the same in all windows


class BeltWindows(EventWindows[Data, Stretch]):
    """
    The stretches of the runs of a rig on a belt; `sensors` say what it records.

    A window's own numbers are the states that it begins with, then its random effects: relative static friction, a
    relative friction curve at `policy.knots` places of x1, the belt's relative speed at as many times less its mean,
    and that mean. Where some begin in a slip, or a contact yields, the speed there is another state, as it is beyond
    what follows from the others; `loose` has it so for all. Random effects are counted from what all windows have in
    `common`, nothing unless it is given.
    """

    statics = (STATIC,)  # which random effects are a static limit's own

    def __init__(
        self,
        model: Model,
        data: Sequence[Data],
        stretches: Sequence[Stretch],
        numbers: Sequence[Number],
        declared: Declared,
        sensors: Sensors,
        policy: Policy = POLICY,
        *,
        loose: bool = False,
        common: Floats | None = None,
    ) -> None:
        super().__init__(model, data, stretches, numbers, declared, policy)
        self.sensors = sensors
        named = {one.name for one in model.effects}
        self.soft = "contact_compliance" in named  # it yields before it slips, so that it never sticks
        self.loose = loose or not all(one.stuck for one in stretches)
        self.beyond = (X2, Z) if self.soft else (X2,) if self.loose else ()
        self.begins = len(sensors.begins) + len(self.beyond)
        self.effects, self.kinetic = 2 * policy.knots + 2, slice(1, 1 + policy.knots)
        self.belt = self.effects - 1
        self.common = np.zeros(self.effects) if common is None else common
        self.added = np.zeros((len(stretches), self.effects))  # to the windows' random effects, known
        self.own, self.kinetics = self.begins + self.effects, ([*range(1, 1 + policy.knots)],)
        self.knots = [knots(run, policy) for run in data]
        self.places = [
            np.vstack([slipped(k, run), belt_waves.root(lasts(run, r, stretches), policy.knots, policy.slow)])
            for r, (k, run) in enumerate(zip(self.knots, data, strict=True))
        ]
        plain = (
            ()
            if named & {"static_aging", "contact_compliance"}
            else (effect("static_aging", dT=0.0, tau=AT_ONCE),)
        )
        self.lowered = [
            lower(
                Model(
                    _own(model.rig, run.constants),
                    friction=model.friction,
                    effects=(*model.effects, *plain, tabulated("contact", "x1", k, np.zeros(policy.knots))),
                ),
                run.belt_speed,
            )
            for k, run in zip(self.knots, data, strict=True)
        ]
        # what springs have beside alpha1 is no number of a model by itself
        self.slots = {BESIDE: (SLOTS[BESIDE],), **self.lowered[0].slots}
        self.curve = [self.slots[f"{PROFILE}.value_{i}"][0] for i in range(policy.knots)]
        self.aging = None if self.soft else tuple(self.slots[f"static_aging.{k}"][0] for k in ("dT", "tau"))
        self.limits = {sign: StaticLimit(model.friction, sign > 0) for sign in (1, -1)}
        self.formulas, self.curves = formulas_of(model), curves_of(model)
        read = {*sensors.kept(self.fixed, self.channels), *(k for one in self.formulas for k in one.states)}
        read |= {AT[one.variable] for one in self.curves if one.variable != "t"}
        self.kept = np.array(sorted(read), dtype=np.int32)

    @cached_property
    def lines(self) -> list[tuple[Floats, Floats]]:
        """The shapes of each window's own belt speed, and their integrals."""
        every = [self.data[w.run].t[w.start : w.stop] for w in self.stretches]
        shapes = [belt_waves.hats(t, self.policy.knots) for t in every]
        return [(one, belt_waves.times(t, one)) for t, one in zip(every, shapes, strict=True)]

    @cached_property
    def sampling(self) -> list[float]:
        """Time between the samples of each run, as usual."""
        return [float(np.median(np.diff(run.t))) for run in self.data]

    @property
    def beside(self) -> tuple[Added, ...]:
        """What its channels have beside the effects of the catalogue."""
        return (*self.curves, *self.formulas)

    def scatter(self) -> Population:
        """See `EventWindows.scatter`."""
        return start(self.policy)

    def first(self) -> Floats:
        """Return the windows' own numbers from the readings around their starts, (w, own)."""
        own = np.zeros((len(self.stretches), self.own))
        for row, w in zip(own, self.stretches, strict=True):
            run, state = self.data[w.run], np.zeros(COUNT)
            state[list(VISIBLE)] = run.local_state(w.start)
            for one in reversed(self.formulas):
                k = AT[one.channel]
                state[k] = one.behind(float(state[k]), float(run.t[w.start]), state)
            n = len(self.sensors.begins)
            row[:n] = state[list(self.sensors.begins)]
            if not w.stuck:
                row[n] = state[X2] - run.belt_speed
        return own

    def values(self, at: Floats, run: int) -> dict[str, float]:
        """Return all numbers of a run by name."""
        out = dict(self.fixed)
        for one, x in zip(self.numbers, at, strict=True):
            if one.run is None or one.run == run:
                out[one.name] = one.value(float(x))
        return out | dict(self.data[run].constants)

    def blocks(
        self,
        at: Floats,
        own: Floats,
        select: NDArray[np.bool_] | None = None,
        shared: Sequence[int] | None = None,
        local: bool = True,
    ) -> list[Floats | None]:
        """See `EventWindows.blocks`."""
        return self._blocks(at, own, select, range(len(self.numbers)) if shared is None else shared, local)

    def columns(self, at: Floats, own: Floats, shared: Sequence[int]) -> list[Floats | None]:
        """See `EventWindows.columns`."""
        # a gain scales what its sensor reads, the window's own belt with it
        whole = any(self.numbers[j].name in self.sensors.gains for j in shared)
        made = self._blocks(at, own, None, shared, local=False, whole=whole)
        return [None if one is None else one[:, :, :-1] for one in made]

    def _blocks(
        self,
        at: Floats,
        own: Floats,
        select: NDArray[np.bool_] | None,
        shared: Sequence[int],
        local: bool,
        whole: bool = True,
    ) -> list[Floats | None]:
        out: list[Floats | None] = [None] * len(self.stretches)
        for run, members in enumerate(self.by_run):
            chosen = members if select is None else members[select[members]]
            if len(chosen):
                with np.errstate(over="ignore", invalid="ignore"):  # such a window has failed
                    made = _Run(self, run, chosen, at, own[chosen], tuple(shared), local, whole).blocks()
                for i, block in zip(chosen, made, strict=True):
                    out[i] = block
        return out

    def motions(self, at: Floats, own: Floats) -> list[Motion | None]:
        """See `EventWindows.motions`."""
        out: list[Motion | None] = [None] * len(self.stretches)
        for run, members in enumerate(self.by_run):
            if len(members):
                with np.errstate(over="ignore", invalid="ignore"):
                    made = _Run(self, run, members, at, own[members], (), False).motions()
                for i, one in zip(members, made, strict=True):
                    out[i] = one
        return out


def _own(rig: AnyRig, constants: Mapping[str, float]) -> AnyRig:
    """A rig with constants that a run has for itself."""
    if not constants:
        return rig
    assert isinstance(rig, BlockOnBelt)
    return replace(rig, **constants)


class _Run:
    """Windows of one run at one point; `whole`: what is left of the readings is asked for, too."""

    def __init__(
        self,
        windows: BeltWindows,
        run: int,
        chosen: NDArray[np.int64],
        at: Floats,
        own: Floats,
        shared: tuple[int, ...],
        local: bool,
        whole: bool = True,
    ) -> None:
        self.of, self.run, self.at, self.local, self.whole = windows, run, at, local, whole
        self.own = own.copy()
        self.own[:, windows.begins :] += windows.common + windows.added[chosen]
        self.chosen = chosen
        self.data = windows.data[run]
        self.lowered = windows.lowered[run]
        self.places = [windows.stretches[i] for i in chosen]
        self.shared = list(shared)
        self.values = windows.values(at, run)
        self.lengths = np.array([w.stop - w.start for w in self.places])
        self.offset = np.concatenate([[0], np.cumsum(self.lengths)]).astype(np.int64)
        self.samples = np.concatenate([np.arange(w.start, w.stop) for w in self.places])
        self.slips = np.array([windows.soft or not w.stuck for w in self.places])
        self.begins = self.data.t[[w.start for w in self.places]] - self.data.half

    def active(self, j: int) -> bool:
        """Whether a shared number belongs to this run."""
        one = self.of.numbers[j]
        return one.run in (None, self.run) and one.name not in self.data.constants

    def blocks(self) -> list[Floats | None]:
        """Simulate, read, weigh."""
        p, columns = len(self.shared), len(self.shared) + (self.of.own if self.local else 0)
        seeds, owner, apart = self._seeds(columns)
        raw = self._simulated(self._derived(self.values, self.own), seeds, owner, columns + len(apart))
        slopes = {}
        for k, one in zip(self.of.kept.tolist(), np.asarray(raw["slopes"]), strict=True):
            folded = one[:, :columns]
            for i, by in self._moves_limit.items():
                folded[:, i] += one[:, p + self.of.begins] * np.repeat(by, self.lengths)
            if apart:
                self._chained(folded, one[:, columns:], apart)
            if self.local and self.of.beyond:  # what sticks has no speed of its own
                beyond = slice(p + len(self.of.sensors.begins), p + self.of.begins)
                folded[:, beyond] *= np.repeat(self.slips, self.lengths)[:, None]
            slopes[k] = folded
        names = tuple(self.of.numbers[j].name if self.active(j) else "" for j in self.shared) + ("",) * (
            columns - p
        )
        chain = self._read(np.asarray(raw["state"]), slopes, names)
        if self.whole:
            self._own_belt(chain, np.asarray(raw["state"]), np.asarray(raw["mode"]))
        self._stretched(chain)
        by = np.array([self.of.numbers[j].slope(float(self.at[j])) for j in self.shared])
        chain.slopes[:, :, : len(by)] *= by
        self._gains(chain)
        return self._weighed(chain, np.asarray(raw["outcome"]) == _core.Outcome.finished)

    def motions(self) -> list[Motion | None]:
        """Simulate and read."""
        none = np.zeros((0, WIDTH + COUNT)), np.zeros(0, dtype=np.int32)
        raw = self._simulated(self._derived(self.values, self.own), *none, 0)
        chain = self._read(state := np.asarray(raw["state"]), no_slopes(len(self.samples)), ())
        self._own_belt(chain, state, mode := np.asarray(raw["mode"]))
        self._gains(chain)
        t, done = self.data.t[self.samples], np.asarray(raw["outcome"]) == _core.Outcome.finished
        parts = zip(self.offset[:-1], self.offset[1:], done, strict=True)
        return [
            Motion(t[a:b], state[a:b], mode[a:b], chain.values[a:b]) if ok else None for a, b, ok in parts
        ]

    def _read(self, state: Floats, slopes: Slopes, names: tuple[str, ...]) -> Chain:
        """What the sensors make of the states."""
        samples = Samples(self.data.t[self.samples], state, slopes, names, self.offset)
        chain = self.of.sensors.on(self.data.constants).read(
            samples, self.values, self.data.belt_speed, self.of.channels
        )
        for one in self.of.beside:
            beside(chain, one, samples.t, state, slopes, names, self.values)
        return chain

    def _derived(self, values: dict[str, float], own: Floats) -> Floats:
        """Return the states at the start that follow from the numbers, (w, 4): see `derived`."""
        begun = np.zeros((COUNT, len(own)))
        begun[list(self.of.sensors.begins)] = own[:, : len(self.of.sensors.begins)].T
        return derived(values, begun, self.data.belt_speed, own[:, -1], self.begins, self._past)

    def _past(self, tau: float) -> Past:
        """Return what the readings tell of a lag before the windows begin."""
        run, since = self.data, np.array([w.dwell for w in self.places])
        rows = np.searchsorted(run.t, [run.t[w.start] - w.dwell for w in self.places])
        read = np.zeros((len(run.t), 2))
        read[:, : min(run.readings.shape[1], 2)] = run.readings[:, :2]
        return Past(read[rows], lagged(run.t, read, tau)[rows], since)

    def _parameters(self) -> Floats:
        """Return the core's numbers, one set a window."""
        of, same = self.of, self.lowered.parameters.copy()
        for j, one in enumerate(of.numbers):
            if self.active(j):
                value = one.value(float(self.at[j]))
                same[list(of.slots.get(one.name, ()))] = value * self.lowered.factors.get(one.name, 1.0)
        rows = np.tile(same, (len(self.places), 1))
        if of.aging is not None:
            rows[:, of.aging[0]] += self._limit * self.own[:, of.begins] / self._aged(rows[0, of.aging[1]])
        rows[:, of.curve] = self.own[:, of.begins :][:, of.kinetic]
        rows[:, SLOTS["belt_speed"]] = self.data.belt_speed * (1 + self.own[:, -1])
        return rows

    @cached_property
    def _limit(self) -> float:
        """The static limit of the law as it is here, to which a window's own is relative."""
        return self._static.at(self.values)

    @property
    def _static(self) -> StaticLimit:
        return self.of.limits[1 if self.data.belt_speed > 0 else -1]

    @cached_property
    def _moves_limit(self) -> dict[int, Floats]:
        """
        By how much of itself each shared number moves the windows' own limits, by column, (w,), where it does.

        It goes with the columns of these: asked for alone, none of a law is.
        """
        of = self.of
        if of.aging is None or not self.local:
            return {}
        own = self.own[:, of.begins] / self._aged(self.values.get("static_aging.tau", AT_ONCE)) / self._limit
        rates = {
            i: self._static.slope(self.values, of.numbers[j].name)
            for i, j in enumerate(self.shared)
            if self.active(j)
        }
        return {i: rate * own for i, rate in rates.items() if rate and own.any()}

    def _aged(self, tau: float) -> Floats:
        """Return what of a growing static limit is there at the breakaway."""
        return -np.expm1(-np.maximum([w.rest for w in self.places], AT_ONCE) / tau)

    def _simulated(
        self, derived: Floats, seeds: Floats, owner: NDArray[np.int32], columns: int
    ) -> dict[str, object]:
        """Run the core: the slopes of each seed are in the column of its owner."""
        policy = self.of.policy
        initial = np.zeros((len(self.places), COUNT))
        begins = self.of.sensors.begins
        initial[:, begins] = self.own[:, : len(begins)]
        initial[:, DERIVED] = derived
        initial[:, self.of.beyond] += self.own[:, len(begins) : self.of.begins] * self.slips[:, None]
        initial[:, DWELL] = [w.dwell for w in self.places]
        raw = self.lowered.windows(
            parameters=np.nan_to_num(self._parameters()),
            set=np.arange(len(self.places), dtype=np.int32),
            initial=np.nan_to_num(initial),
            contact=np.where(self.slips, AUTO, STICK).astype(np.int32),
            t=np.concatenate([instants(self.data, w.start, w.stop) for w in self.places]),
            offset=self.offset * (2 if self.data.half else 1),
            rtol=policy.tolerance,
            atol=0.01 * policy.tolerance,
            seeds=seeds,
            column=owner,
            columns=columns,
            kept=self.of.kept,
            max_transitions=policy.most_transitions,
            max_steps=policy.most_integration_steps,
            order=0,
            threads=1,
        )
        return dict(pooled(raw, self.data.half > 0, self.lengths))

    def _seeds(self, columns: int) -> tuple[Floats, NDArray[np.int32], list[int]]:
        """
        Return seeds, the column of each, and which of the derived states have seeds of their own after the columns.

        What moves a derived state alike in all windows moves it by its own seed.
        """
        rows: dict[int, dict[int, float]] = {}
        for i, j in enumerate(self.shared):
            name = self.of.numbers[j].name
            places = self.of.slots.get(name, ()) if self.active(j) else ()
            if places:
                weights = np.broadcast_to(self.lowered.factors.get(name, 1.0), len(places))
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
            yield of.begins, of.aging[0], self._limit
        yield from ((of.begins + 1 + k, entry, 1.0) for k, entry in enumerate(of.curve))
        yield of.own - 1, SLOTS["belt_speed"], self.data.belt_speed

    def _chained(self, folded: Floats, along: Floats, apart: list[int]) -> None:
        """Add what reaches a state through the derived states at the start that have seeds of their own."""
        for column, rate in self._rates.items():
            folded[:, column] += (along * np.repeat(rate[:, apart], self.lengths, axis=0)).sum(axis=1)

    @cached_property
    def _rates(self) -> dict[int, Floats]:
        """Derivatives of the derived states by column, (w, 4) each, where they are any."""
        out, here = {}, self._derived(self.values, self.own)
        plain = simple(self.values)
        for i, j in enumerate(() if plain else self.shared):
            name = self.of.numbers[j].name
            if name not in self.values or not self.active(j) or name in self.of.sensors.gains:
                continue
            step = NEARBY * max(abs(self.values[name]), 1e-3)
            moved = self._derived({**self.values, name: self.values[name] + step}, self.own)
            if (moved != here).any():
                out[i] = (moved - here) / step
        begins = () if plain else range(len(self.of.sensors.begins))
        for k in (*begins, self.of.own - 1) if self.local else ():
            nudge = np.zeros(self.of.own)
            nudge[k] = NEARBY
            moved = self._derived(self.values, self.own + nudge)
            out[len(self.shared) + k] = (moved - here) / NEARBY
        return out

    def _own_belt(self, chain: Chain, state: Floats, mode: NDArray[np.int8]) -> None:
        """Let the window's own belt be seen: where the block rides it, and by its own sensor."""
        v_b, k = self.data.belt_speed, self.of.policy.knots
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
            shown[1] = belt_waves.leg(shown[0], self.of.sampling[self.run], self.values, self.offset)
        if chain.values.shape[1] == 3:
            shown[2] = v_b * shapes
            chain.values[:, 2] += v_b * np.repeat(self.own[:, -1], self.lengths)
            chain.slopes[:, 2, -1:] += v_b if self.local else 0.0
        for channel, columns in shown.items():
            chain.values[:, channel] += np.einsum("nk,nk->n", columns, line)
            if self.local:
                chain.slopes[:, channel, waves] += columns

    def _stretched(self, chain: Chain) -> None:
        """Let a window's own static limit be what is there at its breakaway, however fast it grows."""
        if not self.local or self.of.aging is None:
            return
        tau = self.values.get("static_aging.tau", AT_ONCE)
        aged, rest = self._aged(tau), np.maximum([w.rest for w in self.places], AT_ONCE)
        column = len(self.shared) + self.of.begins
        chain.slopes[:, :, column] /= np.repeat(aged, self.lengths)[:, None]
        for i, j in enumerate(self.shared):
            if self.of.numbers[j].name == "static_aging.tau":
                falls = self.own[:, self.of.begins] * np.exp(-rest / tau) * rest / tau**2 / aged
                chain.slopes[:, :, i] += chain.slopes[:, :, column] * np.repeat(falls, self.lengths)[:, None]

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
        weight = self.data.weight[self.samples]
        block = np.empty((*chain.values.shape, chain.slopes.shape[2] + 1))
        np.multiply(chain.slopes, weight[:, :, None], out=block[:, :, :-1])
        block[:, :, -1] = (self.data.readings[self.samples] - chain.values) * weight
        good = done & np.isfinite(np.add.reduceat(block.sum(axis=(1, 2)), self.offset[:-1]))
        return [
            block[a:b] if ok else None
            for a, b, ok in zip(self.offset[:-1], self.offset[1:], good, strict=True)
        ]
