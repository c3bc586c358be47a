"""A belt that slows down under load."""

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import SPEED_BY_FORCE
from stickslip.declared.effect_kind import EffectKind, not_negative, time_constant
from stickslip.declared.effect_terms import Before, Behaves, Numbers


def hidden_start(p: Numbers, before: Before) -> tuple[float, float]:
    """The belt starts as slow as friction makes it."""
    k = p["k"]
    return float(before.law.force(before.v)) * k, 5 * k + 0.2 * abs(before.belt_speed)


EFFECT = EffectKind(
    "belt_load_droop",
    "belt",
    "belt speed v_b + b, tau b' = -k F - b, F the belt's force on the block",
    words="a belt that slows down under load",
    parameters=(
        not_negative("k", "droop by force", SPEED_BY_FORCE, (1e-05, 0.2)),
        time_constant((0.03, 20.0)),
    ),
    depends_on=("memory",),
    hidden=("b",),
    on_belt=180,
    starts=({"k": 0.002, "tau": 0.3}, {"k": 0.002, "tau": 2.0}),
    behaves=Behaves(hidden_start=hidden_start),
    drawn={"k": 0.008, "tau": 0.5},
    anywhere=Acts(
        refused="a belt that gives way is a body: link it to the drive, and let the contact rub on it"
    ),
)
