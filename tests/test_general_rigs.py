"""Rigs by their bodies or their matrices: in TOML and in Python, checked, and refused where they have no place."""

import pickle
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.errors import InputError, ModelWarning

DRILL = """
[rig]
kind = "bodies"

[rig.body.table]
inertia = "0.35 kg m^2"

[rig.body.bit]
inertia = "0.04 kg m^2"

[[rig.link]]
between = ["table", "bit"]
stiffness = "12 N m/rad"
damping = "0.01 N m s/rad"

[[rig.link]]
between = ["table", "drive"]
stiffness = "80 N m/rad"

[[rig.contact]]
body = "bit"
against = "ground"
law = "bit_law"

[law.bit_law]
kind = "stribeck"
F_c = "1.2 N m"
F_s = "2 N m"
v_s = "10 rpm"
"""
MATRICES = """
[rig]
kind = "matrices"
M = [[16, 0], [0, 8]]
C = [[0.1, 0.1], [0.1, 0.2]]
K = [[16, 1], [1, 4]]
contact = [1, 0]
names = ["x", "y"]
unit = "m"

[friction]
kind = "coulomb"
static = "5 N"
kinetic = 3000
"""


def load(folder: Path, text: str) -> ss.Model:
    (folder / "model.toml").write_text(text)
    return ss.load_model(folder / "model.toml")


def drill(**law: object) -> ss.Model:
    rig = ss.BodiesRig(
        body={"table": ss.Body(inertia=0.35), "bit": ss.Body(inertia=0.04)},
        link=[
            ss.Link(between=("table", "bit"), stiffness=12, damping=0.01),
            ss.Link(between=("table", "drive"), stiffness=80),
        ],
        contact=[ss.Contact(body="bit", law="bit_law")],
    )
    numbers = {"F_c": 1.2, "F_s": 2, "v_s": 10 * 2 * np.pi / 60, **law}
    return ss.Model(rig, friction={"bit_law": ss.StribeckFriction(**numbers)})  # type: ignore[arg-type, dict-item]


def test_a_rig_by_its_bodies_is_the_same_in_a_file_and_in_python(tmp_path: Path) -> None:
    model = load(tmp_path, DRILL)
    ours = drill(v_s="10 rpm")
    assert model == ours
    own = model.rig.equations
    np.testing.assert_array_equal(own.M, np.diag([0.35, 0.04]))
    np.testing.assert_array_equal(own.K, [[92, -12], [-12, 12]])
    np.testing.assert_array_equal(own.C, [[0.01, -0.01], [-0.01, 0.01]])
    np.testing.assert_array_equal(own.drive_stiffness, [80, 0])
    assert own.contacts[0].rotation
    assert model.rig.state_names == ("table", "bit", "v_table", "v_bit")


@pytest.mark.parametrize("text", [DRILL, MATRICES.replace("3000", "3.0")])
def test_a_general_rig_comes_back_from_its_file_and_from_a_pickle(tmp_path: Path, text: str) -> None:
    model = load(tmp_path, text)
    model.save(tmp_path / "again.toml")
    assert ss.load_model(tmp_path / "again.toml") == model
    assert pickle.loads(pickle.dumps(model)) == model
    assert hash(model.rig) == hash(pickle.loads(pickle.dumps(model.rig)))
    assert type(model.rig).__name__ in repr(model)


def test_numbers_have_names_and_can_be_replaced(tmp_path: Path) -> None:
    model = load(tmp_path, DRILL)
    assert model.parameters["link_1.stiffness"] == 12
    assert model.parameters["bit_law.F_s"] == 2
    other = model.replace(
        {"link_1.stiffness": 13.0, "bit_law.F_s": 2.5, "bit.inertia": 0.05, "bit_law.F_c_plus": 1.0}
    )
    assert other.rig.equations.K[1, 1] == 13
    assert other.parameters["bit_law.F_s"] == 2.5
    assert other.parameters["bit_law.F_c_plus"] == 1.0
    assert other.rig.equations.M[1, 1] == 0.05
    with pytest.raises(InputError, match=r"did you mean 'link_1\.stiffness'"):
        model.replace({"link_1.stiffnes": 13.0})
    matrices = load(tmp_path, MATRICES.replace("3000", "3"))
    assert matrices.replace(K_22=5.0, static=6.0).parameters["K_22"] == 5


def test_what_joins_a_slide_and_a_turn_has_a_lever_arm() -> None:
    rig = ss.BodiesRig(
        body={"block": {"mass": "2 kg"}, "disc": {"inertia": "0.01 kg m^2"}},  # type: ignore[dict-item]  # tables
        link=[
            {"between": ["block", "disc"], "gear": "50 mm", "stiffness": "12 N/mm", "rest": "1 mm"},  # type: ignore[list-item]
            {"between": ["disc", "ground"], "stiffness": "2 N m/rad", "rest": "30 deg"},  # type: ignore[list-item]
        ],
        contact=[ss.Contact(body="disc", against="belt", arm="20 mm"), ss.Contact(body="block")],
    )
    own = rig.equations
    np.testing.assert_allclose(own.K, [[12000, -600], [-600, 32]])
    np.testing.assert_allclose(own.force, [12, -0.6 + 2 * np.pi / 6])
    np.testing.assert_array_equal(own.directions, [[0, 0.02], [1, 0]])
    assert [one.rotation for one in own.contacts] == [False, False]


def test_two_bodies_may_rub_on_each_other() -> None:
    rig = ss.BodiesRig(
        body={"a": ss.Body(mass=1), "b": ss.Body(mass=2)},
        contact=[ss.Contact(body="a", against="b", name="between"), ss.Contact(body="b")],
    )
    np.testing.assert_array_equal(rig.equations.directions, [[1, -1], [0, 1]])


WRONG = [
    (
        "0.35 kg m^2",
        "0.35 kg",
        r"line 6, \[rig body table\] key 'inertia'.*is a mass \(kg\); it must be an inertia",
    ),
    ("12 N m/rad", "12 N m", r"line 13, \[rig link 1\] key 'stiffness'.*is a torque \(N m\)"),
    ("12 N m/rad", "-12 kg/rad", r"it must be a stiffness of a rotation \(N m/rad\)"),
    ("12 N m/rad", "12 N mm/radd", "unknown unit"),
    (
        '"table", "bit"]',
        '"tabel", "bit"]',
        r"line 12, .*key 'between': no body 'tabel'; did you mean 'table'",
    ),
    ('"table", "drive"]', '"table", "belt"]', "a link is pulled by the 'drive'"),
    ('"table", "drive"]', '"table", "table"]', "joins two different ends"),
    ('"table", "drive"]', '"ground", "drive"]', "one end must be a body"),
    (
        'body = "bit"',
        'body = "bt"',
        r"line 21, \[rig contact 1\] key 'body': no body 'bt'; did you mean 'bit'",
    ),
    ('body = "bit"', "", "lacks 'body'"),
    ('against = "ground"', 'against = "drive"', "what a contact rubs on is the 'belt'"),
    ('law = "bit_law"', 'law = "bitlaw"', "no law 'bitlaw' of contact 'bit'; did you mean 'bit_law'"),
    ('"2 N m"', '"2 N"', r"key 'F_s'.*is a force \(N\); at a contact that turns it must be a torque \(N m\)"),
    ("10 rpm", "10 mm/s", r"is a speed \(m/s\); at a contact that turns it must be an angular speed"),
    ("10 rpm", "10 Hz", r"is a rate \(1/s\)"),
    ("between", "betwixt", "did you mean 'between'"),
    ("[rig.body.table]", "[rig.body.drive]", "is taken; name it otherwise"),
    ("[rig.body.table]", "[rig.body.'a b']", "is no name"),
    ("[rig.body.table]", "[rig.body.v_bit]", "names two states"),
    ('inertia = "0.04 kg m^2"', 'inertia = "0 kg m^2"', "must be above 0"),
    ('inertia = "0.04 kg m^2"', 'mas = "1 kg"', "did you mean 'mass'"),
    ("[law.bit_law]", "[friction]\nkind = 'coulomb'\n[law.bit_law]", r"not both"),
    ("[law.bit_law]", "[law.other]\nkind = 'coulomb'\n[law.bit_law]", "no contact names it"),
    ('kind = "stribeck"', 'kind = "stribek"', "did you mean 'stribeck'"),
    (
        "[[rig.contact]]",
        "[[rig.contact]]\nbody = 'bit'\n[[rig.contact]]",
        "contact 2.*acts on the same direction as contact 1",
    ),
]


@pytest.mark.parametrize(("right", "wrong", "words"), WRONG)
def test_what_is_wrong_in_a_rig_of_bodies_is_said_in_a_line(
    tmp_path: Path, right: str, wrong: str, words: str
) -> None:
    assert right in DRILL
    with pytest.raises(InputError, match=words) as caught:
        load(tmp_path, DRILL.replace(right, wrong, 1))
    assert "\n" not in str(caught.value)
    assert "model.toml" in str(caught.value)


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("[0, 8]", "[0, 0]", "key 'M': is singular: a coordinate has no inertia"),
        ("[0, 8]", "[0, -8]", "eigenvalue -8"),
        ("[[16, 0]", "[[16, 1]", "must be symmetric"),
        ("[1, 4]]", "[1]]", "of rows of different length"),
        ("contact = [1, 0]", "contact = [1, 0, 0]", "3 numbers for 2 coordinates"),
        ("contact = [1, 0]", "contact = [0, 0]", "its direction is zero"),
        ("contact = [1, 0]", "contact = [[1, 0], [2, 0]]", "acts on the same direction as contact 1"),
        ("contact = [1, 0]", "contact = [[1, 0], [1, 1], [0, 1]]", "depend on each other"),
        ("contact = [1, 0]", "", "has no contact"),
        ('unit = "m"', 'unit = "mm"', "must be one of m, rad, 1"),
        ('["x", "y"]', '["x"]', "1 names for 2 coordinates"),
        ('["x", "y"]', '["x", "x"]', "names two states"),
        ("K = [[16, 1], [1, 4]]", "", "lacks its matrix 'K'"),
        ("static = ", "statik = ", "did you mean 'static'"),
        ('"5 N"', '"5 N m"', r"is a torque \(N m\)"),
    ],
)
def test_what_is_wrong_in_a_rig_of_matrices_is_said_in_a_line(
    tmp_path: Path, right: str, wrong: str, words: str
) -> None:
    text = MATRICES.replace("3000", "3")
    assert right in text
    with pytest.raises(InputError, match=words) as caught:
        load(tmp_path, text.replace(right, wrong, 1))
    assert "\n" not in str(caught.value)


def test_what_grows_by_itself_is_warned_of_and_a_free_mass_is_not() -> None:
    body = {"a": ss.Body(mass=1)}
    with pytest.warns(ModelWarning, match=r"a stiffness is negative: .* grows as exp\(2 t\)"):
        ss.BodiesRig(body=body, link=[ss.Link(between=("a", "ground"), stiffness=-4)], contact=[])
    with pytest.warns(ModelWarning, match="a damping is negative"):
        ss.BodiesRig(body=body, link=[ss.Link(between=("a", "ground"), stiffness=4, damping=-0.1)])
    with pytest.warns(ModelWarning, match="not symmetric"):
        ss.MatricesRig(M=np.eye(2), K=[[1, 2], [-2, 1]])  # type: ignore[arg-type]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        free = {"a": ss.Body(mass=1), "b": ss.Body(mass=3)}
        ss.BodiesRig(body=free, link=[ss.Link(between=("a", "b"), stiffness=4, damping=1)])


BODIES = ss.BodiesRig(body={"block": ss.Body(mass=1)}, contact=[ss.Contact(body="block", against="belt")])
STRIBECK = ss.StribeckFriction(F_c=1, F_s=2, v_s=0.1)
GENERAL = [
    ss.Model(ss.BlockOnBelt(), friction=STRIBECK),
    ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=STRIBECK),
]
READ: list[Callable[[ss.Model], object]] = [  # of named rigs under a law that is a formula
    lambda model: ss.compare(model, None),  # type: ignore[arg-type]
    lambda model: ss.forecast(model, None, belt_speed=0.1, horizon=1),  # type: ignore[arg-type]
]


@pytest.mark.parametrize("model", GENERAL, ids=lambda model: type(model.rig).__name__)
@pytest.mark.parametrize("ask", READ)
def test_a_formula_on_a_named_rig_is_not_held_against_readings_yet(
    model: ss.Model, ask: Callable[[ss.Model], object]
) -> None:
    with pytest.raises(InputError, match="can be simulated"):
        ask(model)


def test_a_case_of_a_named_rig_under_a_formula_is_refused_in_a_line(tmp_path: Path) -> None:
    law = "[friction]\nkind = 'stribeck'\nF_c = 1\nF_s = 2\nv_s = 0.1\n"
    rig = "[rig]\nkind='block_on_belt'\nm=1\nk=1\n"
    channels = "[channels]\nt={column='t',unit='s'}\nx1={column='x1',unit='m'}\n"
    (tmp_path / "rig.toml").write_text(
        f"{rig}{law}{channels}[[run]]\nfile='run.csv'\nbelt_speed=0.1\nrole='train'\n"
    )
    (tmp_path / "run.csv").write_text("t,x1\n0,0\n1,1\n")
    with pytest.raises(InputError, match="can be simulated"):
        ss.load_case(tmp_path / "rig.toml")


def test_effects_and_laws_that_do_not_go_with_a_rig_are_refused() -> None:
    effect = ss.effect("block_viscous_damping", c=0.5)
    with pytest.raises(InputError, match="pivot_dry_friction: acts on the same direction as contact 1"):
        ss.Model(BODIES, friction=ss.CoulombFriction(), effects=[ss.effect("pivot_dry_friction", f=0.1)])
    with pytest.raises(InputError, match="does not act under the law 'stribeck'"):
        ss.Model(ss.BlockOnBelt(), friction=STRIBECK, effects=[effect])
    with pytest.raises(InputError, match="has one contact, and one law"):
        ss.Model(ss.BlockOnBelt(), friction={"a": STRIBECK})  # type: ignore[arg-type]
    with pytest.raises(InputError, match="of a driven slider is coulomb"):
        ss.Model(ss.DrivenSlider(mass=1), friction=STRIBECK)
    with pytest.raises(InputError, match="nondimensional: give it bare"):
        ss.Model(GENERAL[1].rig, friction=ss.StribeckFriction(F_c="1 N", F_s=2, v_s=0.1))  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"F_c: is a torque"):
        ss.Model(ss.BlockOnBelt(), friction=ss.StribeckFriction(F_c="1 N m", F_s=2, v_s=0.1))  # type: ignore[arg-type]
    own = ss.FormulaFriction(kinetic="F + c*u", F="4 N", c="0.1 N s/m")
    turns = ss.BodiesRig(body={"a": ss.Body(inertia=1)}, contact=[ss.Contact(body="a", law="bit")])
    with pytest.raises(InputError, match=r"bit.kinetic: '\(c \* u\)', .* is added to"):
        ss.Model(turns, friction={"bit": own})  # type: ignore[arg-type]
