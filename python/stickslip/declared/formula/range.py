"""Is a formula defined everywhere it may be asked? Divisions by zero, logarithms and roots of what is negative."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.formula.tree import Apply, Number, Tree, nodes, written
from stickslip.declared.formula.value import value
from stickslip.errors import InputError

LOOKS: Mapping[str, NDArray[np.float64]] = {  # where each variable is looked at
    "u": np.concatenate([[0.0], np.geomspace(1e-9, 1e6, 1501)]),
    "dwell": np.concatenate([[0.0], np.geomspace(1e-9, 1e9, 1801)]),
    "t": np.linspace(0.0, 1000.0, 4001),
}


def check_range(
    key: str, tree: Tree, over: str, of: Mapping[str, float], looks: NDArray[np.float64] | None = None
) -> None:
    """Refuse a formula that divides by zero, or leaves the reals, within the range of a variable.

    Parameters
    ----------
    key
        Name said in the error.
    tree
        The formula.
    over
        "u" or "dwell" (from 0 on) or "t"; v goes along with u.
    of
        Values of the other names.
    looks
        Where another name is looked at.

    Raises
    ------
    InputError
        Where it happens, with the part of the formula and the value of the variable.
    """
    looks = LOOKS[over] if looks is None else looks
    values = {**of, over: looks, **({"v": looks} if over == "u" else {})}
    for one in dict.fromkeys(nodes(tree)):
        if not isinstance(one, Apply):
            continue
        told = _partial(one)
        if told is None:
            continue
        part, words, may_be_zero, may_be_negative = told
        if isinstance(part, Number) and part.value > 0:
            continue
        found = np.broadcast_to(np.real(value(part, values)), looks.shape)
        bad = np.zeros(looks.shape, bool)
        if not may_be_zero:
            bad |= found == 0
            bad[1:] |= np.sign(found[1:]) * np.sign(found[:-1]) < 0
        if not may_be_negative:
            bad |= found < 0
        if bad.any():
            at = looks[int(np.argmax(bad))]
            raise (
                InputError(f"{words} '{written(part)}', which is 0 or below it at {over} = {at:.3g}", key=key)
                if (not may_be_negative)
                else InputError(f"{words} '{written(part)}', which is 0 at {over} = {at:.3g}", key=key)
            )


def _partial(one: Apply) -> tuple[Tree, str, bool, bool] | None:
    """Return the operand that must not be 0 or negative, words, and whether it may be either."""
    match one.operation:
        case "divide":
            return one.operands[1], "divides by", False, True
        case "log":
            return one.operands[0], "takes the logarithm of", False, False
        case "sqrt":
            return one.operands[0], "takes the root of", True, False
        case "power":
            exponent = one.operands[1]
            if isinstance(exponent, Number):
                whole = exponent.value.is_integer()
                return one.operands[0], "takes a power of", exponent.value >= 0, whole
            return one.operands[0], "takes a power of", True, False
    return None
