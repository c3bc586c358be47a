"""A prescribed speed as a person writes it: a number, one with a unit, a formula of t, or steps of these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from stickslip.declared.formula.parse import parse
from stickslip.declared.formula.tree import names
from stickslip.declared.quantity import quantity, sized
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, did_you_mean

Step = Mapping[str, object]
Given = float | str | Speed | Sequence[Step]
STEP = ("from", "value")


def formula_of_time(text: str, key: str) -> Speed | None:
    """Return the speed that a formula of t tells of; None for what should be a number with a unit."""
    try:
        tree = parse(text)
    except InputError:
        if not {"(", "*"} & set(text):  # nobody's formula
            return None
        return Speed.of(text, key)  # says what is wrong with it
    if "t" in names(tree) or {"(", "*"} & set(text):
        return Speed.of(text, key)
    return None


def set_point(given: Given, unit: str, per_unit: float, key: str) -> Speed:
    """Return a speed in SI.

    Parameters
    ----------
    given
        A number, in the unit of its channel, as text too; one with a unit of its own ("12 rpm"); a formula of t, in SI;
        or steps, each a `from`, in s or with a unit, and a `value`, one of these.
    unit
        SI unit of the speed.
    per_unit
        What 1 of the channel's unit is in it.
    key
        Name said in an error.

    Raises
    ------
    InputError
        None of these, or a unit of something else.
    """
    if isinstance(given, Speed):
        return given
    if isinstance(given, (list, tuple)):
        return _steps(given, unit, per_unit, key)
    if not isinstance(given, str):
        return Speed.of(sized(given, unit, key) * per_unit, key)  # type: ignore[arg-type]  # `sized` looks
    formula = formula_of_time(given, key)
    if formula is not None:
        return formula
    size = sized(given, unit, key)
    return Speed.of(size if quantity(key, given)[1] else size * per_unit, key)


def _steps(given: Sequence[Step], unit: str, per_unit: float, key: str) -> Speed:
    if not given:
        raise InputError("has no steps; one is from = 2.0, value = 0.1", key=key)
    begins, values, told = [], [], []
    for i, one in enumerate(given):
        at = f"{key}[{i}]"
        if not isinstance(one, Mapping):
            raise InputError("no step; one is from = 2.0, value = 0.1", key=at, value=one)
        for name in STEP:
            if name not in one:
                raise InputError(f"lacks '{name}'; a step is from = 2.0, value = 0.1", key=at)
        for name in one:
            if name not in STEP:
                raise InputError(f"unknown; {did_you_mean(str(name), STEP)}", key=f"{at}.{name}")
        begins.append(sized(one["from"], "s", f"{at}.from"))  # type: ignore[arg-type]  # it looks
        value = set_point(one["value"], unit, per_unit, f"{at}.value")  # type: ignore[arg-type]
        if len(value.pieces) > 1:
            raise InputError("has steps itself; give a number or a formula", key=f"{at}.value")
        values.append(value)
        told.append(f"{value.text} from {begins[-1]:g}")
    return replace(Speed.steps(begins, values, key), text=", ".join(told))
