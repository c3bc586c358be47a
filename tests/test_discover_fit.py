"""The fit under discovery: derivatives, elimination, starts, the measurement chain."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from discover_cases import LAW, RIG, make_case
from stickslip.discovery.data import prepare
from stickslip.discovery.engine import Engine, moved
from stickslip.discovery.intervals import intervals
from stickslip.discovery.periodic import periodic_starts
from stickslip.discovery.readings import Learned, read
from stickslip.discovery.ripple import ripple_starts
from stickslip.discovery.rivals import Start, hypothesis
from stickslip.discovery.solve import fit
from stickslip.discovery.windows import cut
from stickslip.effects import effect
from stickslip.friction import PaperFriction
from stickslip.model import Model


@pytest.fixture(scope="module")
def pool():
    with ThreadPoolExecutor(2) as threads:
        yield threads


@pytest.fixture(scope="module")
def clean():
    return make_case()


def fitted(case, pool, starts=(), cycles=1.0):
    data = prepare(case.train)
    h = hypothesis(Model(RIG, friction=PaperFriction()), list(starts))
    return fit(Engine(data, h, pool), h.start(len(data)), cut(data, h.model, cycles))


def test_the_declared_law_is_recovered_to_the_noise(clean, pool):
    found = fitted(clean, pool)
    assert abs(found.per_reading - 1) < 5 * np.sqrt(2 / found.readings)
    for name, interval in intervals(found).items():
        if interval.low is None:
            continue
        half = 0.5 * (interval.high - interval.low)
        assert abs(interval.value - getattr(LAW, name)) < 2.5 * half, name


def test_long_windows_and_short_ones_agree(clean, pool):
    short, long = fitted(clean, pool), fitted(clean, pool, cycles=3.0)
    a, b = intervals(short)["T_s_minus"], intervals(long)["T_s_minus"]
    assert abs(a.value - b.value) < a.high - a.low


def test_irregular_sampling_is_exact(pool):
    found = fitted(make_case(jitter=0.4, seed=3), pool)
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
def test_slopes_are_those_of_differences(clean, pool, term):
    data = prepare(clean.train[:1])
    h = hypothesis(Model(RIG, friction=LAW), [Start(term)])
    engine, vector = Engine(data, h, pool), h.start(1)
    window = cut(data, h.model, 0.6)[1]
    block = engine.linearise(vector, window)
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
    none = np.zeros((61, 9, 0))
    for delay in (0.13, -0.08):
        chain = read(t, state, none, (), {"sensor_delay.delay": delay}, 0.1, 2)
        off = chain.values[:, 1] - np.sin(t - delay)
        assert np.abs(off[5:-5]).max() < 1e-7
        assert np.abs(off).max() < 1e-3


def test_a_learned_curve_interpolates_and_holds_outside():
    curve = Learned("x1", "y1", (0.0, 0.5, 1.0))
    values = np.array([0.0, 1.0, 0.5])
    at = curve.basis(np.array([0.0, 0.5, 1.0, 2.0])) @ values
    np.testing.assert_allclose(at, [0.0, 1.0, 0.5, 0.5], atol=1e-12)


def test_a_forcing_is_found_by_its_line(pool):
    case = make_case((effect("harmonic_forcing", a=0.4, w=2.3, phi=0.0),))
    starts = periodic_starts(fitted(case, pool), ["harmonic_forcing"], peaks=1)
    assert starts["harmonic_forcing"][0].term.parameters["w"] == pytest.approx(2.3, abs=0.05)


def test_a_ripple_is_read_off_the_sticks():
    case = make_case((effect("belt_speed_ripple", a=0.15, w=6.0, phi=0.0),))
    (start, *_) = ripple_starts(prepare(case.train))
    assert start.term.parameters["w"] == pytest.approx(6.0, abs=0.05)
    assert start.term.parameters["a"] == pytest.approx(0.15, rel=0.4)


def test_glitches_do_not_reach_the_fit(pool):
    case = make_case(seed=5)
    for run in case.runs:
        run.x1[37::173] += 0.3
    found = fitted(case, pool)
    assert found.per_reading < 1.1
