"""Friction that grows and falls with the normal force from the angle body."""

from collections.abc import Callable

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import DAMPING, STIFFNESS
from stickslip.declared.effect_kind import EffectKind, free
from stickslip.declared.effect_terms import Adds, At, Numbers, Sides, Value


def rise(p: Numbers, at: At) -> Value:
    """How much more the contact is pressed than at rest, as a share."""
    return (p["beta2"] * at.y1 + p["eta2"] * at.y2) / at.static_minus


def share(p: Numbers, at: At) -> Value:
    """Share of friction; a contact that is lifted has none."""
    return rise(p, at) if at.sides["normal_force_feedback"] else -1.0


def touching(p: Numbers, at: At) -> Value:
    """1 while the normal force is positive, else 0."""
    return 1 + rise(p, at) > 0


def ends(p: Numbers, side: int) -> dict[str, tuple[Callable[[At], Value], int]]:
    """The contact lifts, or touches again."""
    return {"normal": (lambda at: -(1 + rise(p, at)) if side else 1 + rise(p, at), 1 - side)}


EFFECT = EffectKind(
    "normal_force_feedback",
    "contact",
    "friction times max(0, 1 + (beta2 y1 + eta2 y2)/T_s), T_s that of T_-",
    words="friction that grows and falls with the normal force from the angle body",
    parameters=(
        free("beta2", "stiffness feedback", STIFFNESS, 20.0),
        free("eta2", "damping feedback", DAMPING, 20.0),
    ),
    depends_on=("y1", "y2"),
    two_degree=True,
    on_belt=100,
    scored_at={"beta2": 0.0, "eta2": 0.0},
    adds=Adds(friction=share, sides=Sides(touching, ends)),
    drawn={"beta2": 2.0, "eta2": 1.0},
    anywhere=Acts(factor="max(0, 1 + (beta2*other + eta2*other_rate)/T_s)"),
)
