"""What a simulation needs of a friction law: trees of its magnitudes, its force, and the rates of its states.

A rigid law has a kinetic magnitude R at u = |v| and a static limit: T = sgn(v) R, and stick. A compliant one has a
force T(v) alone, and never sticks; u = |v| makes its kink at v = 0. Names that every tree may read are `VARIABLES`,
the law's own numbers and states, and `<state>_rate` in a force.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stickslip.declared.dimensions import NUMBER, SPEED, TIME, Dimension
from stickslip.declared.formula.tree import Name, Tree, substituted

VARIABLES: Mapping[str, Dimension] = {"u": SPEED, "v": SPEED, "t": TIME, "dwell": TIME}
READS = {  # what each formula may depend on, beside numbers and states
    "kinetic": ("u", "t"),
    "static": ("dwell", "t"),
    "force": ("u", "v", "t"),
    "rate": ("u", "v", "t"),
    "start": ("u", "v"),
}


@dataclass(frozen=True)
class StateForm:
    """A state of a law: its name, what it measures, and what it starts as, a tree of u and v."""

    name: str
    start: Tree
    dimension: Dimension | str = NUMBER


@dataclass(frozen=True)
class BranchForm:
    """One direction of sliding: trees of the magnitudes of a rigid law, or of the force of a compliant one."""

    kinetic: Tree | None = None
    static: Tree | None = None
    force: Tree | None = None
    rates: tuple[Tree, ...] = ()

    def trees(self) -> tuple[Tree, ...]:
        """Every tree that there is."""
        return tuple(one for one in (self.kinetic, self.static, self.force, *self.rates) if one is not None)

    def renamed(self, names: Mapping[str, str]) -> BranchForm:
        """Return the same with other numbers: the twins of the other direction."""
        by: dict[str, Tree] = {name: Name(twin) for name, twin in names.items()}

        def turned(tree: Tree | None) -> Tree | None:
            return None if tree is None else substituted(tree, by)

        rates = tuple(substituted(one, by) for one in self.rates)
        return BranchForm(turned(self.kinetic), turned(self.static), turned(self.force), rates)


@dataclass(frozen=True)
class LawForm:
    """A law as it is simulated: its branches for v < 0 and v > 0, its numbers, its states."""

    minus: BranchForm
    plus: BranchForm
    numbers: Mapping[str, float]
    states: tuple[StateForm, ...] = ()

    @property
    def compliant(self) -> bool:
        """It gives a force at every speed, and no stick."""
        return self.minus.force is not None

    def branch(self, direction: int) -> BranchForm:
        """Return the branch for sliding with the sign `direction`."""
        return self.plus if direction > 0 else self.minus
