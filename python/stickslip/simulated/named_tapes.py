"""A named rig with effects by formulas, simulated by the core of general rigs in the numbers of its own core.

Fits of named rigs hand numbers, states and seeds over in one row, whose places `lowering` knows. Where a formula acts,
`Tapes` turns that row into the one of the core for general rigs, which is linear in it, and hands the states back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.effect import AnyEffect, FormulaEffect, Tabulated
from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.tree import names
from stickslip.declared.formula.value import value
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.simulated.bodies_lowering import LoweredBodies, lower_bodies
from stickslip.simulated.named_places import LAGGED as SEEN_LATE
from stickslip.simulated.named_places import coefficients, named, parts
from stickslip.simulated.states import AT, COUNT, DWELL, LAGGED

Floats = NDArray[np.float64]
Entries = list[tuple[int, int, float]]  # what a value takes from a place of the row: value, place, factor
SLIPS = (-1, 0, 1)


@dataclass(frozen=True, eq=False)
class Tapes:
    """A model as the core of general rigs takes it, asked in numbers of the named rig's own core.

    Attributes
    ----------
    lowered
        For that core.
    constant, turned : (size,), (size, row)
        Its values are constant + turned @ row.
    states
        Place among its states of each of the named core's.
    speed
        Place of the belt's speed in a row.
    slots
        Places of numbers in a row, by name.
    made_of
        What `tapes` made it of: it is made again in another process.
    """

    lowered: LoweredBodies
    constant: Floats
    turned: Floats
    states: Mapping[int, int]
    speed: int
    slots: Mapping[str, tuple[int, ...]]
    made_of: tuple[Model, float, Mapping[str, tuple[int, ...]], int]

    def __reduce__(self) -> tuple[object, ...]:
        return tapes, self.made_of  # what the core takes does not cross processes

    def windows(
        self,
        *,
        parameters: Floats,
        set: NDArray[np.int32],  # noqa: A002  # as the core has it
        initial: Floats,
        contact: NDArray[np.int32],
        t: Floats,
        offset: NDArray[np.int64],
        seeds: Floats,
        column: NDArray[np.int32],
        columns: int,
        kept: NDArray[np.int32],
        **settings: Any,
    ) -> dict[str, object]:
        """Return what `_core.simulate_windows` returns, of the same arguments."""
        settings = {k: settings[k] for k in ("rtol", "atol", "max_transitions", "max_steps")}
        state, mode = np.zeros((len(t), COUNT)), np.zeros(len(t), dtype=np.int8)
        slopes = np.zeros((len(kept), len(t), columns))
        outcomes = []
        for i, own in enumerate(np.asarray(set).tolist()):
            part = slice(int(offset[i]), int(offset[i + 1]))
            at, rows = self.started(
                np.concatenate([parameters[own], initial[i]]), seeds, t[part], int(contact[i])
            )
            raw = self._run(at, rows, t[part], int(contact[i]), settings)
            done = raw["outcome"] == _core.Outcome.finished and len(raw["t"]) == part.stop - part.start
            outcomes.append(
                _core.Outcome.finished
                if done
                else (
                    _core.Outcome.step_too_small
                    if raw["outcome"] == _core.Outcome.finished
                    else raw["outcome"]
                )
            )
            if done:
                state[part], by = self._read(raw, len(rows), kept)
                mode[part] = raw["mode"][:, 0]
                for j, place in enumerate(np.asarray(column).tolist()):
                    slopes[:, part, place] += by[:, :, j]
        return {"state": state, "slopes": slopes, "mode": mode, "outcome": outcomes}

    def started(self, row: Floats, seeds: Floats, t: Floats, contact: int) -> tuple[Floats, Floats]:
        """Return values and seeds of a start: the belt has come from 0, and what sticks moves with it."""
        layout, n = self.lowered.layout, len(self.lowered.own.equations.names)
        at, rows = self.constant + self.turned @ row, seeds @ self.turned.T
        place = layout["initial"] + 2 * n + len(self.lowered.own.hidden)
        at[place], rows[:, place] = row[self.speed] * t[0], seeds[:, self.speed] * t[0]
        if contact == 0:
            speed, by = self._belt(row, seeds, float(t[0]))
            at[layout["initial"] + n], rows[:, layout["initial"] + n] = speed, by
        return at, rows

    def _belt(self, row: Floats, seeds: Floats, t: float) -> tuple[float, Floats]:
        """The belt's speed at a time, and what it moves by with each seed, (p,)."""
        factor = self.lowered.own.effects.factor("belt_speed")
        v = float(row[self.speed])
        if factor is None:
            return v, seeds[:, self.speed].copy()
        of = {name: float(row[self.slots[name][0]]) for name in names(factor) - {"t"}} | {"t": t}
        share = float(value(factor, of))
        by = seeds[:, self.speed] * share
        for name in of:
            if name != "t":
                by = by + v * float(value(derivative(factor, name), of)) * seeds[:, self.slots[name][0]]
        return v * share, by

    def _run(
        self, at: Floats, rows: Floats, t: Floats, contact: int, settings: Mapping[str, Any]
    ) -> Mapping[str, Any]:
        contacts = len(self.lowered.own.equations.contacts)
        raw: Mapping[str, Any] = _core.simulate_bodies(
            **self.lowered.arguments,
            values=np.nan_to_num(at),
            modes=[contact if contact in SLIPS else 2, *[2] * (contacts - 1)],
            t_start=float(t[0]),
            t_end=float(t[-1]),
            t_eval=np.ascontiguousarray(t),
            locator=_core.Locator.henon,
            seeds=np.ascontiguousarray(rows),
            **settings,
        )
        return raw

    def _read(self, raw: Mapping[str, Any], p: int, kept: NDArray[np.int32]) -> tuple[Floats, Floats]:
        """States (n, 9) in the order of the named core, and the slopes (kept, n, p) of those asked for."""
        state = np.zeros((len(raw["t"]), COUNT))
        for ours, theirs in self.states.items():
            state[:, ours] = raw["state"][:, theirs]
        by = np.zeros((len(kept), len(state), p))
        for j, k in enumerate(np.asarray(kept).tolist()):
            if k in self.states:
                by[j] = raw["sensitivity"][:, self.states[k]]
        return state, by

    def run(
        self, row: Floats, initial: Floats, t: Floats, contact: int, **settings: Any
    ) -> Mapping[str, Any]:
        """Return states (n, 9) and modes (n,) at times t, from a start at `t_start`."""
        begins = float(settings.pop("t_start"))
        times = t if t[0] == begins else np.concatenate([[begins], t])
        none = np.zeros((0, len(row) + COUNT))
        at, rows = self.started(np.concatenate([row, initial]), none, times, contact)
        raw = self._run(at, rows, times, contact, settings)
        state, _ = self._read(raw, 0, np.zeros(0, dtype=np.int32))
        skip = len(times) - len(t)
        return {"state": state[skip:], "mode": raw["mode"][skip:, 0]}


_LAST: dict[object, Tapes] = {}
KEPT = 64


def tapes(model: Model, belt_speed: float, slots: Mapping[str, tuple[int, ...]], width: int) -> Tapes:
    """Return the tapes of a named rig's model; `slots` and `width` are those of a row of its own core.

    The last few are kept: models that differ in the numbers of their effects alone have the same, as these are in the
    row.

    Raises
    ------
    InputError
        An effect does not act beside a formula.
    """
    key = (model.rig, model.friction, tuple(map(_form, model.effects)), belt_speed, tuple(slots.items()))
    if key not in _LAST:
        if len(_LAST) >= KEPT:
            _LAST.clear()
        _LAST[key] = _tapes(model, belt_speed, slots, width)
    return _LAST[key]


def _form(one: AnyEffect) -> object:
    """What of an effect is not in the row."""
    if isinstance(one, Tabulated):
        return one.where, one.variable, one.knots, one.period
    if isinstance(one, FormulaEffect):
        return one.name, one.where, one.acts, one.formula
    return one.name, one.parameters.get("v_c") == 0


def _tapes(model: Model, belt_speed: float, slots: Mapping[str, tuple[int, ...]], width: int) -> Tapes:
    lowered = lower_bodies(named(model, belt_speed), model)
    layout, n = lowered.layout, len(lowered.own.equations.names)
    constant, turned = lowered.values.copy(), np.zeros((len(lowered.values), width + COUNT))
    entries = (*_rig(model, lowered, slots), *_numbers(lowered, slots), *_curves(model, lowered, slots))
    for entry, place, factor in entries:
        constant[entry] = 0.0
        turned[entry, place] = factor
    states = _states(lowered, n)
    for ours, theirs in states.items():
        turned[layout["initial"] + theirs, width + ours] = 1.0
    turned[layout["dwell"], width + DWELL] = 1.0
    made_of = (model, belt_speed, slots, width)
    return Tapes(lowered, constant, turned, states, slots["belt_speed"][0], slots, made_of)


def _states(lowered: LoweredBodies, n: int) -> dict[int, int]:
    """Place among the general core's states of each that the named core has, too."""
    own = lowered.own
    out = {AT[name]: k for name, k in zip(own.state_names, own.order, strict=True)}
    if SEEN_LATE in own.hidden:
        out[LAGGED] = 2 * n + own.hidden.index(SEEN_LATE)
    return out


def _rig(model: Model, lowered: LoweredBodies, slots: Mapping[str, tuple[int, ...]]) -> Entries:
    """Entries of M, C and K: (2.1) is linear in its numbers."""
    place = {name: where[0] for name, where in slots.items() if "." not in name}
    M, C, K = (lowered.layout[key] for key in "MCK")
    if isinstance(model.rig, BlockOnBelt):
        named_: tuple[tuple[int, str], ...] = ((M, "mass"), (C, "damping"), (K, "stiffness"))
    else:
        named_ = (
            *((M, "alpha1"), (M + 3, "alpha2")),
            *((C, "eta1"), (C + 1, "eta1"), (C + 2, "eta1"), (C + 3, "eta12")),
            *((K, "alpha1"), (K + 3, "beta3")),
        )
    more = [(K, _core.PARAMETERS.index("stiffness"), 1.0)] if isinstance(model.rig, Rig) else []
    return [*((entry, place[name], 1.0) for entry, name in named_), *more]


def _numbers(lowered: LoweredBodies, slots: Mapping[str, tuple[int, ...]]) -> Entries:
    """Entries of the numbers of laws, effects and the belt."""
    first = lowered.layout["parameters"]
    return [(first + at, slots[name][0], 1.0) for name, at in lowered.places.items() if name in slots]


def _curves(model: Model, lowered: LoweredBodies, slots: Mapping[str, tuple[int, ...]]) -> Entries:
    """Entries of the coefficients of curves, linear in their values."""
    first, out = lowered.layout["parameters"], list[tuple[int, int, float]]()
    for one in model.effects:
        if isinstance(one, Tabulated) and not one.of_reading:
            for name, weights in zip(parts(one), coefficients(one), strict=True):
                places = [slots[f"{one.name}.value_{i}"][0] for i in range(len(weights))]
                out += [
                    (first + lowered.places[name], place, float(w))
                    for place, w in zip(places, weights, strict=True)
                ]
    return out
