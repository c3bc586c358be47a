"""A sweep of a model of any rig: a member at a time through the core of general rigs, in threads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip import _core
from stickslip.declared.rig import AnyRig, DrivenSlider
from stickslip.declared.speeds import Speed
from stickslip.errors import unknown
from stickslip.simulated.bodies_lowering import LoweredBodies, lower_bodies
from stickslip.simulated.general import General
from stickslip.simulated.named_places import whole
from stickslip.simulated.simulate_bodies import split_initial
from stickslip.simulated.sweep.observables import OBSERVABLES, STATUS_FLAGS, Arrays, periodicity
from stickslip.simulated.sweep.request import Request

Floats = NDArray[np.float64]


def speed_names(rig: AnyRig) -> tuple[str, str]:
    """Return what the prescribed speeds are called: of a driven slider the second is the force of its drive."""
    return "belt_speed", "drive" if isinstance(rig, DrivenSlider) else "drive_speed"


@dataclass(frozen=True)
class ByName:
    """What `make_grid` asks of a lowered model, where every number goes by its name: one slot each."""

    known: tuple[str, ...]

    @property
    def slots(self) -> Mapping[str, tuple[int, ...]]:
        """Place of every name."""
        return {name: (i,) for i, name in enumerate(self.known)}

    def seeds(self, names: Iterable[str]) -> Floats:
        """Return a row for every name that is 1 at its place."""
        rows = []
        for name in names:
            if name not in self.known:
                raise unknown("parameter", name, self.known)
            rows.append(np.eye(len(self.known))[self.known.index(name)])
        return np.array(rows)


def named(own: General, numbers: Iterable[str]) -> ByName:
    """Return the names that a sweep may vary."""
    starts = [f"initial.{name}" for name in (*own.state_names, *own.hidden)]
    needed = [own.equations.on_belt, own.equations.driven]
    called = [own.called(key) for key in own.effects.keys]
    speeds = [key for key, used in zip(called, needed, strict=True) if used]
    return ByName((*numbers, *speeds, *starts))


@dataclass(frozen=True)
class BodiesRequest(Request):
    """A sweep through the core of general rigs; `speeds` are those of belt and drive where they do not vary."""

    speeds: tuple[Speed | None, Speed | None] = (None, None)

    @property
    def fixed_speeds(self) -> Mapping[str, object]:
        """Prescribed speeds that do not vary, by name."""
        given = {key: one for key, one in zip(self._called, self.speeds, strict=True) if one is not None}
        return {key: one.text if one.constant is None else one.constant for key, one in given.items()}

    def more_settings(self) -> Mapping[str, object]:
        """Return the prescribed speeds, which a store is known by too."""
        given = zip(self._called, self.speeds, strict=True)
        return {f"prescribed_{key}": None if one is None else one.digest for key, one in given}

    def compute(self, start: int, stop: int) -> Arrays:
        """Compute members start..stop and return their results by name, members first."""
        runs = [self._member(i) for i in range(start, stop)]
        return {
            name: np.array([one[name] for one in runs], dtype=OBSERVABLES[name].dtype)
            for name in self.observe
        }

    @cached_property
    def base(self) -> LoweredBodies:
        """The model as the core takes it, with every varied speed a number."""
        speeds = [
            0.0 if key in self._varied else one for key, one in zip(self._called, self.speeds, strict=True)
        ]
        return lower_bodies(whole(self.model, *speeds), self.model)

    @property
    def _called(self) -> tuple[str, str]:
        return speed_names(self.model.rig)

    @property
    def _varied(self) -> set[str]:
        return {one.full_name for one in self.grid.columns}

    def __getstate__(self) -> dict[str, object]:
        # what the core takes does not cross processes; it is made again
        return {name: value for name, value in self.__dict__.items() if name not in ("base", "lowered")}

    def _member(self, i: int) -> Mapping[str, object]:
        place = dict(
            zip(self.grid.sizes, (int(k) for k in np.unravel_index(i, self.grid.shape)), strict=True)
        )
        given = {one.full_name: float(one.values[place[one.dim]]) for one in self.grid.columns}
        lowered = self._lowered(given)
        own = lowered.own
        visible, hidden = split_initial(own, np.array(self.initial))
        for k, name in enumerate(own.state_names):
            visible[k] = given.get(f"initial.{name}", visible[k])
        hidden |= {name: given[f"initial.{name}"] for name in own.hidden if f"initial.{name}" in given}
        values = lowered.started(own.start(visible, hidden, 0.0))
        if lowered is self.base:
            for name in given.keys() & lowered.places.keys():
                values[lowered.layout["parameters"] + lowered.places[name]] = given[name]
        raw = _core.simulate_bodies(
            **lowered.arguments,
            values=values,
            modes=[2] * len(own.laws),
            t_start=0.0,
            t_end=self.t_end,
            t_eval=np.array([self.t_end]),
            rtol=self.rtol,
            atol=self.atol,
            locator=_core.Locator.henon,
            seeds=np.zeros((0, len(lowered.values))),
            max_transitions=self.max_transitions,
            max_steps=self.max_steps,
            after=self.after,
            extremes=not {"state_min", "state_max"}.isdisjoint(self.observe),
            work="dissipated" in self.observe,
        )
        return self._observed(raw, own)

    def _lowered(self, given: Mapping[str, float]) -> LoweredBodies:
        """Return a member as the core takes it: the same for all, but where a number of the rig or a start moves."""
        others = {name for name in given if not name.startswith("initial.")}
        own = self.base.own
        starts = any(law.states for law in own.laws) or any(push.states for push in own.effects.pushes)
        if not starts and others <= self.base.places.keys():
            return self.base
        model = self.model.replace(
            {name: size for name, size in given.items() if name in self.model.parameters}
        )
        belt, drive = (given.get(key, one) for key, one in zip(self._called, self.speeds, strict=True))
        return lower_bodies(whole(model, belt, drive), model)

    def _observed(self, raw: Mapping[str, Any], own: General) -> Mapping[str, object]:
        """Every result of a run; of one that failed its status alone."""
        order = list(own.order)
        outcome: object = raw["outcome"]
        status = STATUS_FLAGS.index(getattr(outcome, "name", "")) - 1
        reached = raw["state"][-1, order] if len(raw["t"]) else np.full(len(order), np.nan)
        out: dict[str, object] = {"status": status, "final_state": reached}
        if status:
            fills = {name: np.full(self.extra(name), OBSERVABLES[name].fill) for name in self.observe}
            return {**fills, **out}
        t, before, after = raw["transition_t"], raw["transition_before"], raw["transition_after"]
        late = t >= self.after
        left = (before == 0) & (after != 0)
        released = (left | ((before * after) < 0)) & late[
            :, None
        ]  # as the core: crossings that do not stick, too
        events = np.flatnonzero(released.any(axis=1))
        gaps = np.diff(t[events])
        points = np.full((self.points, len(order)), np.nan)
        last = events[::-1][: self.points]
        points[: len(last)] = raw["transition_state"][last][:, order]
        times = np.full(self.points, np.nan)
        times[: len(last)] = t[last]
        return out | {
            "stick_fraction": self._stuck(raw),
            "transitions": int(((before != after) & late[:, None]).sum()),
            "releases": int(released.sum()),
            "slips": int((left & late[:, None]).sum()),
            "period": float(gaps.mean()) if len(gaps) else np.nan,
            "period_spread": float(gaps.std()) if len(gaps) else np.nan,
            "periodicity": int(periodicity(points[None])[0]),
            "points": points,
            "point_time": times,
            **{name: raw[name][order] for name in ("state_min", "state_max") if len(raw[name])},
            "dissipated": float(raw["work"].sum()),
        }

    def _stuck(self, raw: Mapping[str, Any]) -> float:
        """Share of the time after `after` in stick, the mean over the rig's contacts."""
        t, modes = raw["transition_t"], raw["transition_after"]
        begins, ends = np.concatenate([[0.0], t]), np.concatenate([t, [self.t_end]])
        lasts = np.maximum(0.0, ends - np.maximum(begins, self.after))
        first = raw["transition_before"][:1] if len(t) else raw["mode"][-1:]
        stuck = np.vstack([first, modes])[:, : self.base.own.of_rig] == 0
        return float((lasts[:, None] * stuck).sum() / (self.t_end - self.after) / stuck.shape[1])


def checked_start(own: General, initial: ArrayLike | None) -> tuple[float, ...]:
    """Return the start, and the laws' states where they are given."""
    visible, hidden = split_initial(own, initial)
    return (*visible.tolist(), *hidden.values())
