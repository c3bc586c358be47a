"""A driven slider as a rig of matrices: on the ground, moved by the force of its drive."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stickslip.declared.bodies_model import law_of
from stickslip.declared.effect import CONSTANTS, AnyEffect, Effect, Tabulated
from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import Apply, Name, Number, Tree, substituted
from stickslip.declared.law_form import LawForm
from stickslip.declared.model import Model
from stickslip.declared.placed import Placed, PlacedState, placed
from stickslip.declared.places import Places, coordinate, prescribed
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.rigs.named import equations_of
from stickslip.declared.speeds import Speed
from stickslip.simulated.general import General
from stickslip.simulated.placed_effects import Push, of_placed

FORCE = prescribed("drive_speed")
REST = Speed.of(0.0)


def driven(model: Model, drive: Speed, curve: Callable[[Tabulated, Places], Placed]) -> General:
    """Return what the core of general rigs simulates of a driven slider.

    Shares of friction add up, and so do gains of the drive, as the fit of a record has them.

    Parameters
    ----------
    model
        Its rig is a `DrivenSlider`.
    drive
        Force over time [N].
    curve
        Puts a tabulated term to its place.
    """
    rig = model.rig
    assert isinstance(rig, DrivenSlider)
    own, order = equations_of(with_mass(model))
    places = Places(rig, own, order)
    law = law_of(model.friction, own.contacts[0]).form()
    acting = [one for one in model.effects if not of_drive(one) and one.name not in CONSTANTS]
    found = [
        curve(_read(one), places) if isinstance(one, Tabulated) else placed(one, places) for one in acting
    ]
    effects = of_placed(_in_order(found, law), places.states)
    numbers, pushes = dict(effects.numbers), list(effects.pushes)
    for one in model.effects:
        if one.name == "drive_delay":  # it moves times, and is no number of a formula
            drive = drive.delayed(one.parameters["delay"])
        elif of_drive(one):
            numbers |= {f"{one.name}.{name}": size for name, size in one.parameters.items()}
    if (push := _of_drive([one for one in model.effects if isinstance(one, Effect)])) is not None:
        pushes.append(push)
    effects = replace(effects, numbers=numbers, pushes=tuple(pushes), prescribed=(REST, drive))
    law = effects.changed(0, law)
    return General(own, (law,), REST, drive, order, rig.state_names, effects, drive_name="drive")


def _read(one: Tabulated) -> Tabulated:
    """A curve as the rig's states have what it reads: the slider slides as fast as it moves."""
    return replace(one, variable="x2") if one.variable == "v_w" else one


def with_mass(model: Model) -> DrivenSlider:
    """Return the slider with its mass as an effect corrects it."""
    rig = model.rig
    assert isinstance(rig, DrivenSlider)
    shares = [one.parameters["e"] for one in model.effects if one.name == "rig_mass"]
    return replace(rig, mass=rig.mass * (1 + shares[0])) if shares else rig


def of_drive(one: AnyEffect) -> bool:
    """Whether an effect changes the force of the drive."""
    return isinstance(one, Effect) and one.where == "drive"


def _in_order(found: Sequence[Placed], law: LawForm) -> list[Placed]:
    """Effects at the contact as the fit adds them: shares of friction in one sum, then peaks, then a bristle."""
    shares = [one for one in found if "factor" in (one.acts or {})]
    peaks = [one for one in found if "peak" in (one.acts or {})]
    bristles = [one for one in found if "bristle" in (one.acts or {})]
    others = [one for one in found if one.contact is None]
    if len(shares) > 1:
        factors = [one.acts["factor"] for one in shares if one.acts is not None]
        acts = {"factor": _whole(factors)}
        numbers = {name: size for one in shares for name, size in one.numbers.items()}
        shares = [replace(shares[0], numbers=numbers, acts=acts)]
    if bristles:  # bent by friction as the others have made it
        law = of_placed([*shares, *peaks], {}).changed(0, law)
        bristles = [_bent(one, law) for one in bristles]
    return [*shares, *peaks, *bristles, *others]


def _whole(factors: Sequence[Tree]) -> Tree:
    """1 and what each factor has beyond it."""
    out: Tree = Number(1.0 - len(factors))
    for one in factors:
        out = Apply("add", (out, one))
    return out


def _bent(one: Placed, law: LawForm) -> Placed:
    """The bristle starts bent by kinetic friction, to the side on which the slider moves."""
    forward = parse("max(0, sign(v))*K_plus - max(0, sign(-v))*K_minus", ["v", "K_plus", "K_minus"])
    by: dict[str, Tree] = {
        "K_plus": law.plus.kinetic or Number(0.0),
        "K_minus": law.minus.kinetic or Number(0.0),
    }
    start = Apply("divide", (substituted(forward, by), Name(f"{one.label}.k")))
    return replace(one, states=tuple(replace(each, start=start) for each in one.states))


def _of_drive(effects: Sequence[Effect]) -> Push | None:
    """What effects make of the drive beyond the drive itself; None where it acts as it is."""
    lag = next((one for one in effects if one.name == "drive_lag"), None)
    gains = [one for one in effects if one.kind.anywhere.gain is not None]
    if lag is None and not gains:
        return None
    force: Tree = Name("drive_lag.f") if lag else FORCE
    states = list[PlacedState]()
    if lag is not None:
        rate = Apply("divide", (Apply("subtract", (FORCE, force)), Name("drive_lag.tau")))
        states.append(PlacedState("drive_lag.f", rate, FORCE))
    by: dict[str, Tree] = {"F": force, "position": coordinate(0), "t": Name("t")}
    factors = []
    for one in gains:
        own = {name: Name(f"{one.name}.{name}") for name in one.parameters}
        factors.append(substituted(parse(one.kind.anywhere.gain or "", [*by, *own]), {**by, **own}))
    whole = Apply("multiply", (_whole(factors), force)) if factors else force
    return Push(np.ones(1), Apply("subtract", (whole, FORCE)), tuple(states))
