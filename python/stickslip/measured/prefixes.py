"""A number given in another unit than it is taken in: off by a power of 1000, the step of the prefixes of units."""

from __future__ import annotations

import math
from collections.abc import Mapping

RATIO = 1.6  # a ratio that no effect, no law and no sensor of the list has
STEP = 1000.0
# by the unit that a number is taken in and what the true one is over it: the unit that it was given in
GIVEN_IN: Mapping[str, Mapping[int, str]] = {
    "kg": {-1: "g", -2: "mg", 1: "t"},
    "N/m": {1: "N/mm", 2: "N/um", -1: "mN/m"},
    "kg m^2": {-1: "g m^2", -2: "kg mm^2", -3: "g mm^2"},
    "m": {-1: "mm", -2: "um"},
}


def power(ratio: float, doubt: float = 0.0) -> int:
    """Return the power of 1000 that a ratio is, 0 where it is none.

    Parameters
    ----------
    ratio
        What is seen over what is declared.
    doubt
        Relative standard uncertainty of what is declared.
    """
    if not (math.isfinite(ratio) and ratio > 0):
        return 0
    n = round(math.log(ratio, STEP))
    return n if abs(math.log(ratio / STEP**n)) < math.log(RATIO) + 3 * doubt else 0


def put_right(values: Mapping[str, float], unit: str, n: int) -> str:
    """Say of numbers that are 1000^n times too little what they would be.

    As in "m = 42300 kg is 1,000 times too much, as if it were in g: write 42.3".
    """
    size, given = ("little" if n > 0 else "much"), GIVEN_IN.get(unit, {}).get(n)
    be, were = ("is", "it were") if len(values) == 1 else ("are", "they were")
    meant = f", as if {were} in {given}" if given else ""
    was = ", ".join(f"{value:.6g}" for value in values.values())
    right = ", ".join(f"{value * STEP**n:.6g}" for value in values.values())
    return (
        f"{', '.join(values)} = {was} {unit} {be} {1000 ** abs(n):,} times too {size}{meant}: write {right}"
    )


def times(ratio: float) -> str:
    """A ratio in words: "1,010 times"."""
    return f"{float(f'{ratio:.3g}'):,.10g} times"
