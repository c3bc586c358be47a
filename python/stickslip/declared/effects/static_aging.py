"""Static friction that grows with the time at rest."""

from collections.abc import Collection

import numpy as np

from stickslip.declared.acts import Acts
from stickslip.declared.dimensions import FORCE
from stickslip.declared.effect_kind import EffectKind, free, time_constant
from stickslip.declared.effect_terms import Adds, Behaves, Numbers, Value
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.lacking_friction import takes_too_much


def growth(p: Numbers, dwell: Value) -> Value:
    """What the static limits have more after a rest."""
    return p["dT"] * (1 - np.exp(-dwell / p["tau"]))


def idle(_: FrictionLaw, effects: Collection[str]) -> str | None:
    """A yielding contact has no static limits."""
    if "contact_compliance" not in effects:
        return None
    words = "has no rigid stick whose static limits could grow; give one of the two"
    return f"effect 'static_aging' does nothing beside 'contact_compliance', which {words}"


def drives(p: Numbers, law: FrictionLaw, _: float, __: float) -> str | None:
    """Limits that fall may fall below zero."""
    lacking = p["dT"] < 0 and min(law.static_limits) + p["dT"] < 0
    return takes_too_much("static_aging", p["dT"], law) if lacking else None


EFFECT = EffectKind(
    "static_aging",
    "contact",
    "static limits plus dT (1 - exp(-dwell/tau))",
    words="static friction that grows with the time at rest",
    parameters=(
        free("dT", "growth at long rest", FORCE, 5.0, as_named=True),
        time_constant((0.05, 50.0)),
    ),
    depends_on=("memory",),
    hidden=("dwell",),
    on_belt=120,
    starts=({"dT": 0.3, "tau": 0.5}, {"dT": 0.3, "tau": 2.0}),
    scored_at={"dT": 0.0, "tau": 1.5},
    adds=Adds(aging=growth),
    behaves=Behaves(idle=idle, drives=drives),
    drawn={"dT": 1.0, "tau": 2.0},
    anywhere=Acts(aging="dT*(1 - exp(-dwell/tau))"),
)
