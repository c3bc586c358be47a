"""A drive that lags behind its command."""

from stickslip.declared.acts import NO_DRIVE_FORCE
from stickslip.declared.effect_kind import EffectKind, time_constant

EFFECT = EffectKind(
    "drive_lag",
    "drive",
    "tau f' = F - f, f the force that acts",
    words="a drive that lags behind its command",
    parameters=(time_constant(),),
    depends_on=("F",),
    hidden=("f",),
    on_slider=180,
    drawn={"tau": 0.006},
    anywhere=NO_DRIVE_FORCE,
)
