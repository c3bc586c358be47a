"""Numbers of every named law with a unit: as text in Python, as in a file, and of one table of dimensions."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import pytest

import stickslip as ss
from stickslip.declared.laws import ALL_LAWS, LAWS

SI = {
    "m": 42.3,
    "J": 0.277,
    "r": 0.1256,
    "k1": 6243,
    "k2": 362.1,
    "k3": 1234,
    "c1": 2.48,
    "c2": 2.94,
    "length": 8.9e-3,
}

# numbers in SI and the same with units; laws that have no mere default for each of them
GIVEN: dict[str, tuple[dict[str, object], dict[str, object]]] = {
    "coulomb": ({"static": 2.0, "kinetic": 0.5, "kinetic_plus": 0.4},
                {"static": "2 N", "kinetic": "500 mN", "kinetic_plus": "0.4 N"}),
    "hyperbolic": ({"scale": 1.0, "decay": 3.0, "constant": 0.25, "quadratic": 0.125, "scale_plus": 2.0},
                   {"scale": "1 N", "decay": "3 s/m", "constant": "250 mN", "quadratic": "0.125 N s^2/m^2",
                    "scale_plus": "2 N"}),
    "paper": ({"T_s_minus": 6.0, "A1": 3.0, "t1": 0.25, "v_w_min": -0.5, "T_min_plus": 0.5},
              {"T_s_minus": "6 N", "A1": "3 N", "t1": "25 cm/s", "v_w_min": "-50 cm/s", "T_min_plus": "0.5 N"}),
    "stribeck": ({"F_c": 5.0, "F_s": 8.0, "v_s": 0.25, "delta": 2.0, "c": 1.0},
                 {"F_c": "5 N", "F_s": "8 N", "v_s": "25 cm/s", "delta": 2, "c": "1 N s/m"}),
    "dahl": ({"sigma0": 1000.0, "F_c": 1.0}, {"sigma0": "1 N/mm", "F_c": "1 N"}),
    "lugre": ({"sigma0": 1000.0, "sigma1": 2.0, "sigma2": 0.5, "F_c": 1.0, "F_s": 1.5, "v_s": 0.25},
              {"sigma0": "1 N/mm", "sigma1": "2 N s/m", "sigma2": "0.5 N s/m", "F_c": "1 N", "F_s": "1.5 N",
               "v_s": "25 cm/s"}),
    "rate_and_state": ({"mu0": 0.6, "a": 0.01, "b": 0.02, "D_c": 0.5, "V_0": 0.25, "normal": 1000.0},
                       {"mu0": 0.6, "a": 0.01, "b": 0.02, "D_c": "50 cm", "V_0": "25 cm/s", "normal": "1 kN"}),
    "tabulated": ({"speeds": [0, 0.25], "forces": [2, 1], "static": 3.0},
                  {"speeds": ["0 m/s", "25 cm/s"], "forces": ["2 N", "1 N"], "static": "3 N"}),
}  # fmt: skip


# of a law that is not above: what it is drawn with, in the units of its numbers
for _kind, _law in LAWS.items():
    if _kind not in GIVEN:
        _units = {name: _law.dimensions[name].unit for name in _law.drawn}
        _text = {name: f"{size} {_units[name]}" for name, size in _law.drawn.items() if _units[name] != "1"}
        GIVEN[_kind] = dict(_law.drawn), {**_law.drawn, **_text}


def test_every_named_law_is_tried() -> None:
    assert set(GIVEN) == set(ALL_LAWS) - {"formula"}


@pytest.mark.parametrize("kind", GIVEN)
def test_numbers_with_units_make_the_law_of_the_bare_ones(kind: str) -> None:
    bare, text = GIVEN[kind]
    law = ALL_LAWS[kind](**text)
    assert law == ALL_LAWS[kind](**bare)
    assert set(law.declared_units) == {
        name for name, one in text.items() if not isinstance(one, (int, float))
    }
    assert pickle.loads(pickle.dumps(law)) == law


@pytest.mark.parametrize("kind", GIVEN)
def test_a_unit_of_something_else_is_refused_by_its_name(kind: str) -> None:
    bare, text = GIVEN[kind]
    for name, one in text.items():
        wrong = ["3 kg", "4 kg"] if isinstance(one, list) else "3 kg"
        with pytest.raises(ss.InputError, match=rf"{name}(\[0\])? = '3 kg': is a mass \(kg\); it must be "):
            ALL_LAWS[kind](**{**bare, name: wrong})


@pytest.mark.parametrize("kind", ["coulomb", "hyperbolic", "stribeck"])
def test_a_file_says_the_same(kind: str, tmp_path: Path) -> None:
    bare, text = GIVEN[kind]
    numbers = "\n".join(f"{name} = {one!r}" for name, one in text.items()).replace("'", '"')
    file = tmp_path / "model.toml"
    file.write_text(
        f'[rig]\nkind = "block_on_belt"\nm = "1200 g"\nk = "3 N/cm"\n[friction]\nkind = "{kind}"\n{numbers}\n'
    )
    assert ss.load_model(file).friction == ALL_LAWS[kind](**bare)


def test_a_law_made_of_another_keeps_its_units() -> None:
    """Newtons of the first were taken to be the model's numbers in the second, and nothing was said."""
    rig = ss.Rig.from_si(**SI)
    law = ss.PaperFriction(T_s_minus="20 N", T_min_minus="4 N")
    for made in (
        replace(law, T_min_plus=0.5),
        law.with_numbers({"T_min_plus": 0.5}),
        ss.PaperFriction(**{**law.numbers, "T_min_plus": 0.5}),
        replace(pickle.loads(pickle.dumps(copy.deepcopy(law))), T_min_plus=0.5),
    ):
        there, own = (ss.Model(rig, friction=one).friction.numbers for one in (made, law))
        assert there == {**own, "T_min_plus": 0.5}
    turning = ss.TabulatedFriction(speeds=[0, 1], forces=["2 N m", "1 N m"])
    with pytest.raises(ss.InputError, match="forces: is a torque"):
        ss.Model(ss.BlockOnBelt(), friction=replace(turning, speeds=[0, 2]))


def test_newtons_and_numbers_of_the_model_are_compared_in_it() -> None:
    """A static limit of 1 N is 2 in a model whose force is 0.5 N, more than the 1.42 that slip has at least."""
    rig = ss.Rig.from_si(m=1.0, J=0.01, r=0.1, k1=100.0, k2=50.0, k3=20.0, c1=0.1, c2=0.1, length=0.01)
    law = ss.PaperFriction(T_s_minus="1 N")
    assert ss.Model(rig, friction=law).friction.static_limits == (2.0, 3.63)
    for unfit, on in ((ss.PaperFriction(T_s_minus="0.5 N"), rig), (law, ss.BlockOnBelt())):
        with pytest.raises(ss.InputError, match=r"T_min_minus = 1.42: above the static limit T_s_minus = 1"):
            ss.Model(on, friction=unfit)


def test_a_list_has_units_of_one_dimension() -> None:
    with pytest.raises(
        ss.InputError, match="forces: has units of a contact that slides and of one that turns"
    ):
        ss.TabulatedFriction(speeds=[0, 1], forces=["2 N", "1 N m"])


def test_a_torque_is_for_a_contact_that_turns_alone() -> None:
    law = ss.CoulombFriction(static="2 N m", kinetic="1 N m")
    bit = ss.BodiesRig(
        body={"bit": ss.Body(inertia="0.04 kg m^2")},
        link=[ss.Link(between=("bit", "drive"), stiffness="80 N m/rad")],
        contact=[ss.Contact(body="bit")],
    )
    assert ss.Model(bit, friction=law).friction == ss.CoulombFriction(static=2, kinetic=1)
    with pytest.raises(
        ss.InputError, match=r"static: is a torque \(N m\); at a contact that slides it must be"
    ):
        ss.Model(ss.BlockOnBelt(), friction=law)
    with pytest.raises(
        ss.InputError, match=r"static: is a force \(N\); at a contact that turns it must be a torque"
    ):
        ss.Model(bit, friction=ss.CoulombFriction(static="2 N", kinetic="1 N"))


def test_newtons_become_the_numbers_of_a_rig_with_scales() -> None:
    rig = ss.Rig.from_si(**SI)
    assert rig.scales is not None
    law = ss.Model(rig, friction=ss.PaperFriction(T_s_minus="20 N", t1="3 mm/s")).friction
    assert law.numbers["T_s_minus"] == pytest.approx(20 / rig.scales.force, rel=1e-14)
    assert law.numbers["t1"] == pytest.approx(3e-3 / rig.scales.velocity, rel=1e-14)
    assert law.numbers["T_s_plus"] == 3.63  # bare: the model's own
    assert not law.declared_units
    bare = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    with pytest.raises(ss.InputError, match="T_s_minus: has a unit, but the rig is nondimensional"):
        ss.Model(bare, friction=ss.PaperFriction(T_s_minus="20 N"))


def test_recordings_are_held_against_the_law_in_their_model(tmp_path: Path) -> None:
    """What a law with units is given to beside a model: a recording's findings, a case."""
    rig = ss.Rig.from_si(**SI)
    assert rig.scales is not None
    t = [0.02 * i for i in range(400)]
    x = [0.1 * (i % 40) for i in range(400)]  # mm: as far as 20 N hold the spring, about
    channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x", "mm"), "y1": ss.Channel("y", "mm")}
    columns = {"t": t, "x": x, "y": [0.5 * one for one in x]}
    words = [
        [
            str(one)
            for one in ss.load_recording(
                columns, rig, channels=channels, belt_speed=0.01, friction=law
            ).findings
        ]
        for law in (ss.PaperFriction(T_s_minus="20 N"), ss.PaperFriction(T_s_minus=20 / rig.scales.force))
    ]
    assert words[0] == words[1]
    rows = "\n".join(f"{a:.3f},{b:.4f}" for a, b in zip(t, x, strict=True))
    (tmp_path / "run.csv").write_text(f"t,x\n{rows}\n")
    (tmp_path / "rig.toml").write_text(
        '[rig]\nkind = "block_on_belt"\nm = "1.2 kg"\nk = 300.0\n'
        '[friction]\nkind = "coulomb"\nstatic = "200 mN"\nkinetic = "150 mN"\n'
        '[[run]]\nfile = "run.csv"\nrole = "train"\nbelt_speed = 0.005\nto = 4.0\n'
        '[[run]]\nfile = "run.csv"\nrole = "validate"\nbelt_speed = 0.005\nfrom = 4.0\n'
        '[channels]\nt = { column = "t", unit = "s" }\nx1 = { column = "x", unit = "mm" }\n'
    )
    case = ss.load_case(tmp_path / "rig.toml")
    assert case.friction == ss.CoulombFriction(static=0.2, kinetic=0.15)
    assert case.declared_numbers["static_plus"] == 0.2
    text = (tmp_path / "rig.toml").read_text()
    (tmp_path / "rig.toml").write_text(text.replace('mN"', 'mN mm"'))
    with pytest.raises(ss.InputError, match=r"rig.toml line 7, \[friction\] key 'static': is a torque"):
        ss.load_case(tmp_path / "rig.toml")
