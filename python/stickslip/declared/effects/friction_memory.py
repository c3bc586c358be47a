"""Friction that lags behind the sliding speed."""

from collections.abc import Collection

from stickslip.declared.acts import Acts
from stickslip.declared.effect_kind import EffectKind, time_constant
from stickslip.declared.effect_terms import Before, Behaves, Numbers
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw


def hidden_start(_: Numbers, before: Before) -> tuple[float, float]:
    """The lagged speed starts at the speed."""
    return before.v, max(abs(before.v), abs(before.belt_speed))


def idle(law: FrictionLaw, effects: Collection[str]) -> str | None:
    """Friction that no speed changes has nothing to remember."""
    if not isinstance(law, CoulombFriction) or "stribeck_peak" in effects:
        return None
    words = "which does not depend on the speed; give another law, or add 'stribeck_peak'"
    return f"effect 'friction_memory' does nothing to the friction of a CoulombFriction, {words}"


EFFECT = EffectKind(
    "friction_memory",
    "contact",
    "R at the lagged speed |w|, tau w' = v - w; w = 0 on sticking",
    words="friction that lags behind the sliding speed",
    parameters=(time_constant((0.004, 2.0)),),
    depends_on=("v_w", "memory"),
    hidden=("w",),
    on_belt=130,
    starts=({"tau": 0.03}, {"tau": 0.2}),
    behaves=Behaves(hidden_start=hidden_start, idle=idle),
    drawn={"tau": 0.1},
    anywhere=Acts(refused="its speed starts anew at every stick; a law by a formula with a state acts there"),
)
