"""A lag of the y1 reading is on no list, and is not called a delay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from discover_cases import LAW, NOISE, RIG, make_case, recording
from stickslip.declared.effect import effect
from stickslip.declared.model import Model
from stickslip.discovery import lagging, loop, trace
from stickslip.discovery.choice import choose
from stickslip.discovery.rivals import shapes
from stickslip.discovery.search import Search
from stickslip.fitted.engine import Engine
from stickslip.fitted.readings import lagged
from stickslip.fitted.windows import cut
from stickslip.simulated.simulate import simulate

FINE = 20


@pytest.mark.parametrize("tau", [0.01, 0.3, 2.0])
def test_the_lag_of_made_up_samples_is_that_of_its_equation(tau):
    t = np.concatenate([[0.0], np.cumsum(np.random.default_rng(1).uniform(0.01, 0.04, 300))])
    y, rate = np.sin(1.3 * t) + 0.3 * np.cos(2.9 * t), 1.3 * np.cos(1.3 * t) - 0.87 * np.sin(2.9 * t)
    found = lagged(t, y, rate, tau)
    run = solve_ivp(
        lambda at, m: (np.sin(1.3 * at) + 0.3 * np.cos(2.9 * at) - m) / tau, (0, t[-1]), [found[0]], t_eval=t,
        rtol=1e-11, atol=1e-12, method="Radau",
    )  # fmt: skip
    np.testing.assert_allclose(found, run.y[0], atol=1e-7)
    both = lagged(t, np.stack([y, 2 * y], 1), np.stack([rate, 2 * rate], 1), tau)
    np.testing.assert_allclose(both, np.stack([found, 2 * found], 1), atol=1e-12)


def test_it_begins_where_a_smooth_past_would_have_left_it():
    t, tau = np.arange(0, 10, 0.02), 0.1
    slow = np.exp(1j * 1.1 * t)
    found = lagged(t, slow.real, (1.1j * slow).real, tau)
    np.testing.assert_allclose(found, (slow / (1 + 1.1j * tau)).real, atol=2e-4)


def late_case(tau=0.0, delay=0.0):
    """Runs whose y1 reading lags, or is late."""
    case = make_case(length=60.0)
    runs, rng = [], np.random.default_rng(7)
    for run in case.runs:
        t = np.arange(-10.0, 60.0, 0.05 / FINE)
        start = (np.sign(run.belt_speed) * 0.1, 0.5 * run.belt_speed, 0.02, 0.0)
        made = simulate(
            Model(RIG, friction=LAW), belt_speed=run.belt_speed, initial=start, t_end=70.0, t_eval=t + 10.0
        )  # fmt: skip
        y1, a = made.state[:, 2], np.exp(-0.05 / FINE / tau) if tau else 0.0
        read = lfilter([(1 - a) / 2, (1 - a) / 2], [1, -a], y1) if tau else np.interp(t - delay, t, y1)
        seen = t > -1e-9
        x1, read = (one[seen][::FINE] + NOISE * rng.standard_normal(1200) for one in (made.state[:, 0], read))
        runs.append(
            recording(run.name, run.role, run.belt_speed, t[seen][::FINE] - t[seen][0], x1, read, NOISE)
        )
    return replace(case, runs=tuple(runs))


def searched(case):
    """A search in which the declared law and a delay have been fitted."""
    data, _ = loop._checked(case, ())
    search = Search(
        data[: len(case.train)], Model(case.rig, friction=case.friction), 2, lambda _: None, 200.0
    )
    null = search.polish(trace.declared(search))
    search.keep(null, ())
    (start,) = shapes("sensor_delay", search.data)
    delay = search.close(trace._screened(search, ("sensor_delay", start), base=null))
    search.keep(delay, delay.names)
    return search, delay


def test_a_lag_is_told_from_a_delay():
    search, delay = searched(late_case(tau=0.25))
    _, lag = lagging.lag_of(search, delay)
    assert lag.chi2 == pytest.approx(1.0, abs=0.05)
    assert delay.chi2 > 1.05
    tau = lagging.time_constant(lag)
    assert tau.low < 0.25 < tau.high
    assert tau.value == pytest.approx(0.25, rel=0.02)
    choice = choose(search, [delay, search.tried[()]])
    assert choice.place == ("y1 channel", ("memory",))
    assert choice.lag.value == pytest.approx(0.25, rel=0.02)
    assert choice.trial.names == ("sensor_delay",)  # stands in


def test_a_delay_stays_one():
    search, delay = searched(late_case(delay=0.25))
    assert delay.chi2 == pytest.approx(1.0, abs=0.05)
    assert lagging.lag_of(search, delay) is None


def test_derivatives_of_lagged_readings_are_those_of_differences():
    case = make_case(length=30.0)
    data, _ = loop._checked(case, ())
    search = Search(data[:1], Model(case.rig, friction=case.friction), 1, lambda _: None, 200.0)
    delayed = trace.hypothesis(search.model, [trace.Start(effect("sensor_delay", delay=0.2))], search.model)
    trial = search.run(delayed, cycles=1.0, iterations=1, rounds=0)
    h = lagging._hypothesis(search, trial, 0.2)
    engine = Engine(search.data, h, 1)
    vector, windows = h.start(1), cut(search.data, h.model, 1.0)[:1]
    (block,) = engine.linearised(vector, windows)
    names = [u.name for u in h.shared]
    for name in ("y1_lag.tau", "T_s_minus"):
        i, step = names.index(name), np.zeros(len(vector))
        step[i] = 1e-5
        near = (
            engine.residual(vector + step, windows[0]) - engine.residual(vector - step, windows[0])
        ) / -2e-5
        np.testing.assert_allclose(block.J[:, i], near, atol=1e-4 * np.abs(near).max())
