"""A mass other than the declared one."""

from stickslip.declared.acts import NO_DECLARED_NUMBER
from stickslip.declared.effect_kind import EffectKind, relative_error

EFFECT = EffectKind(
    "rig_mass",
    "block",
    "the mass is (1 + e) times the declared one",
    words="a mass other than the declared one",
    parameters=(relative_error(),),
    depends_on=(),
    on_belt=240,
    on_slider=200,
    corrects="mass",
    drawn={"e": 0.3},
    anywhere=NO_DECLARED_NUMBER,
)
