"""Numbers of effects with units: the same model as bare ones in its own numbers, or one clear line."""

from __future__ import annotations

from pathlib import Path

import pytest

import stickslip as ss
from bodies_cases import CASES
from every_effect import made
from stickslip.declared.catalogue import CATALOGUE, KINDS
from stickslip.declared.dimensions import DAMPING, NUMBER, STIFFNESS, Dimension, turning
from stickslip.declared.formula.dimension import dimensions
from stickslip.declared.law_numbers import of_contact
from stickslip.declared.si import si_of

IN_SI = ss.Rig.from_si(m=1.5, J=0.005, r=0.07, k1=1500.0, k2=100.0, k3=300.0, c1=1.0, c2=1.0, length=0.01)
BARE = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
BLOCK = ss.BlockOnBelt(mass="1.2 kg", stiffness="850 N/m")
LAW = ss.CoulombFriction(static=3.0, kinetic=2.0)
NUMBERS = [
    (kind.name, info.name) for kind in CATALOGUE.values() for info in kind.parameters if not info.per_run
]


def given(name: str, key: str, as_text: str) -> ss.Effect:
    return ss.effect(name, **{**made(name).parameters, key: as_text})


@pytest.mark.parametrize(("name", "key"), NUMBERS)
def test_every_number_is_turned_by_the_scales_of_the_rig(name: str, key: str) -> None:
    info = KINDS[name].parameter(key)
    unit = "" if info.dimension == NUMBER else info.dimension.unit
    value = made(name).parameters[key] or 1e-3
    model = ss.Model(IN_SI, friction=ss.PaperFriction(), effects=[given(name, key, f"{value} {unit}")])
    si = si_of(f"{name}.{key}", IN_SI)
    assert model.effects[0].parameters[key] == pytest.approx(value / (1.0 if si is None else si.size))


@pytest.mark.parametrize(("name", "key"), NUMBERS)
def test_a_unit_of_something_else_is_refused_by_name(name: str, key: str) -> None:
    with pytest.raises(ss.InputError, match=rf"{name}\.{key}.* it must be "):
        given(name, key, "1 kg K")


@pytest.mark.parametrize(
    ("numbers", "bare"),
    [
        ({"a": "500 mN", "w": "120 rpm", "phi": "90 deg"}, (0.5, 12.566370614359172, 1.5707963267948966)),
        ({"a": "0.5 N", "w": "2 rad/s", "phi": 0.0}, (0.5, 2.0, 0.0)),
    ],
)
def test_other_units_are_converted(numbers: dict[str, float | str], bare: tuple[float, ...]) -> None:
    model = ss.Model(BLOCK, friction=LAW, effects=[ss.effect("harmonic_forcing", **numbers)])
    assert tuple(model.effects[0].parameters.values()) == pytest.approx(bare)
    share = ss.effect("belt_seam", a="20 %", L="30 mm")
    assert dict(share.parameters) == pytest.approx({"a": 0.2, "L": 0.03, "phi": 0.0})


@pytest.mark.parametrize(
    ("name", "numbers", "why"),
    [
        (
            "harmonic_forcing",
            {"a": 1.0, "w": "2 Hz"},
            r"is a rate \(1/s\); it must be an angular speed \(rad/s\)",
        ),
        ("harmonic_forcing", {"a": 1.0, "w": 2.0, "phi": "3 mm"}, "it must be an angle"),
        ("constant_load", {"f": "2 quux"}, "unknown unit"),
        ("sensor_lag", {"tau": "-2 ms"}, "must be above 0"),
        ("belt_seam", {"a": "200 %", "L": "1 m"}, "must be at most 1"),
    ],
)
def test_what_cannot_be_is_refused_by_its_reason(
    name: str, numbers: dict[str, float | str], why: str
) -> None:
    with pytest.raises(ss.InputError, match=why):
        ss.effect(name, **numbers)


def test_a_rig_without_scales_and_one_of_bodies_take_them_bare() -> None:
    lag = ss.effect("sensor_lag", tau="20 ms")
    with pytest.raises(ss.InputError, match=r"sensor_lag\.tau: has a unit, but the rig is nondimensional"):
        ss.Model(BARE, friction=ss.PaperFriction(), effects=[lag])
    drill = CASES["drill"]().model
    with pytest.raises(ss.InputError, match="in SI: give it bare"):
        drill.with_effects([ss.effect("constant_load", f="2 N m", where="bit")])
    with pytest.raises(
        ss.InputError, match=r"is a torque \(N m\); at a contact that slides it must be a force"
    ):
        ss.Model(BLOCK, friction=LAW, effects=[ss.effect("constant_load", f="2 N m")])


def test_a_file_has_them_as_python_does(tmp_path: Path) -> None:
    text = '[rig]\nkind = "block_on_belt"\nm = 1.2\nk = 850\n[friction]\nkind = "coulomb"\nstatic = 3\nkinetic = 2\n'
    path = tmp_path / "model.toml"
    path.write_text(text + '[[effect]]\nname = "constant_load"\nf = "250 mN"\n', encoding="utf-8")
    model = ss.load_model(path)
    assert model.parameters["constant_load.f"] == 0.25
    model.save(tmp_path / "again.toml")
    assert ss.load_model(tmp_path / "again.toml") == model


MEASURED = {
    info.dimension for kind in KINDS.values() for info in kind.parameters
}  # no inertia: its unit has no angle


@pytest.mark.parametrize("what", sorted({*MEASURED, DAMPING, STIFFNESS}, key=str), ids=lambda what: what.unit)
def test_the_unit_of_what_turns_measures_what_its_exponents_say(what: Dimension) -> None:
    assert dimensions(turning(what.unit)) == of_contact(what, rotation=True)
    assert dimensions(what.unit) == of_contact(what, rotation=False)
