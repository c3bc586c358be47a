"""Numbers of the report in SI, of effects and of a wrong number of the rig."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

import found_by_hand
import stickslip as ss
from found_by_hand import SCHEMA, made
from stickslip.declared.catalogue import CATALOGUE, CONSTANTS, DRIVEN
from stickslip.declared.dimensions import NUMBER
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.laws import LAWS
from stickslip.declared.si import OF_EFFECTS, si_of
from stickslip.likelihoods.interval import Interval
from stickslip.shown.report.contents import contents
from stickslip.shown.report.page import page

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
    assert names <= set(OF_EFFECTS)


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
    got = si_of(name, found_by_hand.rig(si=True))
    assert got is not None
    assert (got.of(value), got.unit) == (pytest.approx(expected, rel=2e-4), unit)
    assert si_of(name, found_by_hand.rig(si=False)) is None


RIG_FOUND = [  # numbers found, and the constants that they make of the declared ones
    ({"alpha2": 0.9}, {"J": 0.9}),
    ({"beta3": 1.1}, {"k3": 362.1 * (1.1 - 1) / 1234.0 + 1.1}),
    ({"eta12": 1.2}, {"c2": (1.2 * (2.48 + 2.94) - 2.48) / 2.94}),
    ({"eta1": 1.3, "eta12": 1.2}, {"c1": 1.3, "c2": (1.2 * (2.48 + 2.94) - 1.3 * 2.48) / 2.94}),
    ({"inertia": 1.05, "stiffness": 1.02}, {"m": 1.05, "k1": (1.02 * (6243.0 + 362.1) - 362.1) / 6243.0}),
    ({"alpha1": 1.1}, {}),  # mass and spring k1 at once
]


@pytest.mark.sampled(2)
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


BLOCK = """
[rig]
kind = "block_on_belt"
m = 0.037
k = 168.0
[[run]]
file = "run.csv"
role = "train"
belt_speed = 0.001
[channels]
t = { column = "t", unit = "UNIT" }
x1 = { column = "x1", unit = "LENGTH" }
"""
SLIDER = (
    BLOCK.replace("block_on_belt", "driven_slider")
    .replace("k = 168.0\n", "")
    .replace("belt_speed = 0.001\n", "")
)
SLIDER += 'drive = { column = "F", unit = "FORCE" }\n'


def other(folder: Path, text: str, *, si: bool = True) -> ss.Case:
    rows = "".join(f"{0.1 * i:.1f},{0.001 * (i % 7)},{0.3 * (i % 5)}\n" for i in range(80))
    (folder / "run.csv").write_text(f"t,x1,F\n{rows}")
    for word, unit in (("UNIT", "s"), ("LENGTH", "mm"), ("FORCE", "N")):
        text = text.replace(word, unit if si else "1")
    (folder / "rig.toml").write_text(text)
    return ss.load_case(folder / "rig.toml")


@pytest.mark.parametrize(
    ("text", "kinds"), [(BLOCK, {**CATALOGUE, **CONSTANTS}), (SLIDER, DRIVEN)], ids=["block", "slider"]
)
def test_other_rigs_have_every_law_and_every_effect_in_si(
    tmp_path: Path, text: str, kinds: dict[str, EffectKind]
) -> None:
    """A block on a belt and a driven slider in SI: their numbers are SI values, and have their units in the report."""
    whole, _ = made(tmp_path)
    case = other(tmp_path, text)
    for law in LAWS.values():
        numbers = {name: Interval(2.0, 1.0, 3.0) for name in law.dimensions}
        report = contents(replace(whole, law=numbers, law_before=numbers), case)
        for rows in (report["law"], report["law_before"]):
            for name, one in rows.items():  # type: ignore[union-attr]
                assert (one["value_si"], one["low_si"], one["unit"]) == (2.0, 1.0, law.dimensions[name].unit)  # type: ignore[index, call-overload]
    for kind in (one for one in kinds.values() if not one.two_degree):
        numbers = {p.name: Interval(0.5, 0.4, 0.6) for p in kind.parameters}
        effect = replace(whole.effects[0], name=kind.name, parameters=numbers, curve=None)
        given = contents(replace(whole, effects=(effect,)), case)["effects"][0]["parameters"]  # type: ignore[index, call-overload]
        for p in kind.parameters:
            one = given[p.name]
            if kind.corrects in ("mass", "stiffness"):
                declared = getattr(case.rig, kind.corrects)
                assert (one["si_name"], one["value_si"]) == (kind.corrects, pytest.approx(1.5 * declared))
            elif p.dimension == NUMBER:
                assert "value_si" not in one
            else:
                assert (one["value_si"], one["high_si"], one["unit"]) == (0.5, 0.6, p.dimension.unit)
    bare = other(tmp_path, text, si=False)
    assert "value_si" not in contents(whole, bare)["law"]["T_s_minus"]  # type: ignore[index, call-overload, operator]


def test_a_learned_curve_has_its_values_in_si(tmp_path: Path) -> None:
    found, case = made(tmp_path, verdict="unlisted_effect")
    report = json.loads(json.dumps(contents(found, case)))
    jsonschema.validate(report, SCHEMA)
    curve = report["effects"][0]["curve"]
    assert (curve["unit"], curve["x_unit"]) == ("N", "m")
    scale = 362.1 * 0.0089
    for side in ("value", "low", "high"):
        assert curve[f"{side}_si"] == pytest.approx([scale * one for one in curve[side]])


def test_the_page_of_a_block_on_a_belt_has_units(tmp_path: Path) -> None:
    whole, _ = made(tmp_path)
    case = other(tmp_path, BLOCK)
    numbers = {"static": Interval(0.11, 0.1, 0.12)}
    aging = {"dT": Interval(0.02, 0.01, 0.03), "tau": Interval(4.0, None, None)}
    effect = replace(whole.effects[0], name="static_aging", parameters=aging)
    found = replace(whole, effects=(effect,), law=numbers, law_before=numbers)
    text = page(found, case, contents(found, case), {})
    assert re.search(r'>0\.11</td><td class="n">0\.1 … 0\.12</td><td>N</td>', text)
    assert re.search(r'>0\.02</td><td class="n">0\.01 … 0\.03</td><td>N</td>', text)
    assert re.search(r'>4</td><td class="n">–</td><td>s</td>', text)
