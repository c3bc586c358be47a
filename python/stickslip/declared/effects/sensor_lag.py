"""A lag of the x1 sensor."""

from stickslip.declared.acts import Acts
from stickslip.declared.effect_kind import EffectKind, time_constant
from stickslip.declared.effect_terms import Before, Behaves, Numbers


def hidden_start(p: Numbers, before: Before) -> tuple[float, float]:
    """The lagged deflection starts as far behind as a steady motion leaves it."""
    return before.read - p["tau"] * before.read_rate, 0.05 + p["tau"] * abs(before.v)


EFFECT = EffectKind(
    "sensor_lag",
    "x1 channel",
    "first-order lag of the reading",
    words="a lag of the x1 sensor",
    parameters=(time_constant((0.004, 3.0)),),
    depends_on=("x1", "memory"),
    hidden=("m",),
    on_belt=190,
    starts=({"tau": 0.05},),
    behaves=Behaves(hidden_start=hidden_start),
    drawn={"tau": 0.3},
    anywhere=Acts(reading="m", states={"m": ("(reading - m)/tau", "reading")}),
)
