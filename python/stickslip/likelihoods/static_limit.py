"""The static limit of a law with the numbers of a fit, to which friction of a window's own is relative."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.declared.formula.value import value
from stickslip.declared.friction_law import FrictionLaw

NEARBY = 1e-6  # share of a number by which it is moved for a slope; a limit is linear in the law's numbers


class StaticLimit:
    """
    The static limit of one direction.

    Were a window's own limit relative to the declared law instead, a fit in which nothing holds the scale of forces,
    as of a block whose position alone is read, would lower all forces without end: the smaller the law, the less its
    windows would seem to differ.

    Parameters
    ----------
    law : as declared
    forward : whether the belt goes forward, so that the block slips backward on it
    """

    def __init__(self, law: FrictionLaw, forward: bool) -> None:
        form = law.form()
        static = (form.minus if forward else form.plus).static
        assert static is not None
        self.tree, self.numbers = static, {**form.numbers, "dwell": 0.0, "t": 0.0}
        self.declared = law.static_limits[0 if forward else 1]
        self.as_declared = float(value(self.tree, self.numbers))

    def at(self, values: Mapping[str, float]) -> float:
        """Return the limit at numbers by name."""
        now = {**self.numbers, **{k: v for k, v in values.items() if k in self.numbers}}
        return self.declared * float(value(self.tree, now)) / self.as_declared

    def slope(self, values: Mapping[str, float], name: str) -> float:
        """Return its derivative by a number; 0 by what is none of the law's."""
        if name not in self.numbers:
            return 0.0
        step = NEARBY * max(abs(values[name]), 1e-9)
        ahead, behind = (self.at({**values, name: values[name] + sign * step}) for sign in (1, -1))
        return (ahead - behind) / (2 * step)
