"""Rigs, laws, effects and models that cannot be."""

from pathlib import Path

from bad_input import bad_input
from stickslip.declared.effect import effect, tabulated
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model, load_model
from stickslip.declared.rig import BlockOnBelt, Rig

ND = {"alpha1": 16.0, "alpha2": 8.0, "beta3": 4.0, "eta1": 0.1, "eta12": 0.2}
SI = {
    "m": 40.0,
    "J": 0.3,
    "r": 0.1,
    "k1": 6000.0,
    "k2": 400.0,
    "k3": 1200.0,
    "c1": 2.0,
    "c2": 3.0,
    "length": 0.01,
}
MODEL_TOML = """\
[rig]
alpha1 = 16.0
alpha2 = 8.0
beta3 = 4.0
eta1 = 0.1
eta12 = 0.2

[[effect]]
name = "belt_seam"
a = 0.1
L = 3.0
"""

RIG = "Rigs"
LAW = "Friction laws"
EFFECT = "Effects"
MODEL = "Models"


def model() -> Model:
    return Model(Rig(**ND), friction=PaperFriction(), effects=[effect("belt_seam", a=0.1, L=3.0)])


def from_file(folder: Path, text: str) -> Model:
    (folder / "model.toml").write_text(text)
    return load_model(folder / "model.toml")


for name, changed in (
    ("zero mass", {"m": 0.0}),
    ("negative mass", {"m": -40.0}),
    ("zero coupling stiffness", {"k2": 0.0}),
    ("negative stiffness", {"k3": -1.0}),
    ("negative damping", {"c2": -0.1}),
    ("zero length", {"length": 0.0}),
    ("a mass that is a force", {"m": "40 N"}),
    ("a leg too short for a number", {"r": 1e-300}),
    ("a constant it has not", {"k4": 1.0}),
):
    bad_input(RIG, f"SI rig, {name}")(lambda _folder, changed=changed: Rig.from_si(**{**SI, **changed}))
for name, changed in (
    ("alpha1 below 1", {"alpha1": 0.5}),
    ("zero inertia", {"alpha2": 0.0}),
    ("negative damping", {"eta1": -0.1}),
    ("eta12 below eta1", {"eta12": 0.05}),
    ("NaN", {"beta3": float("nan")}),
    ("infinity", {"alpha1": float("inf")}),
    ("a truth value", {"alpha1": True}),
    ("misspelt coupling", {"coupling": "as printed"}),
):
    bad_input(RIG, f"rig of (2.1), {name}")(lambda _folder, changed=changed: Rig(**{**ND, **changed}))
for name, changed in (
    ("zero mass", {"mass": 0}),
    ("zero stiffness", {"stiffness": 0}),
    ("negative damping", {"damping": -1}),
):
    bad_input(RIG, f"block on a belt, {name}")(lambda _folder, changed=changed: BlockOnBelt(**changed))


@bad_input(RIG, "rig of (2.1), a misspelt number")
def misspelt_number(_folder: Path) -> None:
    Rig(alfa1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)  # type: ignore[call-arg]


@bad_input(RIG, "rig of (2.1), a number left out")
def number_left_out(_folder: Path) -> None:
    Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1)  # type: ignore[call-arg]


@bad_input(RIG, "rig of (2.1), numbers without their names")
def nameless(_folder: Path) -> None:
    Rig(16, 8, 4, 0.1, 0.2)  # type: ignore[misc, call-arg]


@bad_input(RIG, "SI constants of a nondimensional rig")
def no_scales(_folder: Path) -> None:
    Rig(**ND).to_si()


for name, changed in (
    ("T_min above T_s", {"T_min_minus": 6.0}),
    ("negative T_min (R turns negative)", {"T_min_plus": -0.1}),
    ("t1 = 0", {"t1": 0.0}),
    ("t2 < 0", {"t2": -0.3}),
    ("fitted range on the wrong side", {"v_w_min": 0.28}),
    ("NaN", {"A1": float("nan")}),
):
    bad_input(LAW, f"paper, {name}")(lambda _folder, changed=changed: PaperFriction(**changed))


@bad_input(LAW, "Coulomb, kinetic above static")
def kinetic_above_static(_folder: Path) -> None:
    CoulombFriction(static=1.0, kinetic=1.2)


@bad_input(LAW, "Coulomb, kinetic above static in one direction")
def kinetic_above_static_plus(_folder: Path) -> None:
    CoulombFriction(static=1.0, kinetic=0.8, static_plus=0.7)


@bad_input(LAW, "Coulomb, a force in millimetres")
def force_in_mm(_folder: Path) -> None:
    CoulombFriction(static="2 mm", kinetic="1 N")


@bad_input(LAW, "Coulomb, a torque where the block slides")
def torque_on_a_block(_folder: Path) -> None:
    Model(BlockOnBelt(), friction=CoulombFriction(static="2 N m", kinetic="1 N m"))


@bad_input(LAW, "paper, newtons on a nondimensional rig")
def newtons_without_scales(_folder: Path) -> None:
    Model(Rig(**ND), friction=PaperFriction(T_s_minus="20 N"))


@bad_input(LAW, "paper, half a name")
def half_a_name(_folder: Path) -> None:
    PaperFriction(T_s=5.0)  # type: ignore[call-arg]


for name, changed in (
    ("R turns negative", {"constant": -0.2}),
    ("R turns negative at high speed", {"quadratic": -0.01}),
    ("R negative at rest", {"constant": -2.0}),
):
    bad_input(LAW, f"hyperbolic, {name}")(lambda _folder, changed=changed: HyperbolicFriction(**changed))


@bad_input(EFFECT, "unknown effect")
def unknown_effect(_folder: Path) -> None:
    effect("belt_seem", a=0.1, L=2.0)


@bad_input(EFFECT, "a word of an effect's name")
def word_of_a_name(_folder: Path) -> None:
    effect("ripple", a=0.1, w=6.0)


@bad_input(EFFECT, "an effect like none")
def like_none(_folder: Path) -> None:
    effect("foo")


@bad_input(EFFECT, "a parameter without its name")
def nameless_parameter(_folder: Path) -> None:
    effect("sensor_lag", 0.1)  # type: ignore[call-arg]


@bad_input(EFFECT, "unknown parameter")
def unknown_parameter(_folder: Path) -> None:
    effect("static_aging", dt=0.1, tau=2.0)


@bad_input(EFFECT, "missing parameter")
def missing_parameter(_folder: Path) -> None:
    effect("stribeck_peak", dT=0.5)


@bad_input(EFFECT, "time constant of 0")
def zero_time_constant(_folder: Path) -> None:
    effect("sensor_lag", tau=0)


@bad_input(EFFECT, "tabulated, knots that do not increase")
def knots_fall(_folder: Path) -> None:
    tabulated("contact", "v_w", [0, 0.2, 0.1], [0, 1, 2])


@bad_input(EFFECT, "tabulated, knots that are one number")
def one_knot(_folder: Path) -> None:
    tabulated("contact", "v_w", 0.1, [0, 1])  # type: ignore[arg-type]


@bad_input(EFFECT, "tabulated, a place that is none")
def no_such_place(_folder: Path) -> None:
    tabulated("blok", "v_w", [0, 0.2], [0, 1])


for name, changed in (
    ("a misspelt argument", {"efects": []}),
    ("effects that are None", {"effects": None}),
    ("an effect by its mere name", {"effects": ["sensor_lag"]}),
    ("an effect without its brackets", {"effects": effect("sensor_lag", tau=0.1)}),
    ("noise that is a number", {"noise": 1e-3}),
    ("channels that are a number", {"channels": 3}),
    ("a law that is a class", {"friction": PaperFriction}),
):
    given = {"rig": Rig(**ND), "friction": PaperFriction(), **changed}  # type: ignore[dict-item]
    bad_input(MODEL, name)(lambda _folder, given=given: Model(**given))


@bad_input(MODEL, "no friction law")
def no_law(_folder: Path) -> None:
    Model(Rig(**ND))  # type: ignore[call-arg]


@bad_input(MODEL, "None for a file")
def no_path(_folder: Path) -> None:
    load_model(None)  # type: ignore[arg-type]


@bad_input(MODEL, "unknown parameter")
def replace_unknown(_folder: Path) -> None:
    model().replace(alfa1=15)


@bad_input(MODEL, "parameter given to the wrong place")
def replace_belt_speed(_folder: Path) -> None:
    model().replace(belt_speed=0.2)


@bad_input(MODEL, "ambiguous short name")
def ambiguous(_folder: Path) -> None:
    both = [effect("spring_cubic_k1", k=1.0), effect("spring_cubic_k3", k=1.0)]
    model().with_effects(both).replace({"effect.k": 2.0})


@bad_input(MODEL, "effect there twice")
def twice(_folder: Path) -> None:
    model().with_effects([effect("sensor_lag", tau=0.1), effect("sensor_lag", tau=0.2)])


@bad_input(MODEL, "angle-body effect on a block on a belt")
def no_angle_body(_folder: Path) -> None:
    Model(BlockOnBelt(), friction=CoulombFriction(), effects=[effect("spring_cubic_k3", k=1.0)])


for tried, before, after in (
    ("file, misspelt key", "alpha1 =", "alfa1 ="),
    ("file, misspelt table", "[rig]", "[rigg]"),
    ("file, missing number", "eta1 = 0.1\n", ""),
    ("file, negative number", "eta1 = 0.1", "eta1 = -0.1"),
    ("file, text for a number", "eta1 = 0.1", 'eta1 = "0.1"'),
    ("file, not TOML", "beta3 = 4.0", "beta3 = 4,0"),
    ("file, unknown effect", "belt_seam", "belt_seems"),
    ("file, unknown effect parameter", "L = 3.0", "l = 3.0"),
    ("file, effect parameter out of bounds", "L = 3.0", "L = 0.0"),
    ("file, SI and nondimensional mixed", "alpha1 = 16.0", "alpha1 = 16.0\nm = 40.0"),
    ("file, unknown kind of rig", "[rig]", '[rig]\nkind = "two_degrees"'),
    ("file, unknown law", "[[effect]]", '[friction]\nkind = "columb"\n[[effect]]'),
    ("file, a case instead of a model", "[[effect]]\nname", "[[run]]\nfile"),
):
    assert before in MODEL_TOML
    text = MODEL_TOML.replace(before, after)
    bad_input(MODEL, tried)(lambda folder, text=text: from_file(folder, text))


@bad_input(MODEL, "no such file")
def no_such_file(folder: Path) -> None:
    load_model(folder / "model_affter.toml")


@bad_input(MODEL, "a file for the folder to save in")
def no_folder(folder: Path) -> None:
    (folder / "results").write_text("not a folder")
    model().save(folder / "results" / "model.toml")
