"""The fit under discovery: derivatives, elimination, starts, the measurement chain."""

from __future__ import annotations

import numpy as np
import pytest

from discover_cases import LAW, RIG, make_case
from hypotheses import Start, hypothesis
from stickslip.declared.effect import effect
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.discovery.laboratory import outcome
from stickslip.discovery.laboratory.left import left
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.fitted.data import prepare
from stickslip.fitted.engine import Engine
from stickslip.fitted.readings import ReadingCurve, no_slopes, read
from stickslip.fitted.relax import sought
from stickslip.fitted.solve import fit
from stickslip.fitted.window import moved
from stickslip.fitted.windows import cut, start_window
from stickslip.likelihoods.fit import null


@pytest.fixture(scope="module")
def clean():
    return make_case()


def fitted(case, starts=(), cycles=1.0):
    data = prepare(case.train)
    h = hypothesis(Model(RIG, friction=PaperFriction()), list(starts))
    return fit(Engine(data, h, 2), h.start(len(data)), cut(data, h.model, cycles))


def test_the_declared_law_is_recovered_to_the_noise(clean):
    bench = bench_of(clean, prepare(clean.train))
    found = null(bench.windows(), bench.policy)
    assert left(bench, found).per_reading == pytest.approx(1.0, abs=0.05)
    told = {name: one for name, one in outcome.law(found).items() if one.low is not None}
    assert {"T_s_minus", "T_s_plus", "A1"} <= told.keys()
    for name, one in told.items():
        assert abs(one.value - getattr(LAW, name)) < 2.5 * 0.5 * (one.high - one.low), name


def test_irregular_sampling_is_exact():
    found = fitted(make_case(jitter=0.4, seed=3))
    assert abs(found.per_reading - 1) < 5 * np.sqrt(2 / found.readings)


@pytest.mark.parametrize(
    "term",
    [
        effect("sensor_lag", tau=0.2),
        effect("sensor_delay", delay=0.13),
        effect("sensor_crosstalk", c=0.1),
        effect("sensor_nonlinearity", q=0.2),
        effect("sensor_drift", r=0.001),
        effect("block_viscous_damping", c=0.7),
        effect("belt_load_droop", k=0.003, tau=0.8),
        effect("contact_compliance", k=300.0, c=0.5),
    ],
    ids=lambda term: term.name,
)
def test_slopes_are_those_of_differences(clean, term):
    data = prepare(clean.train[:1])
    h = hypothesis(Model(RIG, friction=LAW), [Start(term)])
    engine, vector = Engine(data, h, 2), h.start(1)
    window = cut(data, h.model, 0.6)[1]
    (block,) = engine.linearised(vector, [window])
    for columns, shift in ((block.J, "unknown"), (block.K, "own")):
        for k in range(columns.shape[1]):
            step = 1e-5
            e = np.zeros(columns.shape[1])
            e[k] = step
            if shift == "unknown":
                up, down = engine.residual(vector + e, window), engine.residual(vector - e, window)
            else:
                up, down = (
                    engine.residual(vector, moved(window, e)),
                    engine.residual(vector, moved(window, -e)),
                )
            slope = -(up - down) / (2 * step)
            close = np.abs(slope - columns[:, k]) < 2e-3 * np.abs(columns[:, k]).max() + 0.05
            assert close.mean() > 0.98  # a sample beside a transition may be crossed by it


def test_a_late_channel_is_read_by_hermite_and_taylor():
    t = np.linspace(0, 3, 61)
    state = np.zeros((61, 9))
    state[:, 2], state[:, 3] = np.sin(t), np.cos(t)
    for delay in (0.13, -0.08):
        chain = read(t, state, no_slopes(61), (), {"sensor_delay.delay": delay}, 0.1, 2)
        off = chain.values[:, 1] - np.sin(t - delay)
        assert np.abs(off[5:-5]).max() < 1e-7
        assert np.abs(off).max() < 1e-3


def test_a_late_channel_does_not_look_into_the_next_window():
    t = np.linspace(0, 3, 61)
    state, known = np.zeros((61, 9)), {"sensor_delay.delay": 0.13}
    state[:, 2], state[:, 3] = np.sin(t), np.cos(t)
    state[30:, 2] += 5.0
    whole = read(t, state, no_slopes(61), (), known, 0.1, 2, offset=np.array([0, 30, 61]))
    apart = [
        read(t[part], state[part], no_slopes(len(t[part])), (), known, 0.1, 2).values
        for part in (slice(30), slice(30, None))
    ]
    np.testing.assert_array_equal(whole.values, np.concatenate(apart))


def test_windows_together_are_windows_one_by_one(clean):
    """One call of the core for all of them, in threads; own states sought in step."""
    data = prepare(clean.train[:2])
    lag = effect("sensor_lag", tau=0.1)
    h = hypothesis(Model(RIG, friction=LAW), [Start(lag), Start(effect("static_aging", dT=0.2, tau=3.0))])
    engine, vector = Engine(data, h, 2), h.start(2)
    windows = [
        start_window(run, k, h.model, a, a + 90) for k, run in enumerate(data) for a in range(0, 600, 83)
    ]
    together = engine.linearised(vector, windows)
    assert len({w.free for w in windows}) > 1  # some start in stick
    for w, b in zip(windows, together, strict=True):
        (alone,) = engine.linearised(vector, [w])
        assert alone is not None
        np.testing.assert_array_equal(b.r, alone.r)
        np.testing.assert_array_equal(b.J, alone.J)
        np.testing.assert_array_equal(b.K, alone.K)
        np.testing.assert_allclose(
            b.products, np.column_stack([b.J, b.K, b.r]).T @ np.column_stack([b.J, b.K, b.r])
        )
    found, costs = sought(engine, vector, windows, 4)
    for w, better, cost in zip(windows, found, costs, strict=True):
        (own,), own_cost = sought(engine, vector, [w], 4)
        np.testing.assert_allclose(own.state, better.state, rtol=1e-9, atol=1e-12)
        assert cost == pytest.approx(own_cost[0])
        assert cost <= engine.costs(vector, [w])[0]


def test_a_learned_curve_interpolates_and_holds_outside():
    curve = ReadingCurve("x1", "y1", (0.0, 0.5, 1.0))
    values = np.array([0.0, 1.0, 0.5])
    at = curve.basis(np.array([0.0, 0.5, 1.0, 2.0])) @ values
    np.testing.assert_allclose(at, [0.0, 1.0, 0.5, 0.5], atol=1e-12)


def test_glitches_do_not_reach_the_fit():
    case = make_case(seed=5)
    for run in case.runs:
        run.x1[37::173] += 0.3
    found = fitted(case)
    assert found.per_reading < 1.1
