"""Half of the windows: enough to see which effect a plain misfit comes from."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from discover_cases import RIG, make_case
from stickslip.declared.effect import effect
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.discovery.evidence import evidence
from stickslip.discovery.search import CLEAN, Search
from stickslip.discovery.trace import PLAIN, closely, declared, screen
from stickslip.fitted.data import prepare
from stickslip.fitted.solve import Point


@pytest.fixture(scope="module")
def search():
    runs = prepare(make_case((effect("spring_cubic_k2", k=6.0),)).train[:3])
    return Search(runs, Model(RIG, friction=PaperFriction()), 1, lambda _: None, 1e6)


@pytest.fixture(scope="module")
def base(search):
    return declared(search)


def test_half_is_two_in_four_of_every_run(search, base):
    half = search.half(base)
    for run in range(3):
        every = [w.start for w in base.fit.windows if w.run == run]
        assert [w.start for w in half.fit.windows if w.run == run] == [
            s for i, s in enumerate(every) if i % 4 < 2
        ]
    cost = Point.at(base.fit.engine, base.fit.vector, half.fit.windows).cost
    assert half.fit.cost == pytest.approx(cost)
    assert half.partial
    assert half.fit.readings < 0.7 * base.fit.readings
    assert half.mean == pytest.approx(base.mean, rel=0.5)


def test_a_plain_misfit_is_screened_on_half_and_fitted_closely_on_all(search, base):
    assert base.chi2 > PLAIN
    rivals = screen(search, base)
    assert all(one.partial for one in rivals)
    assert rivals[0].names == ("spring_cubic_k2",)
    found = closely(search, rivals, most=1)[0]
    assert not found.partial
    assert len(found.fit.windows) == len(base.fit.windows)
    assert found.excess < CLEAN
    assert search.tried["spring_cubic_k2",] is found


def test_a_part_is_weighed_as_if_it_were_of_all_readings(search, base):
    half, every = search.half(base), base.fit.readings
    assert half.cost_of(every) == pytest.approx(half.mean * every)
    assert half.bic_of(every) - half.cost_of(every) == pytest.approx(half.bic - half.fit.cost, abs=1e-6)
    assert (base.cost_of(every + 100), base.bic_of(every + 100)) == (base.fit.cost, base.bic)


def test_the_best_wrong_effect_is_not_flattered_by_its_part(search, base):
    search.keep(base, ())
    rivals = screen(search, base)
    found = closely(search, rivals, most=1)[0]
    proof = evidence(search, base, found, "spring_cubic_k2", [found], 20.0, 0.5)
    wrong = min(one.mean for one in rivals[1:]) * base.fit.readings
    assert proof.control == pytest.approx(max(base.fit.cost - wrong, 0.0))
    assert proof.control < proof.delta_chi2


def test_an_effect_of_a_pair_gains_no_more_than_both_on_the_declared_law():
    """Its partner alone, refitted, may end worse than the declared law that is nested in it."""

    def fitted(names, cost):
        fit = SimpleNamespace(cost=cost, readings=1000)
        return SimpleNamespace(names=names, fit=fit, bic=cost, cost_of=lambda _: cost)

    null, alone, both = fitted((), 5000.0), fitted(("b",), 8000.0), fitted(("a", "b"), 1000.0)
    search = SimpleNamespace(tried={("b",): alone}, screened=[])
    assert evidence(search, null, both, "a", [], 20.0, 0.5).delta_chi2 == 4000.0
    alone.fit.cost = 3000.0
    assert evidence(search, null, both, "a", [], 20.0, 0.5).delta_chi2 == 2000.0
