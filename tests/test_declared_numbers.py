"""What is called declared is what the user declared: of the law, of constants and of gains; never a fitted number."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import jsonschema
import pytest

import found_by_hand
import stickslip as ss
from found_by_hand import RIG_SI, SCHEMA, made
from slider_cases import KINETIC, MASS, STATIC, STIFFNESS, case_of, rig_of
from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.friction_law import given_numbers
from stickslip.likelihoods.interval import Interval
from stickslip.shown.report.contents import contents
from stickslip.shown.report.page import page

OFF = 'kind = "coulomb"\nstatic = 6.6\nkinetic = 3.9'  # what acts is 6.0 and 4.2
SAID = {
    "all": (OFF, {"static": 6.6, "kinetic": 3.9}),
    "one": ('kind = "coulomb"\nstatic = 6.6', {"static": 6.6}),
    "other direction": (f"{OFF}\nstatic_plus = 5.0", {"static": 6.6, "static_plus": 5.0, "kinetic": 3.9}),
    "kind": ('kind = "coulomb"', {}),
    "nothing": ("none", {}),
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("said", "scatter"), [*((said, False) for said in SAID), ("other direction", True), ("nothing", True)]
)
def test_identify_says_what_was_declared(tmp_path: Path, said: str, scatter: bool) -> None:
    text, numbers = SAID[said]
    case = case_of(rig_of(0.01), tmp_path, friction=text, length=4.0, step=2e-3 if scatter else 1e-3)
    found = ss.identify(case, scatter=scatter)
    told = {name: one.declared for name, one in found.estimates.items()}
    base = {name: numbers.get(name.removesuffix("_plus")) for name in told}
    kept = isinstance(found.law, ss.CoulombFriction)
    assert told == {name: numbers.get(name, base[name]) if kept else None for name in told}
    assert found.estimates["static"].value == pytest.approx(STATIC, rel=0.1) if kept else True
    written = json.loads(json.dumps(found.to_dict()))["estimates"]
    assert {name: one["declared"] for name, one in written.items()} == told


@pytest.mark.study
def test_a_law_given_in_the_call_is_the_declared_one(tmp_path: Path) -> None:
    case = case_of(rig_of(0.01), tmp_path, friction=OFF, length=4.0, step=2e-3)
    law = ss.CoulombFriction(static=5.5, kinetic=4.4)
    assert ss.identify(case, friction=law).estimates["static"].declared == 5.5
    bare = ss.identify(case.train[0], rig=case.rig, scatter=True)
    assert {one.declared for one in bare.estimates.values()} == {None}


def test_numbers_of_both_directions_are_given_for_both() -> None:
    assert given_numbers(ss.CoulombFriction(static=2, kinetic_plus=0.4), ("kinetic",)) == {
        "static": 2.0, "static_plus": 2.0, "kinetic_plus": 0.4
    }  # fmt: skip


def test_numbers_of_several_laws_are_given_by_the_name_of_the_law() -> None:
    laws = ContactLaws(
        (("wet", ss.CoulombFriction(static=2)), ("dry", ss.StribeckFriction(F_c=1, F_s=2, v_s=0.1)))
    )
    given = given_numbers(laws)
    assert given["wet.static"] == 2.0
    assert given["dry.v_s"] == 0.1
    curve = ss.TabulatedFriction(speeds=[0.0, 1.0], forces=[2.0, 1.0], static=2.5)
    assert given_numbers(curve)["static"] == 2.5


def test_the_report_has_constants_gains_and_law_as_the_file_has_them(tmp_path: Path) -> None:
    extra = "[friction]\nT_s_minus = 6.2\n[uncertainty]\nJ = 0.002\ny1 = 0\n"
    case = ss.load_case(found_by_hand.write_case(tmp_path, si=True, extra=extra))
    found = found_by_hand.found(case)
    report = json.loads(json.dumps(contents(found, case)))
    jsonschema.validate(report, SCHEMA)
    law = {row["name"]: row["declared"] for row in report["parameters"]}
    assert law.pop("T_s_minus") == 6.2
    assert set(law.values()) == {None}  # the rest are defaults, and an effect is not declared
    told = report["declared"]
    assert {name: told[name]["value"] for name in told} == {
        **{name: value for name, value in RIG_SI.items() if name != "length"}, "x1": 1.0, "y1": 1.0
    }  # fmt: skip
    assert told["J"] == {"value": 0.277, "unit": "kg m^2", "uncertainty": 0.002 * 0.277, "runs": None}
    assert told["m"]["uncertainty"] == pytest.approx(0.015 * 42.3)
    assert told["c1"]["uncertainty"] == pytest.approx(0.15 * 2.48)
    assert (told["y1"]["uncertainty"], told["x1"]["uncertainty"]) == (0.0, 0.005)
    assert "6.2" in page(found, case, report, {})


def test_the_report_says_what_the_runs_say_of_a_constant(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    share = 1.1
    wrong = {"alpha2": share * case.rig.alpha2}
    told = contents(found_by_hand.with_effect(found, found_by_hand.of_rig(wrong)), case)["declared"]
    runs = told["J"]["runs"]  # type: ignore[index, call-overload]
    assert runs["value"] == pytest.approx(share * 0.277)  # type: ignore[index, call-overload]
    assert runs["low"] == pytest.approx(0.99 * share * 0.277)  # type: ignore[index, call-overload]
    assert told["k3"]["runs"] is None  # type: ignore[index, call-overload]


def test_a_damping_that_is_a_difference_has_an_interval(tmp_path: Path) -> None:
    """c2 is eta12 less eta1: from either alone no interval of it follows, and none was said."""
    found, case = made(tmp_path)
    per = case.rig.scales.k2 / case.rig.scales.omega
    damping = {"eta1": Interval(0.1, 0.09, 0.11), "eta12": Interval(0.25, 0.23, 0.27)}
    alone = contents(dataclasses.replace(found, constants=damping), case)["declared"]["c2"]["runs"]  # type: ignore[index, call-overload]
    assert alone == {"value": pytest.approx(0.15 * per), "low": None, "high": None}
    apart = {**damping, "eta2": Interval(0.15, 0.14, 0.16)}
    runs = contents(dataclasses.replace(found, constants=apart), case)["declared"]["c2"]["runs"]  # type: ignore[index, call-overload]
    assert [runs[k] / per for k in ("value", "low", "high")] == pytest.approx([0.15, 0.14, 0.16])  # type: ignore[index]


@pytest.mark.study
def test_discover_says_what_the_events_say_of_a_block_s_constants(tmp_path: Path) -> None:
    case = case_of(rig_of(0.01), tmp_path, friction=OFF, length=5.0, step=2e-3)
    found = ss.discover(case)
    report = json.loads(json.dumps(contents(found, case)))
    jsonschema.validate(report, SCHEMA)
    told = report["declared"]
    truth = {"m": MASS, "k": STIFFNESS, "x1": 1.0}
    for name, value in truth.items():
        assert told[name]["value"] == value
        runs = Interval(**told[name]["runs"])
        assert runs.low is not None
        assert runs.low < runs.value < runs.high
        assert runs.value == pytest.approx(value, rel=0.1)
    rows = {row["name"]: row for row in report["parameters"] if row["kind"] == "law"}
    assert rows["static"]["declared"] == 6.6
    assert rows["static"]["value"] == pytest.approx(STATIC, rel=0.05)
    assert rows["kinetic"]["declared"] == 3.9
    assert rows["kinetic"]["value"] == pytest.approx(KINETIC, rel=0.05)
