"""What repeats in time on a place where the catalogue has no name for it: simulated, differentiated, forecast."""

from __future__ import annotations

import numpy as np
import pytest

from discover_cases import LAW, NOISE, RIG, make_case
from stickslip import Model, simulate, tabulated
from stickslip.fitted.data import prepare
from stickslip.fitted.predict import Forecaster
from stickslip.simulated.reference import integrate as reference

TURNS = np.linspace(0, 1, 9)


def wave(where: str, size: float, period: float):
    """A sine with half as much of its second harmonic, 0 at phase 0."""
    values = size * (np.sin(2 * np.pi * TURNS) + 0.5 * np.sin(4 * np.pi * TURNS))
    values[-1] = values[0] = 0.0
    return tabulated(where, "t", period * TURNS, values, period=period)


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


@pytest.mark.sampled(3)
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
