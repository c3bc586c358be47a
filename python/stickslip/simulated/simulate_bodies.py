"""One trajectory of a model of any rig, by the core of such rigs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip import _core
from stickslip.arguments import vector
from stickslip.declared.effect import FormulaEffect
from stickslip.declared.formula.value import value
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.model import Model
from stickslip.declared.places import seen
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.speeds import Speed
from stickslip.errors import CallError, InputError, number
from stickslip.simulated.bodies_lowering import LoweredBodies, lower_bodies
from stickslip.simulated.general import General
from stickslip.simulated.named_places import whole
from stickslip.simulated.sensed import sensed
from stickslip.simulated.trajectory import CONTACTS, Status, Trajectory, Transitions

Floats = NDArray[np.float64]


def needs_bodies(model: Model, belt_speed: object, drive_speed: object) -> bool:
    """Say whether only the core of general rigs can simulate this: another rig or law, a speed that is no number."""
    formulas = isinstance(belt_speed, (str, Speed)) and Speed.of(belt_speed).constant is None
    formula = any(isinstance(one, FormulaEffect) for one in model.effects)
    general_rig = isinstance(model.rig, (GeneralRig, DrivenSlider))
    general_rig = general_rig or isinstance(model.friction, LawByFormula) or formula
    if isinstance(model.rig, DrivenSlider) and belt_speed is not None:
        raise InputError("a driven slider has no belt; leave it out", key="belt_speed")
    if drive_speed is not None and not isinstance(model.rig, (GeneralRig, DrivenSlider)):
        raise InputError("nothing is pulled by a drive in this rig; leave it out", key="drive_speed")
    return general_rig or formulas


def simulate_any(
    model: Model,
    belt_speed: object,
    drive_speed: object,
    initial: ArrayLike | None,
    contact: str | Sequence[str],
    names: tuple[str, ...],
    times: Floats | None,
    before: Trajectory | None = None,
    **settings: Any,
) -> Trajectory:
    """Return the trajectory; what was given has been looked at, but for the start and the modes.

    Parameters
    ----------
    model, belt_speed, drive_speed, initial, contact
        As for `simulate`.
    names
        Parameters to differentiate by.
    times
        As `_core.simulate_bodies` takes them.
    before
        The run that goes on.
    settings
        The rest of what `_core.simulate_bodies` takes.
    """
    own = whole(model, belt_speed, drive_speed)
    lowered = lower_bodies(own, model)
    visible, hidden = split_initial(own, initial)
    modes = contact_modes(own, contact)
    z = own.start(visible, hidden, settings["t_start"])
    if before is None:
        _refuse_other_slip(own, z, modes, settings["t_start"])
    seeds = lowered.seeds(map(model.full_name, names), z, frozenset(hidden))
    settings |= {"t_eval": times, "sensed": isinstance(model.rig, GeneralRig)}
    values = lowered.started(z)
    rested = np.zeros(len(own.equations.contacts))
    if before is not None and len(before.rested):
        rested = before.rested
        values[lowered.layout["dwell"] :][: len(rested)] = rested
        for place, key in enumerate(_ways(own), lowered.layout["initial"] + len(z)):
            values[place] = before.travelled[key][-1]
    return run_bodies(lowered, values, modes, names, seeds, belt_speed, rested, **settings)


def _refuse_other_slip(own: General, z: Floats, modes: Sequence[int], t: float) -> None:
    """Refuse a slip that goes the other way than its mode says."""
    n, belt = len(own.equations.names), float(own.belt(t))
    for one, mode in zip(own.equations.contacts, modes, strict=True):
        v = float(one.slip(z[n : 2 * n], belt))
        if mode in (-1, 1) and v * mode < -1e-12 * max(abs(belt), float(np.abs(z[n : 2 * n]).max())):
            words = f"'{one.name}' starts at v = {v:g} and slips the other way"
            raise InputError(words, key="contact", value="slip+" if mode > 0 else "slip-")


def run_bodies(
    lowered: LoweredBodies,
    values: Floats,
    modes: list[int],
    names: tuple[str, ...],
    seeds: Floats,
    belt_speed: object,
    rested: Floats | None = None,
    **settings: Any,
) -> Trajectory:
    """Return the trajectory of a lowered model.

    Parameters
    ----------
    lowered
        From `lower_bodies`.
    values : (size,)
        Its numbers, the start among them.
    modes
        Of the contacts at the start, as the core has them.
    names, seeds : (p,) and (p, size)
        What to differentiate by.
    belt_speed
        As it was given.
    rested : (m,)
        For how long each contact has stuck at the start; 0 if absent.
    settings
        The rest of what `_core.simulate_bodies` takes.
    """
    raw = _core.simulate_bodies(**lowered.arguments, values=values, modes=modes, seeds=seeds, **settings)
    made = _trajectory(raw, lowered, names, belt_speed)
    return replace(made, rested=_rested(raw, settings["t_start"], rested)) if len(made.t) else made


def _ways(own: General) -> list[str]:
    """Which of belt and drive move, in the order in which their ways follow the states."""
    used = (own.equations.on_belt, own.equations.driven)
    return [own.called(key) for key, moves in zip(own.effects.keys, used, strict=True) if moves]


def _rested(raw: dict[str, Any], start: float, before: Floats | None) -> Floats:
    """For how long each contact has stuck at the last sample, (m,)."""
    end, modes = float(raw["t"][-1]), np.asarray(raw["mode"])[-1]
    past = np.asarray(raw["transition_t"]) <= end
    was, then = (np.asarray(raw[f"transition_{key}"])[past] for key in ("before", "after"))
    out = np.zeros(len(modes))
    for j in np.flatnonzero(modes == 0):
        came = np.asarray(raw["transition_t"])[past][(was[:, j] != 0) & (then[:, j] == 0)]
        earlier = 0.0 if before is None else float(before[j])
        out[j] = end - came[-1] if len(came) else end - start + earlier
    return out


def split_initial(own: General, initial: ArrayLike | None) -> tuple[Floats, dict[str, float]]:
    """Return the rig's states and what was given of the laws' states."""
    names = own.state_names
    if initial is None:
        return np.zeros(len(names)), {}
    given = vector("initial", initial, f"one start ({', '.join(names)})")
    everything = (*names, *own.hidden)
    if len(given) not in (len(names), len(everything)):
        words = f"has {len(given)} number{'s' * (len(given) != 1)}; give {len(names)} ({', '.join(names)})"
        if own.hidden:
            words += f", or {len(everything)} with the laws' states {', '.join(own.hidden)}"
        raise InputError(words, key="initial")
    for name, size in zip(everything, given.tolist(), strict=False):
        if not math.isfinite(size):
            raise InputError(f"{name} is not finite", key="initial", value=given.tolist())
    return given[: len(names)].copy(), dict(zip(own.hidden, given[len(names) :].tolist(), strict=False))


def contact_modes(own: General, contact: str | Sequence[str]) -> list[int]:
    """Return modes to start in as the core has them; one for all contacts, or each.

    Raises
    ------
    InputError
        An unknown mode, not one for every contact, or a stick of a law that has none.
    """
    contacts = own.equations.contacts
    if not isinstance(contact, str) and len(contact) == own.of_rig:
        contact = [*contact, *["auto"] * (len(contacts) - own.of_rig)]
    each: list[str] = [contact] * len(contacts) if isinstance(contact, str) else list(contact)
    if len(each) != len(contacts):
        raise InputError(f"has {len(each)} modes for {len(contacts)} contacts", key="contact")
    for one, law, place in zip(each, own.laws, contacts, strict=True):
        if one not in CONTACTS:
            raise InputError(f"must be one of {', '.join(CONTACTS)}", key="contact", value=one)
        if one == "stick" and law.compliant:
            raise InputError(f"the law of '{place.name}' has no stick", key="contact", value=one)
    return [CONTACTS[one] for one in each]


def _trajectory(
    raw: dict[str, Any], lowered: LoweredBodies, names: tuple[str, ...], belt_speed: object
) -> Trajectory:
    own = lowered.own
    n, order = len(own.equations.names), list(own.order)
    hidden = slice(2 * n, 2 * n + len(own.hidden))
    ways = _ways(own)
    alone = not isinstance(lowered.model.rig, GeneralRig)  # of a named rig the one contact is the mode

    def modes(given: NDArray[np.int8]) -> NDArray[np.int8]:
        return given[:, 0].copy() if alone else given

    events = raw["transition_sensitivity"]
    seen_by, slopes = sensed(lowered, raw, names) if raw["sensed"].size else ({}, {})
    transitions = Transitions(
        t=raw["transition_t"],
        state=raw["transition_state"][:, order],
        before=modes(raw["transition_before"]),
        after=modes(raw["transition_after"]),
        sensitivity=events[:, 0],
        state_sensitivity=events[:, 1:][:, order],
    )
    sensitivity: Floats = raw["sensitivity"]
    readings = _readings(own, raw["t"], raw["state"].T)
    if alone:  # of a named rig all that may be recorded is there
        places = {name: k for k, name in enumerate(own.state_names) if name in ("x1", "y1")}
        readings = {name: readings.get(name, raw["state"][:, order[k]]) for name, k in places.items()}
    return Trajectory(
        t=raw["t"],
        state=raw["state"][:, order],
        mode=modes(raw["mode"]),
        hidden=dict(zip(own.hidden, raw["state"].T[hidden].copy(), strict=True)),
        transitions=transitions,
        kinks=raw["kink_t"],
        sensitivity=sensitivity[:, order],
        hidden_sensitivity=dict(zip(own.hidden, sensitivity.transpose(1, 0, 2)[hidden], strict=True)),
        status=Status[raw["outcome"].name],
        steps=int(raw["steps"]),
        sensitivity_names=names,
        state_names=own.state_names,
        hidden_names=own.hidden,
        model=lowered.model,
        belt_speed=None if belt_speed is None else Speed.of(belt_speed),
        contact_names=() if alone else tuple(one.name for one in own.equations.contacts),
        readings=readings,
        travelled=dict(zip(ways, raw["state"].T[hidden.stop :].copy(), strict=True)),
        travelled_sensitivity=dict(zip(ways, sensitivity.transpose(1, 0, 2)[hidden.stop :], strict=True)),
        sensed=seen_by,
        sensed_sensitivity=slopes,
    )


def _readings(own: General, t: Floats, z: Floats) -> dict[str, Floats]:
    """Return what sensors read that effects act on, of states (q, v, hidden, ...) by time."""
    n = len(own.equations.names)
    of = {**seen(z, n, t, 0.0, 0.0), **own.effects.numbers, **dict(zip(own.hidden, z[2 * n :], strict=False))}
    return {
        name: np.broadcast_to(value(tree, of), t.shape).copy() for name, tree in own.effects.readings.items()
    }


def constant_speed(given: object) -> float:
    """Return the belt's speed where it is a number, or a `Speed` that is one at every time."""
    return number("belt_speed", given.constant if isinstance(given, Speed) else given)  # type: ignore[arg-type]  # it looks


def lacks_belt_speed() -> CallError:
    """Return the error of a call without the belt's speed, where the rig has a belt."""
    return CallError("lacks belt_speed; it needs model, belt_speed, t_end", key="simulate")
