"""A wrong number of the declared rig is found as such: one number, where a curve in its place would be many."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from discover_cases import RIG, make_case
from stickslip.declared.effect import tabulated
from stickslip.discovery import rig_numbers
from stickslip.discovery.result import Curve, Verdict
from stickslip.measured.case import Case
from stickslip.shown.report.words import headline, kind, sureness

SPEEDS = (0.06, 0.13, -0.09, 0.1)


def declared_wrong(seed: int = 1, softer: float = 0.0, **wrong: float) -> Case:
    """A case whose rig is declared with these numbers; its runs are those of RIG, its spring `softer` by so much."""
    line = tabulated("block", "x1", [-4.0, 4.0], [-4.0 * softer, 4.0 * softer])
    case = make_case((line,) if softer else (), length=40.0, speeds=SPEEDS, seed=seed)
    rig = replace(RIG, **wrong)
    return replace(case, rig=rig, runs=tuple(replace(run, rig=rig) for run in case.runs))


@pytest.mark.study
def test_an_inertia_that_is_wrong_is_found_and_mended(tmp_path: Path) -> None:
    found = ss.discover(declared_wrong(alpha2=8.8))
    assert found.verdict is Verdict.effect_found
    (effect,) = found.effects
    assert (effect.name, effect.where, effect.depends_on) == ("rig_alpha2", "angle_body", ("y1",))
    number = effect.parameters["alpha2"]
    assert number.low is not None
    assert number.high is not None
    assert number.low < RIG.alpha2 < number.high < 1.05 * number.low
    assert 0 < effect.evidence.control < effect.evidence.delta_chi2
    assert effect.evidence.control_name
    assert ("sensor_lag",) in {one.names for one in found.ranking}
    assert found.residual_after.clean
    assert found.residual_before.chi2 > 10
    assert found.error.after < 0.9 * found.error.before
    assert effect.of_rig
    assert kind(effect) == "a declared number of the rig that is wrong"
    assert headline(found).startswith("A declared number of the rig is wrong: alpha2 is 8.0")
    assert any(line.startswith("That it is alpha2 stands") for line in sureness(found))
    assert "alpha2" not in found.law
    found.model.save(tmp_path / "after.toml")
    assert ss.load_model(tmp_path / "after.toml").rig.alpha2 == pytest.approx(number.value, rel=1e-4)


def test_what_is_said_of_a_number_is_in_the_constants_of_an_si_rig() -> None:
    rig = ss.Rig.from_si(m=2.5, J=6e-4, r=0.05, k1=600, k2=100, k3=200, c1=1.0, c2=1.5, length=0.01)
    known = {"alpha2": "J", "beta3": "k3", "eta1": "c1", "eta12": "c2", "inertia": "m", "stiffness": "k1"}
    values = {"J": 6e-4, "k3": 200.0, "c1": 1.0, "c2": 1.5, "m": 2.5, "k1": 600.0}
    for number, name in known.items():
        what = rig_numbers.constant(rig, number, {})
        assert what is not None
        assert what.name == name
        assert what.of(rig_numbers.declared(rig, number)) == pytest.approx(values[name])


@pytest.mark.parametrize(
    ("where", "variable", "bent", "doubt"),
    [
        ("block", "x1", 0.0, "m, k1 or k2 of the declared rig"),
        ("block", "x1", 0.4, "m, k1 or k2 of the declared rig"),
        ("block", "x1", 4.0, None),  # no number of the rig leaves a bent curve
        ("block", "x2", 0.0, None),
        ("contact", "x1", 0.0, None),
        ("angle_body", "y1", 0.0, "J, k2 or k3 of the declared rig"),
        ("angle_body", "y2", 0.0, "J, c1 or c2 of the declared rig"),
    ],
)
def test_a_straight_curve_is_what_a_wrong_number_leaves(
    where: str, variable: str, bent: float, doubt: str | None
) -> None:
    x = np.linspace(-1.0, 1.0, 101)
    value = 0.3 * x + bent * 0.3 * x**2
    learned = Curve(where, variable, "force", x, value, value - 0.1, value + 0.1, x[::10], None)
    said = rig_numbers.remark(RIG, learned)
    assert (said is None) == (doubt is None)
    assert said is None or f"a wrong {doubt}" in said


@pytest.mark.parametrize(
    ("declared", "slope", "meant"),
    [
        ("as_printed", -2.0, "reciprocal"),
        ("reciprocal", 2.05, "as_printed"),
        ("reciprocal", -2.0, None),
        ("as_printed", -1.7, None),
    ],
)
def test_twice_the_force_of_y1_is_the_coupling_of_the_other_sign(
    declared: str, slope: float, meant: str | None
) -> None:
    x = np.linspace(-1.0, 1.0, 101)
    value = slope * x + 0.1
    learned = Curve("block", "y1", "force", x, value, value - 0.1, value + 0.1, x[::10], None)
    rig = replace(RIG, coupling=declared)  # type: ignore[arg-type]
    said = rig_numbers.remark(rig, learned)
    assert (said is None) == (meant is None)
    assert said is None or f"write coupling = '{meant}' in [rig] instead of '{declared}'" in said
