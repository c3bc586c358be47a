"""A contact that yields before it slips: no rigid stick."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import DAMPING, STIFFNESS
from stickslip.declared.effect_kind import EffectKind, not_negative, positive
from stickslip.declared.effect_terms import Before, Behaves, Numbers


def hidden_start(p: Numbers, before: Before) -> tuple[float, float]:
    """The bristle starts at what friction bends it to."""
    return float(before.law.force(before.v)) / p["k"], 3.0 / p["k"]


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
    behaves=Behaves(hidden_start=hidden_start),
    drawn={"k": 200.0, "c": 0.5},
    anywhere=Acts(bristle="k*z + c*v", states={"z": ("v - k*u*z/R", "0")}),
)
