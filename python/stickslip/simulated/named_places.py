"""Effects of the catalogue where a formula acts beside them on a named rig, put to their places as trees."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.bodies_model import law_of
from stickslip.declared.effect import CONSTANTS, AnyEffect, Effect, FormulaEffect, Tabulated
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.formula.tree import Apply, Name, Number, Tree
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.laws import LAWS
from stickslip.declared.model import Model
from stickslip.declared.placed import Placed, PlacedState, placed
from stickslip.declared.places import Places, coordinate
from stickslip.declared.rig import AnyRig, BlockOnBelt, DrivenSlider, Rig
from stickslip.declared.rigs.general import Equations
from stickslip.declared.rigs.named import equations_of
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError
from stickslip.simulated.driven import driven, with_mass
from stickslip.simulated.general import General, general, with_rubbing
from stickslip.simulated.placed_effects import of_placed

Floats = NDArray[np.float64]
LAGGED = "m"
REFUSED = (
    "belt_load_droop",
    "friction_memory",
    "contact_compliance",
)  # their states start anew, or move the belt


def beside_formula(kind: EffectKind) -> bool:
    """Whether an effect of the catalogue acts beside a formula on a named rig."""
    return kind.name not in REFUSED


def whole(model: Model, belt_speed: object, drive_speed: object = None) -> General:
    """Return what the core of general rigs simulates of a model of any rig, readings included.

    Raises
    ------
    InputError
        As `general`, and an effect that does not act beside a formula.
    """
    if isinstance(model.rig, DrivenSlider):
        return driven(model, Speed.of(drive_speed, "drive"), _curve)
    if belt_speed is None or not isinstance(model.rig, (Rig, BlockOnBelt)):
        return general(model, belt_speed, drive_speed)
    formula = any(isinstance(one, FormulaEffect) for one in model.effects)
    if not formula and any(
        isinstance(one, Tabulated) or one.name == "contact_compliance" for one in model.effects
    ):
        return general(model, belt_speed, drive_speed)
    return named(model, belt_speed, readings=True)


def named(model: Model, belt_speed: object, *, readings: bool = False) -> General:
    """Return what the core of general rigs simulates of a named rig's model.

    Parameters
    ----------
    model, belt_speed
        As for `general`.
    readings
        Whether what acts on readings alone is there too.

    Raises
    ------
    InputError
        An effect that does not act beside a formula.
    """
    own, order = stiffened(model, *equations_of(corrected(model)))
    places = Places(model.rig, own, order)
    law = law_of(model.friction, own.contacts[0]).form()
    acting = [one for one in model.effects if readings or not _read_alone(one)]
    found = [each for one in acting if (each := _placed(one, places, model)) is not None]
    found.sort(
        key=lambda one: one.label not in ("sensor_crosstalk", "sensor_lag")
    )  # the first of the channel
    # what adds to friction comes before what multiplies it
    found.sort(
        key=lambda one: one.contact is not None and "factor" in (one.acts or {}) and one.number is None
    )
    effects = of_placed(found, places.states)
    own, laws = with_rubbing(own, (effects.changed(0, law),), effects)
    speed = Speed.of(belt_speed, "belt_speed")
    effects = replace(effects, prescribed=(speed, Speed.of(0.0)))
    belt = effects.moved("belt_speed", speed)
    return General(own, laws, belt, Speed.of(0.0), order, model.rig.state_names, effects)


def corrected(model: Model) -> AnyRig:
    """Return a rig with the constants that effects correct."""
    if isinstance(model.rig, DrivenSlider):
        return with_mass(model)
    if not isinstance(model.rig, BlockOnBelt):
        return model.rig
    shares = {
        one.kind.corrects: one.parameters["e"]
        for one in model.effects
        if isinstance(one, Effect) and one.name in CONSTANTS
    }
    own = {
        name: getattr(model.rig, name) * (1 + e)
        for name, e in shares.items()
        if name in ("mass", "stiffness")
    }
    return replace(model.rig, **own)


def stiffened(model: Model, own: Equations, order: tuple[int, ...]) -> tuple[Equations, tuple[int, ...]]:
    """Return equations with the springs of (2.1) as an effect corrects them: alpha1 is the mass, too."""
    shares = [one.parameters["e"] for one in model.effects if one.name == "rig_stiffness"]
    if not shares or not isinstance(model.rig, Rig):
        return own, order
    K = own.K.copy()
    K[0, 0] *= 1 + shares[0]
    return replace(own, K=K), order


def _read_alone(one: AnyEffect) -> bool:
    """Whether an effect acts on a reading alone, without a state."""
    if isinstance(one, FormulaEffect):
        return one.acts == "reading" and not one.states
    if isinstance(one, Tabulated):
        return one.of_reading
    return one.kind.physics == "reading" and not one.kind.hidden


def _placed(one: AnyEffect, places: Places, model: Model) -> Placed | None:
    """An effect at its place; None of one that corrects a number of the rig."""
    if isinstance(one, FormulaEffect):
        return placed(one, places)
    if isinstance(one, Tabulated):
        return _curve(one, places)
    if one.name in (*REFUSED, "sensor_delay"):  # a reading of the past is no formula
        raise not_beside_formula(one.name, model)
    if one.name in CONSTANTS and one.kind.corrects != "reading":
        return None
    if one.name == "sensor_crosstalk" and any(each.name == "sensor_lag" for each in model.effects):
        return None  # the lag is one of what it makes
    return _lag(one, places, model) if one.name == "sensor_lag" else placed(one, places)


def not_beside_formula(name: str, model: Model) -> InputError:
    """Return the error of an effect that cannot act where something is a formula; it says what is one."""
    effect = next((each.name for each in model.effects if isinstance(each, FormulaEffect)), None)
    if effect is not None:
        return InputError(f"'{name}' does not act beside an effect by a formula, '{effect}'", key="effects")
    if isinstance(model.friction, LawByFormula):
        kind = model.friction.kind
        words = f"'{name}' does not act beside the law '{kind}'; it needs one of {', '.join(LAWS)}"
        return InputError(words, key="effects")
    words = f"'{name}' acts at a constant belt speed only; give a number, or leave the effect out"
    return InputError(words, key="effects")


def _named_numbers(one: Effect) -> dict[str, float]:
    return {f"{one.name}.{name}": size for name, size in one.parameters.items()}


def _lag(one: Effect, places: Places, model: Model) -> Placed:
    """The lagged reading of x1, of what crosstalk makes of it."""
    seen: Tree = coordinate(0)
    cross = next((each for each in model.effects if each.name == "sensor_crosstalk"), None)
    numbers = _named_numbers(one)
    if isinstance(cross, Effect):
        seen = _sum(seen, _times(Name("sensor_crosstalk.c"), coordinate(1)))
        numbers |= _named_numbers(cross)
    m = LAGGED
    rate = Apply("divide", (Apply("subtract", (seen, Name(m))), Name("sensor_lag.tau")))
    return Placed(
        one.name, numbers, (PlacedState(m, rate, seen),), channel=next(iter(places.states)), reading=Name(m)
    )


def _curve(one: Tabulated, places: Places) -> Placed:
    """A curve as a polynomial whose coefficients jump from knot to knot; they are linear in its values."""
    if one.of_reading:
        raise InputError(
            f"'{one.name}', a curve of a reading, is not simulated beside a formula", key="effects"
        )
    if one.period is not None:
        words = f"'{one.name}', a curve that repeats, does not act beside an effect by a formula"
        raise InputError(words, key="effects")
    of: Mapping[str, Tree] = {**places.states, "t": Name("t"), "v_w": Name("v")}
    numbers = dict(zip(parts(one), (coefficients(one) @ np.array(one.values)).tolist(), strict=True))
    curve = spline(of[one.variable], one.knots, [Name(name) for name in numbers])
    if one.where == "contact":
        return Placed(one.name, numbers, contact=0, acts={"factor": _sum(Number(1.0), curve)})
    direction, _ = places.force(one.where)
    return Placed(one.name, numbers, direction=direction, force=curve)


def parts(one: Tabulated) -> list[str]:
    """Names of the coefficients of a curve: of every interval, those of each power less the interval's before."""
    return [f"{one.name}.part_{i}" for i in range(4 * (len(one.knots) - 1))]


def coefficients(one: Tabulated) -> Floats:
    """Return what the coefficients of a curve are by its values, (4 intervals, values)."""
    knots, n = np.array(one.knots) - one.knots[0], len(one.knots)
    local = scipy.interpolate.CubicSpline(knots, np.eye(n), bc_type="natural").c  # (4, intervals, values)
    whole = np.zeros((n - 1, 4, n))
    for i, knot in enumerate(knots[:-1]):  # powers of s - knot, as powers of s
        for power in range(4):
            for lower in range(power + 1):
                whole[i, lower] += math.comb(power, lower) * (-knot) ** (power - lower) * local[3 - power, i]
    whole[1:] -= whole[:-1].copy()
    return np.asarray(whole.reshape(-1, n))


def spline(x: Tree, knots: tuple[float, ...], named_parts: list[Tree]) -> Tree:
    """Return a cubic spline by its coefficients, constant beyond the outer knots."""
    inside = Apply("min", (Apply("max", (x, Number(knots[0]))), Number(knots[-1])))
    s: Tree = Apply("subtract", (inside, Number(knots[0])))
    powers = list(named_parts[:4])
    for i, knot in enumerate(knots[1:-1], start=1):
        beyond = Apply("sign", (Apply("subtract", (inside, Number(knot))),))
        there = _times(Number(0.5), _sum(Number(1.0), beyond))
        powers = [_sum(one, _times(there, named_parts[4 * i + k])) for k, one in enumerate(powers)]
    square = _times(s, s)
    shifted = _sum(_sum(powers[0], _times(powers[1], s)), _times(powers[2], square))
    return _sum(shifted, _times(powers[3], _times(square, s)))


def _sum(a: Tree, b: Tree) -> Tree:
    return Apply("add", (a, b))


def _times(a: Tree, b: Tree) -> Tree:
    return Apply("multiply", (a, b))
