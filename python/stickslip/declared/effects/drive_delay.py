"""A drive that acts late."""

from stickslip.declared.acts import NO_DRIVE_FORCE
from stickslip.declared.dimensions import TIME
from stickslip.declared.effect_kind import EffectKind, free

EFFECT = EffectKind(
    "drive_delay",
    "drive",
    "the drive acts late",
    words="a drive that acts late",
    parameters=(free("delay", "delay, negative if early", TIME),),
    depends_on=("F",),
    on_slider=190,
    drawn={"delay": 0.006},
    anywhere=NO_DRIVE_FORCE,
)
