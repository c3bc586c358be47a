"""Numbers of the report in SI, of effects and of a wrong number of the rig."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import jsonschema
import pytest

import found_by_hand
import stickslip as ss
from found_by_hand import SCHEMA, made
from stickslip.declared.catalogue import CATALOGUE, CONSTANTS
from stickslip.declared.scale import law_scale
from stickslip.shown.report.contents import contents
from stickslip.shown.report.page import page
from stickslip.shown.report.si import EFFECTS, to_si

OMEGA = ((6243.0 + 362.1) / 42.3) ** 0.5


def test_si_values_are_the_scaled_ones(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    tau = contents(found, case)["effects"][0]["parameters"]["tau"]  # type: ignore[index, call-overload]
    assert tau["unit"] == "s"
    assert tau["value_si"] == pytest.approx(0.12 / OMEGA)
    assert tau["low_si"] == pytest.approx(0.117 / OMEGA)


def test_every_parameter_of_the_catalogue_has_its_dimension() -> None:
    scaled = {**CATALOGUE, **CONSTANTS}  # a driven slider is in the numbers of its readings
    names = {f"{k.name}.{p.name}" for k in scaled.values() for p in k.parameters if p.name != "phi"}
    assert names <= set(EFFECTS)


@pytest.mark.parametrize(
    ("name", "value", "expected", "unit"),
    [
        ("block_viscous_damping.c", 0.5, 0.5 * 362.1 / OMEGA, "N s/m"),
        ("spring_cubic_k1.k", 2.0, 2.0 * 362.1 / 0.0089**2, "N/m^3"),
        ("contact_compliance.k", 400.0, 400.0 * 362.1, "N/m"),
        ("T_s_minus", 5.94, 5.94 * 362.1 * 0.0089, "N"),
        ("belt_speed_ripple.w", 2.0, 2.0 * OMEGA, "rad/s"),
        ("sensor_nonlinearity.q", 0.1, 0.1 / 0.0089, "1/m"),
        ("belt_load_droop.k", 0.002, 0.002 * OMEGA / 362.1, "m/(N s)"),
    ],
)
def test_si_by_the_rigs_own_numbers(name: str, value: float, expected: float, unit: str) -> None:
    got = to_si(name, value, found_by_hand.rig(si=True))
    assert got == (pytest.approx(expected, rel=2e-4), unit)
    assert to_si(name, value, found_by_hand.rig(si=False)) is None


RIG_FOUND = [  # numbers found, and the constants that they make of the declared ones
    ({"alpha2": 0.9}, {"J": 0.9}),
    ({"beta3": 1.1}, {"k3": 362.1 * (1.1 - 1) / 1234.0 + 1.1}),
    ({"eta12": 1.2}, {"c2": (1.2 * (2.48 + 2.94) - 2.48) / 2.94}),
    ({"eta1": 1.3, "eta12": 1.2}, {"c1": 1.3, "c2": (1.2 * (2.48 + 2.94) - 1.3 * 2.48) / 2.94}),
    ({"inertia": 1.05, "stiffness": 1.02}, {"m": 1.05, "k1": (1.02 * (6243.0 + 362.1) - 362.1) / 6243.0}),
    ({"alpha1": 1.1}, {}),  # mass and spring k1 at once
]


@pytest.mark.parametrize(("shares", "expected"), RIG_FOUND, ids=lambda one: "-".join(one) or "none")
def test_a_wrong_number_of_the_rig_has_its_constant_in_si(
    tmp_path: Path, shares: dict[str, float], expected: dict[str, float]
) -> None:
    found, case = made(tmp_path)
    rig, constants = case.rig, case.rig.to_si()
    values = {name: share * getattr(rig, name, rig.alpha1) for name, share in shares.items()}
    found = found_by_hand.with_effect(found, found_by_hand.of_rig(values))
    report = json.loads(json.dumps(contents(found, case)))
    jsonschema.validate(report, SCHEMA)
    given = report["effects"][0]["parameters"].values()
    told = {one["si_name"]: one for one in given if "si_name" in one}
    assert {name: one["value_si"] / constants[name] for name, one in told.items()} == pytest.approx(expected)
    for name, one in told.items():
        if name == "c2" and "eta1" in shares:  # a difference of two
            assert one["low_si"] is None
        else:
            assert one["low_si"] < one["value_si"] < one["high_si"]
    rows = [row for row in report["parameters"] if row["kind"] == "effect"]
    assert [row["name"] for row in rows] == list(shares)
    assert [row["before"]["value"] for row in rows] == [getattr(rig, name, rig.alpha1) for name in shares]
    text = page(found, case, report, {})
    assert all(f"{name} = " in text for name in expected)


@pytest.mark.parametrize("kind", [ss.PaperFriction, ss.CoulombFriction, ss.HyperbolicFriction])
def test_every_number_of_every_law_has_si_values_that_agree_with_the_command_lines(kind: type) -> None:
    rig = found_by_hand.rig(si=True)
    for name in (one.name for one in fields(kind) if one.name != "kind"):
        value, unit = to_si(name, 2.0, rig)
        scale = law_scale(name, rig)
        assert (value, unit) == (pytest.approx(2.0 * scale.size, rel=1e-12), scale.unit)
