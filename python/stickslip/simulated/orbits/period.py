"""How often what moves a rig from outside repeats."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.tree import Apply, Name, Tree, names
from stickslip.declared.formula.value import value
from stickslip.errors import InputError

LOOKS = 3  # places at which a rate that must be constant is looked at
TURNS = {"sin": 2 * np.pi, "cos": 2 * np.pi, "tan": np.pi}


def periods_of(tree: Tree, of: Mapping[str, float], key: str) -> list[float]:
    """Periods of the functions of t in a formula that repeat; none where it does not read t.

    Parameters
    ----------
    tree
        A formula.
    of
        Its numbers.
    key
        What an error names.

    Raises
    ------
    InputError
        It depends on t in another way than through sin, cos or tan of a multiple of t, and perhaps of the state.
    """
    if not isinstance(tree, Apply) or "t" not in names(tree):
        if tree == Name("t"):
            raise InputError("changes with time without a period; no motion repeats", key=key)
        return []
    if tree.operation in TURNS:
        inner = tree.operands[0]
        rate = _rate(inner, of)
        if rate is not None:
            return [TURNS[tree.operation] / abs(rate)] if rate else []
    return [one for operand in tree.operands for one in periods_of(operand, of, key)]


def _rate(tree: Tree, of: Mapping[str, float]) -> float | None:
    """Return d tree / d t, where that is the same at all times and states: at a few, drawn once."""
    slope, rng = derivative(tree, "t"), np.random.default_rng(0)
    others = sorted(names(slope) - set(of) | {"t"})
    drawn = [{**of, **{name: float(rng.uniform(0.1, 1.0)) for name in others}} for _ in range(LOOKS)]
    rates = np.array([float(value(slope, one)) for one in drawn])
    return float(rates[0]) if np.ptp(rates) <= 1e-12 * np.abs(rates).max() else None


def common_multiple(found: Mapping[str, float]) -> float | None:
    """Return the least period that is one of all of them, by what has it; None if there are none.

    Raises
    ------
    InputError
        They have no small common multiple.
    """
    common: float | None = None
    for name, period in found.items():
        common = period if common is None else _of_two(common, period, name)
    return common


def _of_two(first: float, second: float, name: str) -> float:
    for i in range(1, 33):
        j = round(i * first / second)
        if j > 0 and abs(i * first - j * second) < 1e-9 * i * first:
            return i * first
    raise InputError(
        f"its period {second:g} and the period {first:g} of the rest have no small common multiple; "
        "the motion is quasi-periodic, not a cycle",
        key=name,
    )
