"""What repeats in time on a place where the catalogue has no name for it: found, learned, forecast."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from discover_cases import LAW, NOISE, RIG, make_case
from stickslip import Model, effect, simulate, tabulated
from stickslip.discovery import recurring, unlisted
from stickslip.discovery.choice import choose
from stickslip.discovery.periodic import TABLE_KNOTS, Line, periodic_starts
from stickslip.discovery.recurring import learn_recurring
from stickslip.discovery.rivals import hypothesis
from stickslip.discovery.search import CLEAN, SHORT, Search
from stickslip.discovery.trace import OUTRUN, declared
from stickslip.fitted.data import prepare
from stickslip.fitted.predict import Forecaster
from stickslip.simulated.reference import integrate as reference

TURNS = np.linspace(0, 1, 9)


def wave(where: str, size: float, period: float):
    """A sine with half as much of its second harmonic, 0 at phase 0."""
    values = size * (np.sin(2 * np.pi * TURNS) + 0.5 * np.sin(4 * np.pi * TURNS))
    values[-1] = values[0] = 0.0
    return tabulated(where, "t", period * TURNS, values, period=period)


def search_of(case) -> Search:
    return Search(prepare(case.train), Model(case.rig, friction=case.friction), 2, lambda _: None, 200.0)


@pytest.mark.parametrize("where", ["block", "angle_body", "contact"])
@pytest.mark.parametrize("key", ["w", "phi"])
def test_frequency_and_phase_of_a_table_differentiate(where, key):
    term = wave(where, 0.2, 2.3).replace(phi=0.7)
    name, h = f"{term.name}.{key}", 1e-6
    model = Model(RIG, friction=LAW, effects=[term])

    def end(off: float, **options):
        moved = model.replace({name: term.parameters[key] + off})
        return simulate(
            moved, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=40, rtol=1e-12, atol=1e-13, **options
        )

    exact = end(0.0, sensitivity=(name,))
    assert len(exact.transitions.t) > 5
    slope = (end(h).state[-1] - end(-h).state[-1]) / (2 * h)
    assert np.abs(slope).max() > 1e-3
    np.testing.assert_allclose(exact.sensitivity[-1][:, 0], slope, rtol=1e-4, atol=1e-7)


def test_a_wave_is_learned_with_each_run_at_its_own_phase():
    where = "angle_body"
    truth = wave(where, 0.15, 2.7)
    case = make_case((truth,), length=40.0, seed=5)
    search = search_of(case)
    null = declared(search)
    assert null.chi2 > 2
    term, trial = learn_recurring(search, null)[0]
    assert (term.where, term.recurs) == (where, True)
    assert trial.chi2 == pytest.approx(1.0, abs=0.05)
    curve = unlisted.curve(term, trial)
    assert curve.period == pytest.approx(2.7, rel=2e-3)
    assert curve.guess is None  # it is no sine
    # its own zero is a convention, and in friction its mean too: what is left is a shift
    off = min(
        float(np.std(curve.value - truth.curve(curve.x * 2.7 / curve.period + shift)))
        for shift in np.linspace(0, 2.7, 200)
    )
    assert off < 0.1 * np.std(truth.curve(curve.x))


def test_beside_a_name_that_explains_all_no_time_is_lost():
    """The same sine as a curve begins where the name has law and windows; at other places it is given up."""
    term = effect("harmonic_forcing", a=0.4, w=2.3, phi=0.0)
    search = search_of(make_case((term,), length=40.0, seed=5))
    null = declared(search)
    lines = periodic_starts(null.fit, ("harmonic_forcing",))["harmonic_forcing"]
    h = hypothesis(null.hypothesis.model, lines[:1], search.model)
    named = search.polish(search.run(h, cycles=SHORT, windows_of=null))
    assert named.excess < CLEAN
    found = learn_recurring(search, null, named)
    assert found[0][0].where == "block"
    assert found[0][1].fit.cost < 1.01 * named.fit.cost
    assert found[0][1].fit.iterations < 15
    for term, trial in found[1:]:
        assert term.where != "block"
        assert trial.fit.cost > OUTRUN * named.fit.cost
        assert len(term.knots) == TABLE_KNOTS + 1  # no finer one is tried
    assert len(found) > 1


def test_a_curve_held_against_a_name_begins_there_and_is_given_up_far_above_it(monkeypatch):
    search = search_of(make_case(length=20.0))
    null = declared(search)
    begun, asked = replace(null), []
    line = Line(100.0, 2.3, np.full((len(search.data), 2), 0.1))

    def run(_h, **options):
        asked.append(options)
        return begun if options["iterations"] == 0 else None

    monkeypatch.setattr(search, "run", run)
    assert recurring._learned(search, ("block", line), base=null, beat=null) is None
    there, curve = asked
    assert there["windows_of"] is null
    assert curve["windows_of"] is begun
    assert curve["worst"] == OUTRUN * null.fit.cost
    asked.clear()
    recurring._learned(search, ("block", line), base=null)
    assert [(one["windows_of"] is null, one["worst"]) for one in asked] == [(True, math.inf)]


def test_a_sine_is_called_one():
    sine = 0.12 * np.sin(2 * np.pi * TURNS)
    sine[-1] = 0.0
    case = make_case((tabulated("angle_body", "t", 2.7 * TURNS, sine, period=2.7),), length=60.0, seed=6)
    search = search_of(case)
    term, trial = learn_recurring(search, declared(search))[0]
    words = unlisted.curve(term, trial).guess
    assert words is not None
    assert "sin(2.32" in words or "sin(2.33" in words


def test_its_phase_in_a_new_run_is_told_by_the_past():
    truth = wave("angle_body", 0.2, 2.7)
    case = make_case((truth,), length=60.0, seed=7)
    run = prepare((*case.train, *case.validate))[-1]
    known = Model(RIG, friction=LAW, effects=[truth])
    half, cycle = len(run.t) // 2, int(run.cycle / 0.05)
    future = slice(half, half + cycle)

    def error(settled: bool) -> float:
        forecaster = Forecaster(known, run, 1)
        if not settled:
            forecaster.periodic = []
        done = forecaster.forecast(half, run.t[future])
        return float(np.sqrt(np.mean((done.readings - run.readings[future, :2]) ** 2)))

    assert error(True) < 1.2 * NOISE
    assert error(False) > 1.4 * NOISE  # so much hangs on the phase


@pytest.mark.parametrize("where", ["block", "angle_body", "contact"])
@pytest.mark.parametrize("phi", [-2.5, 0.7, 9.0])
def test_core_and_reference_read_the_same_phase(where, phi):
    model = Model(RIG, friction=LAW, effects=[wave(where, 0.2, 2.3).replace(phi=phi)])
    told = reference.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=15, tol=1e-12)
    ours = simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=15, rtol=1e-12, atol=1e-12)
    assert len(told.transitions.t) >= 3
    assert ours.transitions.t == pytest.approx(told.transitions.t, abs=1e-8)
    assert ours.state[-1] == pytest.approx(told.state[-1][:4], abs=1e-8)


def test_whole_turns_of_a_phase_change_nothing():
    def end(phi: float):
        model = Model(RIG, friction=LAW, effects=[wave("block", 0.2, 2.3).replace(phi=phi)])
        return simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=20).state[-1]

    turned = 0.7 + 2 * np.pi * 1e10  # more periods than an int counts
    assert end(turned) == pytest.approx(end(turned % (2 * np.pi)), abs=1e-9)


def test_the_first_value_of_what_repeats_is_the_last():
    term = wave("block", 0.2, 2.3)
    assert "value_8" not in term.parameters
    moved = term.replace(value_0=0.1)
    assert (moved.values[0], moved.values[-1]) == (0.1, 0.1)
    model, name, h = Model(RIG, friction=LAW, effects=[moved]), f"{term.name}.value_0", 1e-6

    def end(off: float, **options):
        there = model.replace({name: 0.1 + off})
        return simulate(
            there, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=20, rtol=1e-12, atol=1e-13, **options
        )

    slope = (end(h).state[-1] - end(-h).state[-1]) / (2 * h)
    exact = end(0.0, sensitivity=(name,)).sensitivity[-1][:, 0]
    np.testing.assert_allclose(exact, slope, rtol=1e-4, atol=1e-7)


@pytest.mark.slow
def test_a_weak_wave_within_the_sampling_error_of_chi_squared_is_found():
    """Too little to show in chi-squared over all readings, and yet a sharp line."""
    case = make_case((wave("angle_body", 0.008, 2.7),), length=96.0, seed=5)
    search = search_of(case)
    null = declared(search)
    search.keep(null, ())
    assert null.excess < CLEAN
    chosen = choose(search, [null])
    assert chosen.term is not None
    assert (chosen.term.where, chosen.term.recurs) == ("angle_body", True)


def test_nothing_is_learned_where_nothing_repeats():
    case = make_case(seed=8)
    search = search_of(case)
    assert learn_recurring(search, declared(search)) == []
