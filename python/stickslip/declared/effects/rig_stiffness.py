"""A spring stiffness other than the declared one."""

from stickslip.declared.acts import NO_DECLARED_NUMBER
from stickslip.declared.effect_kind import EffectKind, relative_error

EFFECT = EffectKind(
    "rig_stiffness",
    "block",
    "the spring is (1 + e) times as stiff as declared; of (2.1), k1 + k2 are (1 + e) m omega^2",
    words="a spring stiffness other than the declared one",
    parameters=(relative_error(),),
    depends_on=(),
    on_belt=250,
    corrects="stiffness",
    drawn={"e": 0.2},
    anywhere=NO_DECLARED_NUMBER,
)
