"""Windows of a rig of bodies or matrices linearised, each with friction and a belt speed of its own.

Where a window begins, a contact that sticks moves with what it rubs on; all else of the state there is free. Friction
of each contact differs from window to window, the static limit beside the kinetic force, and so does the belt's speed
where it is a number or was measured. Derivatives are the core's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.bodies_model import law_of
from stickslip.declared.model import Model
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.bodies_cuts import Cut
from stickslip.likelihoods.bodies_effects import Beginnings, Reads
from stickslip.likelihoods.bodies_law_states import LawStates, refuse_hidden
from stickslip.likelihoods.bodies_own_friction import OFF, lowered, places_of
from stickslip.likelihoods.bodies_readings import gained, sensor_rows, shifted
from stickslip.likelihoods.bodies_release import let_go
from stickslip.likelihoods.bodies_starts import BodiesStart, most_steps, resolved, scales_of, start_of
from stickslip.likelihoods.contact_scatter import OWN, ContactScatter, differing, kinds
from stickslip.likelihoods.event_windows import EventWindows
from stickslip.likelihoods.motion import WindowMotion
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.likelihoods.shared import Declared, SharedNumber
from stickslip.simulated.sensed import everything, everything_moves, weights_move

Floats = NDArray[np.float64]
BELT = "belt_speed"
BELT_OFF = "belt_off"  # by what share a run's belt is faster than set


class BodiesWindows(EventWindows[BodiesData, Cut]):
    """
    The windows of the runs under a model whose friction and belt differ from window to window.

    What they share are numbers of the laws, of the rig over what is declared of them, and gains.

    A window's own numbers are the state that it begins with, (q, v) in units of how far the run moves, of v what no
    contact in stick takes, and states of laws; then its random effects: of each contact relative kinetic and static
    friction, and the belt's relative speed.
    """

    def __init__(
        self,
        model: Model,
        data: Sequence[BodiesData],
        stretches: Sequence[Cut],
        numbers: Sequence[SharedNumber],
        declared: Declared,
        policy: Policy = POLICY,
    ) -> None:
        assert isinstance(model.rig, GeneralRig)
        super().__init__(model, data, stretches, numbers, declared, policy)
        self.rig = model.rig
        self.gains = tuple(f"gain.{name}" for name in data[0].channels)
        self.lowered = [lowered(model, run) for run in data]
        own = self.lowered[0].own
        self.dimension = len(own.equations.names)
        plain = [law_of(model.friction, one).form() for one in self.rig.equations.contacts]
        self.of_laws = LawStates(own, plain)
        refuse_hidden(self.of_laws.laws)
        self.law_states = self.of_laws.every(self.data, self.stretches)
        self.begins = 2 * self.dimension + self.of_laws.count
        moves = own.equations.on_belt and any(run.belt.constant != 0 for run in data)
        self.differs = differing(own, moves)
        self.effects = len(self.differs.of)
        self.own = self.begins + self.effects
        laws = own.laws[: own.of_rig]
        contacts = [j for j, law in enumerate(laws) for _ in kinds(law)]
        # of each effect; the belt is no contact
        self.contact_of = (*contacts, *[-1] * (self.effects - len(contacts)))
        self.statics = tuple(
            k for k, one in enumerate(self.differs.of) if self.differs.names[one].endswith(".static")
        )
        kinetic = [k for k, one in enumerate(self.differs.of) if self.differs.names[one].endswith(".kinetic")]
        self.kinetic = slice(kinetic[0], kinetic[0] + 1) if kinetic else slice(0, 0)
        self.kinetics = tuple([k] for k in kinetic)
        self.places = [np.zeros(0)] * len(self.data)
        self.scales = [scales_of(run) for run in data]
        self.reads = places_of(data[0].reads, own.equations.names)
        self.sensed = tuple(name for name in data[0].reads if name in own.equations.sensed)
        self.offsets = tuple(f"offset.{name}" for name in data[0].channels)
        self.begun = [Beginnings(one, run) for one, run in zip(self.lowered, self.data, strict=True)]
        self.through = [Reads(one, data[0].channels) for one in self.lowered]

    def scatter(self) -> ContactScatter:
        """See `EventWindows.scatter`."""
        return self.differs.moved(self.differs.usual(self.policy)[0])

    @cached_property
    def starts(self) -> list[BodiesStart]:
        """How each window's state at its start follows from its own numbers."""
        out = []
        for w in self.stretches:
            run, own = self.data[w.run], self.lowered[w.run].own.equations
            laws = self.lowered[w.run].own.laws
            rows = [j for j, mode in enumerate(w.modes) if mode == 0 and not laws[j].compliant]
            D = own.directions[rows]
            belted = np.array([own.contacts[j].against == "belt" for j in rows], dtype=float)
            out.append(start_of(D, belted * float(run.belt(run.t[w.start])), self.scales[w.run]))
        return out

    def first(self, at: Floats | None = None) -> Floats:
        """See `EventWindows.first`; of the motion that the readings show."""
        model = self.model if at is None else self.at_numbers(at)
        out = np.zeros((len(self.stretches), self.own))
        n = self.dimension
        for row, w, start in zip(out, self.stretches, self.starts, strict=True):
            run = self.data[w.run]
            row[:n] = (run.q[w.start] + let_go(run, w, self.lowered[w.run].own, model)) / start.scale_q
            row[n : 2 * n] = start.free.T @ ((run.v[w.start] - start.held) / start.scale_v)
        return out

    def at_numbers(self, at: Floats) -> Model:
        """The model with laws as fitted; as declared where a fit has gone where no law is."""
        laws, model = self.model.friction.numbers, self.model
        with suppress(InputError):
            model = model.replace({name: x for name, x in self.values(at).items() if name in laws})
        return model

    def values(self, at: Floats, run: int = 0) -> dict[str, float]:
        """Return all numbers of a run by name."""
        out = dict(self.fixed)
        for one, x in zip(self.numbers, at, strict=True):
            if one.run not in (None, run):
                continue
            size = one.value(float(x))
            for name in self._tied(one.name):
                out[name] = self.fixed[name] * size
            if one.name not in self.of_rig:
                out[one.name] = size
        return out

    @cached_property
    def of_rig(self) -> dict[str, Floats]:
        """What the core's values move by with each constant of the rig over what is declared; they are linear in it."""
        return {
            one.name: self.lowered[0].moves(self._tied(one.name))
            for one in self.numbers
            if one.name in self.rig.uncertain
        }

    @cached_property
    def rows_move(self) -> dict[str, dict[str, Floats]]:
        """What rows of weights of sensors move by with each constant of the rig over what is declared."""
        return {name: weights_move(self.lowered[0], self._tied(name), relative=True) for name in self.of_rig}

    def _tied(self, name: str) -> tuple[str, ...]:
        return self.rig.tied(name) if name in self.rig.uncertain else ()

    def blocks(
        self,
        at: Floats,
        own: Floats,
        select: NDArray[np.bool_] | None = None,
        shared: Sequence[int] | None = None,
        local: bool = True,
    ) -> list[Floats | None]:
        """See `EventWindows.blocks`."""
        columns = list(range(len(self.numbers)) if shared is None else shared)
        points = [RunWindows(self, run, at, columns) for run in range(len(self.data))]
        return [
            points[w.run].block(i, own[i], local) if select is None or select[i] else None
            for i, w in enumerate(self.stretches)
        ]

    def motions(self, at: Floats, own: Floats) -> list[WindowMotion | None]:
        """See `EventWindows.motions`."""
        points = [RunWindows(self, run, at, []) for run in range(len(self.data))]
        return [points[w.run].motion(i, own[i]) for i, w in enumerate(self.stretches)]


class RunWindows:
    """The windows of one run at one point of the shared numbers."""

    def __init__(self, windows: BodiesWindows, run: int, at: Floats, shared: list[int]) -> None:
        self.of, self.run, self.at, self.shared = windows, run, at, shared
        self.data, self.lowered = windows.data[run], windows.lowered[run]
        self.base = self._values()
        self.rows = [self._row(j) for j in shared]
        self.begins, self.reads = windows.begun[run], windows.through[run]

    def _values(self) -> Floats:
        """The core's numbers, the windows' own apart."""
        of, out = self.of, self.lowered.values.copy()
        for one, x in zip(of.numbers, self.at, strict=True):
            if one.run not in (None, self.run):
                continue
            size = one.value(float(x))
            if one.name in of.of_rig:
                out += (size - 1.0) * self._of_rig(one.name)
            elif one.name in self.lowered.places:
                out[self._place(one.name)] = size
        return out

    def _of_rig(self, name: str) -> Floats:
        """What the values move by with a constant of the rig; runs differ in the numbers that follow the rig's."""
        rig = self.lowered.layout["parameters"]
        return np.pad(self.of.of_rig[name][:rig], (0, len(self.lowered.values) - rig))

    def _place(self, name: str) -> int:
        return self.lowered.layout["parameters"] + self.lowered.places[name]

    def _row(self, j: int) -> Floats | None:
        """Seed of a shared number; None where the motion does not depend on it."""
        one = self.of.numbers[j]
        if one.run not in (None, self.run):
            return None
        if one.name in self.of.of_rig:
            return self._of_rig(one.name)
        if one.name == BELT_OFF:
            return np.zeros(len(self.base))  # as each window's own belt does, which moves its start too
        if one.name not in self.lowered.places:
            return None
        row = np.zeros(len(self.base))
        row[self._place(one.name)] = one.usual
        return row

    @cached_property
    def units(self) -> Floats:
        """What the seeds of the shared numbers that move anything are in units of, those of its own beside them."""
        of, apart = self.of, (*self.of.of_rig, BELT_OFF)
        moving = [of.numbers[j] for j, row in zip(self.shared, self.rows, strict=True) if row is not None]
        return np.array([1.0 if one.name in apart else one.usual for one in moving] + [1.0] * of.own)

    def _own_rows(self, i: int) -> tuple[Floats, Floats]:
        """Seeds of a window's own numbers, (own, size); what of the start they do not move is in the values."""
        of, n, start = self.of, self.of.dimension, self.of.starts[i]
        about, sizes = of.law_states
        rows = np.zeros((of.own, len(self.base)))
        begin = self.lowered.layout["initial"]
        rows[range(n), range(begin, begin + n)] = start.scale_q
        rows[n : 2 * n, begin + n : begin + 2 * n] = (start.scale_v[:, None] * start.free).T
        offset = np.zeros(len(self.base))
        hidden = range(begin + 2 * n, begin + of.begins)
        rows[range(2 * n, of.begins), hidden], offset[hidden] = sizes, about[i]
        for k, place in enumerate(self.effect_places):
            row = rows[of.begins + k]
            if place is None:
                speed = self.data.belt.constant
                row[self._place(OFF if speed is None else BELT)] = 1.0 if speed is None else speed
                row[begin + n : begin + 2 * n] = start.held  # linear in the belt's speed
            else:
                row[place] = 1.0
        offset[begin + n : begin + 2 * n] = start.held
        return rows, offset

    @cached_property
    def belt_off(self) -> float:
        """By what share the run's belt is faster than set."""
        of = self.of.numbers
        return sum(
            float(x)
            for one, x in zip(of, self.at, strict=True)
            if one.name == BELT_OFF and one.run == self.run
        )

    @cached_property
    def named(self) -> dict[str, float]:
        """Numbers of effects by name."""
        return {name: float(self.base[self._place(name)]) for name in self.lowered.own.effects.numbers}

    @cached_property
    def effect_places(self) -> list[int | None]:
        """Places of the random effects among the values; None of the belt's."""
        out: list[int | None] = []
        for j, law in enumerate(self.lowered.own.laws[: self.lowered.own.of_rig]):
            for kind in kinds(law):
                name = next(name for name in self.lowered.places if name.endswith(f"{OWN[kind]}{j}"))
                out.append(self._place(name))
        return out + [None] * (self.of.effects - len(out))

    def started(self, i: int, own: Floats) -> tuple[Floats, Floats]:
        """Return the core's numbers at the start of a window, and seeds: of shared numbers, then of its own."""
        w = self.of.stretches[i]
        rows, offset = self._own_rows(i)
        belt = [self.of.numbers[j].name == BELT_OFF for j in self.shared]
        values = self.base + offset + own @ rows + self.belt_off * rows[-1]
        moved = [
            rows[-1] if off else row for row, off in zip(self.rows, belt, strict=True) if row is not None
        ]
        seeds = np.concatenate([np.array(moved).reshape(-1, len(values)), rows])
        layout = self.lowered.layout
        self.begins.put(values, seeds, float(self.data.t[w.start]))
        values[layout["dwell"] : layout["dwell"] + len(w.dwell)] = w.dwell
        return values, seeds

    def _simulated(self, i: int, own: Floats, seeds: bool) -> tuple[Mapping[str, Any], bool]:
        """Run the core from the start of a window; whether it came to the end."""
        of, w = self.of, self.of.stretches[i]
        # where some is not finite the window fails anyway
        values, rows = map(np.nan_to_num, self.started(i, own))
        t = self.data.t[w.start : w.stop]
        raw: Mapping[str, Any] = _core.simulate_bodies(
            **self.lowered.arguments,
            values=values,
            modes=self.lowered.own.modes(w.modes),
            t_start=float(t[0]),
            t_end=float(t[-1]),
            t_eval=t,
            rtol=of.policy.tolerance,
            atol=resolved(of.scales[self.run], of.policy),
            locator=_core.Locator.henon,
            seeds=rows if seeds else rows[: len(rows) - of.own],
            max_transitions=of.policy.most_transitions,
            max_steps=most_steps(float(t[-1] - t[0]), self.data, of.policy, of.of_laws.count > 0),
            sensed=bool(of.sensed),
        )
        done = raw["outcome"] == _core.Outcome.finished and len(raw["t"]) == len(t)
        slopes = [name for name in ("sensitivity", "sensed_sensitivity") if name in raw]
        return {**raw, **{name: raw[name] / self.units[: raw[name].shape[2]] for name in slopes}}, done

    def read(self, raw: Mapping[str, Any], own: Floats, local: bool) -> tuple[Floats, Floats]:
        """Return readings (n, channels) and their slopes (n, channels, columns)."""
        of = self.of
        state, slopes = raw["state"], raw["sensitivity"]
        n, count = len(state), len(self.shared) + (of.own if local else 0)
        read, by = np.zeros((n, of.channels)), np.zeros((n, of.channels, count))
        active = [i for i, row in enumerate(self.rows) if row is not None]
        active += range(len(self.shared), count)
        every, moves = (everything(raw), everything_moves(raw)) if of.sensed else (state, slopes)
        for c, place in enumerate(of.reads):
            if c in self.reads.trees:
                read[:, c], by[:, c, active], named = self.reads.read(c, raw["t"], state, slopes, self.named)
                for i, j in enumerate(self.shared):
                    if self.rows[i] is not None and of.numbers[j].name in named:
                        by[:, c, i] += named[of.numbers[j].name]
            elif isinstance(place, int):
                read[:, c] = state[:, place]
                by[:, c, active] = slopes[:, place]
            elif place in of.sensed:
                row, moved = self.rows_of_sensors[place]
                read[:, c] = every @ row
                by[:, c, active] = row @ moves
                for i, one in moved.items():
                    by[:, c, i] += every @ one
            else:
                self._belt(c, raw["t"], own, read, by, local)
        gained(read, by, of.gains, of.numbers, self.at, self.shared)
        shifted(read, by, of.offsets, of.numbers, self.at, self.shared)
        for i, j in enumerate(self.shared):
            by[:, :, i] *= of.numbers[j].slope(float(self.at[j]))
        return read, by

    @cached_property
    def rows_of_sensors(self) -> dict[str, tuple[Floats, dict[int, Floats]]]:
        """Rows of what is sensed beside the state, and what they move by with shared numbers, by column."""
        of = self.of
        return sensor_rows(self.lowered, of.sensed, of.numbers, self.at, self.shared, of.rows_move)

    def _belt(self, c: int, t: Floats, own: Floats, read: Floats, by: Floats, local: bool) -> None:
        """The belt's own sensor sees the window's own belt, and what effects make of it."""
        speed = self.data.belt(t)
        wobbles = self.of.differs.names[-1] == "belt"
        faster = 1.0 + self.belt_off + (own[-1] if wobbles else 0.0)
        factor, moves = self.begins.rippling(BELT, {**self.named, "t": t})
        read[:, c] = speed * factor * faster
        for i, j in enumerate(self.shared):
            if self.rows[i] is not None and (name := self.of.numbers[j].name) in (BELT_OFF, *moves):
                by[:, c, i] = speed * (factor if name == BELT_OFF else moves[name] * faster)
        if local and wobbles:
            by[:, c, -1] = speed * factor

    def block(self, i: int, own: Floats, local: bool) -> Floats | None:
        """Simulate, read, weigh."""
        w = self.of.stretches[i]
        raw, done = self._simulated(i, own, local)
        if not done:
            return None
        read, by = self.read(raw, own, local)
        part = slice(w.start, w.stop)
        out = np.concatenate([by, (self.data.readings[part] - read)[:, :, None]], axis=2)
        out *= self.data.weight[part][:, :, None]
        return out if np.isfinite(out).all() else None

    def motion(self, i: int, own: Floats) -> WindowMotion | None:
        """Simulate and read."""
        raw, done = self._simulated(i, own, False)
        if not done:
            return None
        mode = raw["mode"][:, : self.lowered.own.of_rig].astype(np.int8)
        return WindowMotion(raw["t"], raw["state"], mode, self.read(raw, own, False)[0])
