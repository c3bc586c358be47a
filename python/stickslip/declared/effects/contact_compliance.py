"""A contact that yields before it slips: no rigid stick."""

from stickslip.declared.dimensions import DAMPING, STIFFNESS
from stickslip.declared.effect_kind import EffectKind, not_negative, positive

EFFECT = EffectKind(
    "contact_compliance",
    "contact",
    "bristle z' = v - k |v| z/R(u), T = k z + c v; no rigid stick",
    words="a contact that yields before it slips: no rigid stick",
    parameters=(
        positive("k", "bristle stiffness", STIFFNESS, (20.0, 4000.0)),
        not_negative("c", "bristle damping", DAMPING, (0.001, 20.0)),
    ),
    depends_on=("v_w", "memory"),
    hidden=("z",),
    on_belt=160,
    on_slider=40,
    starts=({"k": 350.0, "c": 0.5}, {"k": 1500.0, "c": 1.0}),
)
