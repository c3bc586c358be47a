"""A number of a rig as a person writes it in Python: bare, in SI, or text with a unit, as in a file."""

from __future__ import annotations

from stickslip.declared.dimensions import Dimension


def in_si(key: str, given: float | str, dimension: Dimension) -> float:
    """
    Return a number in SI; one without a unit is in it already.

    Raises
    ------
    InputError
        Text that is no number with a unit, or whose unit measures something else.
    """
    if not isinstance(given, str):
        return given
    from stickslip.declared.prescribed import sized

    return sized(given, dimension.unit, key)
