"""A belt that drifts in time is not one that droops under its load."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from discover_cases import make_case
from stickslip.declared.effect import effect
from stickslip.declared.model import Model
from stickslip.discovery import drifting, loop, trace
from stickslip.discovery.choice import Choice, _with_drift, choose
from stickslip.discovery.rivals import shapes
from stickslip.discovery.search import Search

SLOW = effect("belt_speed_ripple", a=0.3, w=0.006, phi=0.0)  # 0.0018 t, nearly
DROOP = effect("belt_load_droop", k=0.004, tau=0.8)


def searched(term):
    """A search in which the declared law and a droop have been fitted."""
    case = make_case((term,), length=60.0, turned=False)
    data, _ = loop._checked(case, ())
    search = Search(
        data[: len(case.train)], Model(case.rig, friction=case.friction), 2, lambda _: None, 200.0
    )
    null = search.polish(trace.declared(search))
    search.keep(null, ())
    tried = [
        trace._screened(search, ("belt_load_droop", start), base=null, afresh=True)
        for start in shapes("belt_load_droop", search.data)
    ]
    best = min((search.close(one) for one in tried if one is not None), key=lambda one: one.fit.cost)
    search.keep(best, best.names)
    return search, best


@pytest.fixture(scope="module")
def drifted():
    return searched(SLOW)


def test_a_speed_that_each_window_may_choose_does_as_well(drifted):
    search, droop = drifted
    assert droop.chi2 < 0.2 * search.tried[()].chi2  # it passes for a droop
    wave, curve = drifting.drift_of(search)
    assert wave.names == ("belt_speed_ripple",)
    assert wave.chi2 < droop.chi2
    assert wave.chi2 == pytest.approx(1.0, abs=0.1)
    truth = 0.3 * np.sin(0.006 * curve.x)
    assert np.abs(curve.value - truth).max() < 0.01
    assert np.mean((curve.low <= truth) & (truth <= curve.high)) > 0.5
    assert (curve.where, curve.variable) == ("belt", "t")


def test_it_is_chosen_in_the_place_of_the_droop_without_pairs(drifted):
    search, droop = drifted
    said = []
    search.progress = said.append
    choice = choose(search, [droop, search.tried[()]])
    assert choice.place == ("belt", ("t",))
    assert choice.trial.names == ("belt_speed_ripple",)
    assert choice.drift is not None
    assert not any("belt_load_droop +" in one for one in said)


def test_a_droop_stays_one():
    search, droop = searched(DROOP)
    assert droop.chi2 == pytest.approx(1.0, abs=0.1)
    assert drifting.drift_of(search) is None


@pytest.mark.parametrize(("left", "drifts"), [(0.05, True), (8.0, False)])
def test_what_a_slow_wave_leaves_much_of_is_no_drift(monkeypatch, left, drifts):
    """A droop may stand in for anything: a curved sensor, for one."""
    trials = {
        name: SimpleNamespace(chi2=1 + chi2, names=(name,)) for name, chi2 in (("wave", left), ("droop", 8.2))
    }
    null = SimpleNamespace(chi2=17.5, names=())
    found = Choice(null, SimpleNamespace(chi2=9.2, names=(drifting.DROOP,)), None, [])
    monkeypatch.setattr("stickslip.discovery.choice.drift_of", lambda _: (trials["wave"], "curve"))
    monkeypatch.setattr(drifting, "steady", lambda *_: False)
    choice = _with_drift(None, found)
    assert (choice.drift is not None) == drifts
    assert (choice is found) != drifts


@pytest.mark.parametrize(("left", "drifts"), [(0.3, True), (0.4, False)])
def test_before_curves_are_asked_a_drift_leaves_next_to_nothing(monkeypatch, left, drifts):
    """A gain of x1 looks like a belt that is slow throughout, and leaves little but not that little."""
    wave = SimpleNamespace(chi2=1 + left, names=("wave",), excess=50.0)
    null = SimpleNamespace(chi2=17.5, names=())
    found = Choice(null, SimpleNamespace(chi2=1.2, names=(drifting.DROOP,)), None, [])
    monkeypatch.setattr("stickslip.discovery.choice.drift_of", lambda _: (wave, "curve"))
    monkeypatch.setattr(drifting, "steady", lambda *_: False)
    assert (_with_drift(None, found, alone=True).drift is not None) == drifts
    assert _with_drift(None, found).drift is not None


def test_a_belt_off_by_one_factor_does_not_drift():
    t = np.linspace(0, 60, 101)
    clean, not_clean = (SimpleNamespace(excess=one, chi2=1.01) for one in (0.5, 50.0))

    def curve(values):
        return SimpleNamespace(value=values, guess=None)

    off = curve(-0.03 + 0.002 * np.sin(2 * np.pi * t / 60))
    assert drifting.steady(off, clean)
    assert not drifting.steady(off, not_clean)
    assert not drifting.steady(curve(-0.03 + 0.01 * np.sin(t)), clean)
    words, formula = drifting.told(off, clean)
    assert "0.97 times the set-points" in words
    assert formula == "0.97 v_b throughout"
    assert "drifts in time" in drifting.told(off, not_clean)[0]
