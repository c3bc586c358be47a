"""What a formula is worth: of floats, complex numbers (for derivatives by a complex step) and arrays of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from stickslip.declared.formula.tree import Apply, Name, Number, Tree

Value = Any  # a float, a complex number, or an array of either


def value(tree: Tree, of: Mapping[str, Value], sides: Mapping[Apply, int] | None = None) -> Value:
    """Evaluate a tree.

    Parameters
    ----------
    tree
        From `parse`.
    of
        Values by name.
    sides
        For abs, sign, min and max: the side (-1 or 1) they are frozen on; what is missing is decided by the values,
        by their real part.
    """
    if isinstance(tree, Number):
        return tree.value
    if isinstance(tree, Name):
        return of[tree.name]
    operands = [value(one, of, sides) for one in tree.operands]
    if tree.operation in ("abs", "sign", "min", "max"):
        side = None if sides is None else sides.get(tree)
        return _piecewise(tree.operation, operands, side)
    with np.errstate(all="ignore"):
        return _SMOOTH[tree.operation](*operands)


def surface(tree: Apply, of: Mapping[str, Value], sides: Mapping[Apply, int] | None = None) -> Value:
    """Return what is above zero on the side 1 of an abs, sign, min or max, and below on the side -1."""
    operands = [value(one, of, sides) for one in tree.operands]
    return operands[0] if len(operands) == 1 else operands[0] - operands[1]


def side_of(tree: Apply, of: Mapping[str, Value], sides: Mapping[Apply, int] | None = None) -> int:
    """Return the side that an abs, sign, min or max is on; 1 on the surface itself."""
    return 1 if np.real(surface(tree, of, sides)) >= 0 else -1


def _piecewise(operation: str, operands: list[Value], side: int | None) -> Value:
    first = operands[0]
    if side is None:
        side = np.sign(np.real(first if len(operands) == 1 else first - operands[1]))
    if operation == "sign":
        return side + 0.0 * first
    if operation == "abs":
        return side * first
    larger = side if operation == "max" else -side
    picked: Value = np.where(np.asarray(larger) >= 0, first, operands[1])
    return picked[()]


def _power(base: Value, exponent: Value) -> Value:
    """Return the power.

    Where the exponent is no integer, a negative base (u behind a landing at u = 0) has the power of its magnitude.
    """
    if isinstance(exponent, float) and exponent.is_integer() and abs(exponent) <= 64:
        return np.asarray(base) ** int(exponent)
    base = np.asarray(base)
    return np.where(np.real(base) < 0, -base, base) ** exponent


_SMOOTH: Mapping[str, Any] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: np.asarray(a) / b,
    "power": _power,
    "negate": lambda a: -a,
    "exp": np.exp,
    "log": np.log,
    "sqrt": lambda a: _power(a, 0.5),
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "tanh": np.tanh,
    "asinh": np.arcsinh,
}
