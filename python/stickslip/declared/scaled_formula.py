"""An effect by a formula in SI on a named rig whose own numbers are others: variables are turned, its numbers stay."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stickslip.declared.dimensions import FORCE, LENGTH, NUMBER, SPEED, TIME, Dimension
from stickslip.declared.effect import FormulaEffect
from stickslip.declared.formula.tree import Apply, Name, Number, Tree, substituted, written
from stickslip.declared.rig import Scales

VARIABLES: Mapping[str, Dimension] = {
    **dict.fromkeys(("x1", "y1", "deflection", "position", "travel", "reading"), LENGTH),
    **dict.fromkeys(("x2", "y2", "deflection_rate", "u", "v"), SPEED),
    "t": TIME,
    "dwell": TIME,
}
MAKES: Mapping[str, Dimension] = {"force": FORCE, "factor": NUMBER, "reading": LENGTH}


def in_scales(one: FormulaEffect, scales: Scales | None) -> FormulaEffect:
    """Return the effect as a model in these scales has it, bare and without ranges; None: its numbers are bare already.

    Its own numbers are those in SI: -c*deflection_rate becomes -c*(0.2*deflection_rate)/5, where the model's unit of
    speed is 0.2 m/s and that of force 5 N.
    """
    bare = tuple((name, size, None) for name, size, _ in one.given)
    if scales is None:
        return replace(one, given=bare, ranges={})
    own = one.parameters
    by: dict[str, Tree] = {
        name: _times(measure.size(scales), Name(name))
        for name, measure in VARIABLES.items()
        if name not in own
    }
    tree = substituted(one.trees()[one.acts], by)
    size = MAKES[one.acts].size(scales)
    made = tree if size == 1 else Apply("divide", (tree, Number(size)))
    return replace(one, formula=written(made), given=bare, ranges={})


def _times(size: float, name: Name) -> Tree:
    return name if size == 1 else Apply("multiply", (Number(size), name))
