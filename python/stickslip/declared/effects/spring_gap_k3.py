"""A stop that the angle body meets beyond a gap."""

from collections.abc import Callable

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import LENGTH, STIFFNESS
from stickslip.declared.effect_kind import EffectKind, not_negative, positive
from stickslip.declared.effect_terms import Adds, At, Numbers, Sides, Value


def force(p: Numbers, at: At) -> Value:
    """Force on the angle body, on the frozen side of the gap."""
    side = at.sides["spring_gap_k3"]
    return -p["k"] * (at.y1 - side * p["d"]) if side else 0.0


def touched(p: Numbers, at: At) -> Value:
    """The stop that is touched, -1 or 1; 0 within the gap."""
    return np.sign(at.y1) if abs(at.y1) > p["d"] else 0


def ends(p: Numbers, side: int) -> dict[str, tuple[Callable[[At], Value], int]]:
    """A stop is met, or left."""
    d = p["d"]
    if side:
        return {"gap": (lambda at: d - side * at.y1, 0)}
    return {"gap+": (lambda at: at.y1 - d, 1), "gap-": (lambda at: -at.y1 - d, -1)}


EFFECT = EffectKind(
    "spring_gap_k3",
    "angle_body",
    "-k (y1 -+ d) beyond |y1| > d",
    words="a stop that the angle body meets beyond a gap",
    parameters=(
        not_negative("k", "stiffness of the stop", STIFFNESS, (0.01, 500.0)),
        positive("d", "half width of the gap", LENGTH, (0.001, 2.0), of_size=True),
    ),
    depends_on=("y1",),
    two_degree=True,
    on_belt=60,
    starts=({"k": 3.0, "d": 0.3}, {"k": 3.0, "d": 0.6}),
    adds=Adds(angle_body=force, sides=Sides(touched, ends)),
    drawn={"k": 60.0, "d": 0.03},
    anywhere=Acts(force="k*(max(0, -deflection - d) - max(0, deflection - d))"),
)
