"""Windows of a rig on a belt, each with friction and a belt speed of its own: what they are made of.

What a rig records, and where a window of it begins, its sensors say: see `stickslip.likelihoods.sensors`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated, effect
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, BlockOnBelt
from stickslip.fitted.data import Data
from stickslip.fitted.formula_reading import formulas_of
from stickslip.fitted.readings import Added, curves_of
from stickslip.likelihoods import belt_waves
from stickslip.likelihoods.declared_numbers import BESIDE
from stickslip.likelihoods.event_windows import EventWindows
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.likelihoods.pooled_samples import PooledSamples
from stickslip.likelihoods.population import STATIC, Population, start
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.shared import Declared, SharedNumber
from stickslip.likelihoods.static_limit import StaticLimit
from stickslip.likelihoods.stretches import Stretch, knots, lasts, slipped
from stickslip.simulated.lowering import SLOTS, Lowered, lower
from stickslip.simulated.states import AT, COUNT, VISIBLE, X2, Z

Floats = NDArray[np.float64]
AT_ONCE = 0.02  # time constant of a static limit that is there as soon as the block sticks


@dataclass(frozen=True)
class _OwnFriction(Tabulated):
    """A window's own friction, by whatever variable: no curve of the model."""

    name = "own_friction"


class BeltLayout(EventWindows[Data, Stretch]):
    """
    The stretches of the runs of a rig on a belt; `sensors` say what it records.

    A window's own numbers are the states that it begins with, then its random effects: relative static friction, a
    relative friction curve at `policy.knots` places of x1, the belt's relative speed at as many times less its mean,
    and that mean. In a slip that goes on the block passes a place again and again: there the curve is one of time.
    Where some begin in a slip, or a contact yields, the speed there is another state, as it is beyond what follows from
    the others; `loose` has it so for all. Random effects are counted from what all windows have in `common`, nothing
    unless it is given. A window that goes on from a motion has that one's hidden states, (w, states): `onward`, NaN
    where they follow from numbers and readings.
    """

    statics = (STATIC,)  # which random effects are a static limit's own

    def __init__(
        self,
        model: Model,
        data: Sequence[Data],
        stretches: Sequence[Stretch],
        numbers: Sequence[SharedNumber],
        declared: Declared,
        sensors: Sensors,
        policy: Policy = POLICY,
        *,
        loose: bool = False,
        common: Floats | None = None,
        onward: Floats | None = None,
    ) -> None:
        super().__init__(model, data, stretches, numbers, declared, policy)
        self.onward = np.full((len(stretches), COUNT), np.nan) if onward is None else onward
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
        self.models = [
            Model(_own(model.rig, run.constants), friction=model.friction, effects=(*model.effects, *plain))
            for run in data
        ]
        self.lowered = [self._lowered(r, "x1", self.knots[r]) for r in range(len(data))]
        self.made = [self.lowered[w.run] if w.stuck else self._in_time(w) for w in stretches]
        # what springs have beside alpha1 is no number of a model by itself
        self.slots = {BESIDE: (SLOTS[BESIDE],), **self.lowered[0].slots}
        self.curve = [self.slots[f"{_OwnFriction.name}.value_{i}"][0] for i in range(policy.knots)]
        self.aging = None if self.soft else tuple(self.slots[f"static_aging.{k}"][0] for k in ("dT", "tau"))
        self.limits = {sign: StaticLimit(model.friction, sign > 0) for sign in (1, -1)}
        self.formulas, self.curves = formulas_of(model), curves_of(model)
        read = {*sensors.kept(self.fixed, self.channels), *(k for one in self.formulas for k in one.states)}
        read |= {AT[one.variable] for one in self.curves if one.variable != "t"}
        self.kept = np.array(sorted(read), dtype=np.int32)
        self.samples = PooledSamples.of(data, stretches)

    def _lowered(self, run: int, variable: str, knots: Floats) -> Lowered:
        """The model of a run, with what a window's own friction depends on."""
        model = self.models[run]
        own = _OwnFriction("contact", variable, tuple(knots.tolist()), (0.0,) * len(knots))
        return lower(replace(model, effects=(*model.effects, own)), self.data[run].belt_speed)

    def _in_time(self, w: Stretch) -> Lowered:
        t = self.data[w.run].t
        return self._lowered(w.run, "t", np.linspace(t[w.start], t[w.stop - 1], self.policy.knots))

    @cached_property
    def batches(self) -> list[NDArray[np.int64]]:
        """
        Windows by runs that are alike but for how fast their belt is: they are simulated together.

        They have the same constants, and readings of one kind.
        """
        alike: dict[Any, list[int]] = {}
        for run, members in enumerate(self.by_run):
            one = self.data[run]
            constants = tuple(sorted(one.constants.items()))
            for i in members.tolist():
                apart = id(self.made[i]) if self.made[i].tapes is not None else -1
                alike.setdefault((constants, one.half > 0, apart), []).append(i)
        return [np.array(every, dtype=np.int64) for every in alike.values()]

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

    def first(self, at: Floats | None = None) -> Floats:  # noqa: ARG002  # all is read
        """See `EventWindows.first`."""
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


def _own(rig: AnyRig, constants: Mapping[str, float]) -> AnyRig:
    """A rig with constants that a run has for itself."""
    if not constants:
        return rig
    assert isinstance(rig, BlockOnBelt)
    return replace(rig, **constants)
