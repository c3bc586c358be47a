"""A wrong number of the declared rig is found as such: one number, where a curve in its place would be many."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from discover_cases import RIG, make_case
from stickslip.declared.effect import tabulated
from stickslip.declared.model import Model
from stickslip.discovery import choice, rig_numbers
from stickslip.discovery.result import Curve, Interval, Verdict
from stickslip.discovery.search import Search, Trial
from stickslip.discovery.trace import declared, explained
from stickslip.fitted.data import prepare
from stickslip.measured.case import Case
from stickslip.progress import StageStep
from stickslip.shown.pages.filters import numbers
from stickslip.shown.report.words import headline, kind, sureness

SPEEDS = (0.06, 0.13, -0.09, 0.1)


def declared_wrong(seed: int = 1, softer: float = 0.0, **wrong: float) -> Case:
    """A case whose rig is declared with these numbers; its runs are those of RIG, its spring `softer` by so much."""
    line = tabulated("block", "x1", [-4.0, 4.0], [-4.0 * softer, 4.0 * softer])
    case = make_case((line,) if softer else (), length=40.0, speeds=SPEEDS, seed=seed)
    rig = replace(RIG, **wrong)
    return replace(case, rig=rig, runs=tuple(replace(run, rig=rig) for run in case.runs))


def test_an_inertia_that_is_wrong_is_found_and_mended(tmp_path: Path) -> None:
    found = ss.discover(declared_wrong(alpha2=8.8))
    assert found.verdict is Verdict.effect_found
    (effect,) = found.effects
    assert (effect.name, effect.where, effect.depends_on) == ("rig_alpha2", "angle_body", ("y1",))
    number = effect.parameters["alpha2"]
    assert number.low is not None
    assert number.high is not None
    assert number.low < RIG.alpha2 < number.high < 1.01 * number.low
    assert 0 < effect.evidence.control < effect.evidence.delta_chi2
    assert effect.evidence.control_name
    assert {("beta3",), ("sensor_lag",)} <= {one.names for one in found.ranking}
    assert found.residual_after.clean
    assert found.residual_before.chi2 > 10
    assert found.error.after < 0.1 * found.error.before
    assert effect.of_rig
    assert kind(effect) == "a declared number of the rig that is wrong"
    assert [numbers(one) for one in found.ranking if one.chosen] == ["alpha2 = 8"]
    assert headline(found).startswith("A declared number of the rig is wrong: alpha2 is 8 rather than 8.8")
    assert any(line.startswith("That it is alpha2 stands") for line in sureness(found))
    assert "alpha2" not in found.law
    found.model.save(tmp_path / "after.toml")
    assert ss.load_model(tmp_path / "after.toml").rig.alpha2 == pytest.approx(number.value)
    assert ("alpha2",) in {one.names for one in found.ranking if one.chosen}


@pytest.mark.parametrize(
    "wrong",
    [
        {"alpha1": 17.6},
        {"beta3": 4.1},
        {"eta12": 0.22},
        {"alpha2": 40.0},  # as far off as docs/discovery.md says
        {"beta3": 7.0},  # k3 twice
        {"eta12": 1.0},  # c2 nine times
        {"eta1": 0.5, "eta12": 0.6},
        {"eta1": 0.08, "eta12": 0.18},
        {"eta1": 0.03, "eta12": 0.13},  # c1 three times as large: beyond the middle of the two as declared
    ],
)
def test_each_number_is_found_beside_the_law(wrong: dict[str, float]) -> None:
    case = declared_wrong(seed=4, **wrong)
    data = prepare(case.train)
    search = Search(data, Model(case.rig, friction=case.friction), 2, lambda _: None, 60.0)
    null = declared(search)
    assert null is not None
    assert not explained(null, null)
    every = rig_numbers.freed(search, null)
    best = every[0]
    assert search.freed == every  # rivals of it, and rows of the ranking
    assert explained(best, null)
    assert set(wrong) <= set(best.names)
    for name, one in rig_numbers.numbers(best).items():
        assert one.low is not None
        assert one.high is not None
        slack = one.high - one.low  # 95 % of four numbers here: none may be far outside
        assert one.low - slack < getattr(RIG, name) < one.high + slack
    assert best.extra == len(best.names)  # they are counted, unlike the law's


@pytest.mark.parametrize(
    ("alpha1", "stiffness", "names"),
    [(16.0, 15.2, ("block stiffness",)), (15.2, 15.2, ("block inertia",)), (15.0, 15.5, ("block inertia",))],
)
def test_mass_and_spring_of_the_block_are_found_apart(
    alpha1: float, stiffness: float, names: tuple[str, ...]
) -> None:
    """alpha1 stands before x1'' and before x1: the one is of the mass, the other of the spring."""
    case = declared_wrong(seed=3, softer=16.0 - stiffness, alpha1=alpha1)
    search = Search(prepare(case.train), Model(case.rig, friction=case.friction), 2, lambda _: None, 60.0)
    null = declared(search)
    assert null is not None
    best = rig_numbers.freed(search, null)[0]
    assert explained(best, null)
    assert best.names == names
    found = rig_numbers.numbers(best)
    true = {"inertia": 16.0, "stiffness": stiffness}
    assert set(found) == (set(true) if names == ("block inertia",) else {"stiffness"})
    for name, one in found.items():
        assert one.low is not None
        assert one.high is not None
        slack = one.high - one.low
        assert slack < 0.05 * one.value
        assert one.low - slack < true[name] < one.high + slack


def test_what_is_said_of_a_number_is_in_the_constants_of_an_si_rig() -> None:
    rig = ss.Rig.from_si(m=2.5, J=6e-4, r=0.05, k1=600, k2=100, k3=200, c1=1.0, c2=1.5, length=0.01)
    twice = {
        "alpha2": Interval(2 * rig.alpha2, None, None),
        "beta3": Interval(1 + 2 * (rig.beta3 - 1), None, None),
        "eta1": Interval(1.5 * rig.eta1, None, None),
        "eta12": Interval(rig.eta12 + 0.5 * rig.eta1, None, None),
        "inertia": Interval(0.5 * rig.alpha1, None, None),
        "stiffness": Interval(1 + 0.5 * (rig.alpha1 - 1), None, None),
    }
    said = rig_numbers.formula(rig, twice)
    assert "(J 2 times the declared)" in said
    assert "(k3 2 times the declared)" in said
    assert "(c1 1.5 times the declared)" in said
    assert "(c2 1 times the declared)" in said
    assert "(m 0.5 times the declared)" in said
    assert "(k1 0.5 times the declared)" in said


def test_one_that_does_as_well_is_said() -> None:
    case = declared_wrong(beta3=4.1)
    search = Search(prepare(case.train), Model(case.rig, friction=case.friction), 2, lambda _: None, 60.0)
    null = declared(search)
    assert null is not None
    best = rig_numbers.freed(search, null)[0]
    assert rig_numbers.remark(case.rig, best.names, best, (), None) is None
    said = rig_numbers.remark(case.rig, (), best, (best,), None)
    assert said is not None
    assert said.startswith(
        "a wrong number of the declared rig would explain the readings as well: beta3 is 4"
    )


def test_a_number_at_its_bound_is_not_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rig_numbers, "FACTOR", 1.01)
    case = declared_wrong(beta3=4.1)
    search = Search(prepare(case.train), Model(case.rig, friction=case.friction), 2, lambda _: None, 60.0)
    null = declared(search)
    assert null is not None
    assert ("beta3",) not in {one.names for one in rig_numbers.freed(search, null)}


def test_of_a_wrong_mass_or_spring_it_is_said_what_to_write() -> None:
    rig = ss.Rig.from_si(m=2.5, J=6e-4, r=0.05, k1=600, k2=100, k3=200, c1=1.0, c2=1.5, length=0.01)
    found = {
        "inertia": Interval(0.5 * rig.alpha1, None, None),
        "stiffness": Interval(0.9 * rig.alpha1, None, None),
    }
    assert rig_numbers._instead(rig, found) == "write m = 1.25 kg and k1 = 530 N/m in [rig]"
    assert rig_numbers._instead(RIG, found) == "correct the rig's constants"


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
    said = rig_numbers.remark(RIG, ("tabulated",), None, (), learned)  # type: ignore[arg-type]
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
    said = rig_numbers.remark(rig, ("tabulated",), None, (), learned)  # type: ignore[arg-type]
    assert (said is None) == (meant is None)
    assert said is None or f"write coupling = '{meant}' in [rig] instead of '{declared}'" in said


def test_a_tied_number_is_among_the_messages(monkeypatch: pytest.MonkeyPatch) -> None:
    """A name that is found while a number of the rig does as well is not believed without a word."""
    lag = ss.effect("block_viscous_damping", c=0.6)
    case = make_case((lag,), length=30.0, speeds=SPEEDS)
    monkeypatch.setattr(choice, "_with_rig", lambda search, made: replace(made, tied=(_freed_beta3(search),)))
    said: list[str] = []
    found = ss.discover(case, threads=1, progress=said.append)
    assert [one.name for one in found.effects] == ["block_viscous_damping"]
    freeing = {str(one): one.stage for one in said if isinstance(one, StageStep) and "free" in one.stage}
    assert {"freeing alpha2 of the rig", "freeing block inertia of the rig"} <= {*freeing}
    assert {*freeing.values()} == {"freeing each number of the rig"}  # one stage of the log
    assert any("beta3 is 4 rather than 4: check it" in one for one in found.messages)


def test_a_number_at_its_bound_is_still_one_of_a_rig() -> None:
    """Rounding in the logarithm put eta12 a hair below eta1: the search ended with an error instead of a verdict."""
    rng = np.random.default_rng(2)
    for _ in range(200):
        eta1 = rng.uniform(0.01, 0.3)
        rig = replace(
            RIG, alpha1=1 + rng.uniform(0, 9), beta3=1 + rng.uniform(0, 9), eta1=eta1, eta12=1.5 * eta1
        )
        for name in ("alpha1", "alpha2", "beta3", "eta1", "eta12"):
            one = rig_numbers.unknown(rig, name)
            for end in one.bounds:
                assert getattr(replace(rig, **{name: one.value(one.coordinate(end))}), name) > 0
        between = math.sqrt(rig.eta1 * rig.eta12)
        low, high = (rig_numbers.unknown(rig, name, between) for name in ("eta1", "eta12"))
        top, bottom = low.value(low.coordinate(low.bounds[1])), high.value(high.coordinate(high.bounds[0]))
        assert replace(rig, eta1=top, eta12=bottom).eta12 >= top


def _freed_beta3(search: Search) -> Trial:
    null = search.tried[()]
    return next(one for one in rig_numbers.freed(search, null) if one.names == ("beta3",))
