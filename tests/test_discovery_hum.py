"""A hum in a reading: found by its line, told from a force, added to the model, and forecast."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from discover_cases import NOISE, RIG, make_case
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.discovery.hum import humming
from stickslip.discovery.place import place_of
from stickslip.discovery.recurring import learn_hum
from stickslip.discovery.search import CLEAN, Search
from stickslip.discovery.trace import declared
from stickslip.fitted.block_events.sensor import reading_of
from stickslip.fitted.data import prepare
from stickslip.fitted.predict import Forecaster
from stickslip.fitted.readings import Learned, as_terms, curves_of, no_slopes, read, reading_rate
from stickslip.measured.case import Case

PHASES = (0.4, 2.0, -1.1, 2.9, 0.9)


def hummed(channel: str, w: float, size: float, *, jitter: float = 0.0) -> Case:
    case = make_case((), length=60.0, jitter=jitter)
    runs = [
        replace(run, **{channel: getattr(run, channel) + size * np.sin(w * run.t + phase)})
        for run, phase in zip(case.runs, PHASES, strict=True)
    ]
    return replace(case, runs=tuple(runs))


def searched(case: Case) -> tuple[Search, object]:
    search = Search(prepare(case.train), Model(RIG, friction=PaperFriction()), 1, lambda _: None, 60.0)
    return search, declared(search)


@pytest.mark.parametrize(
    ("channel", "w", "jitter"), [("x1", 3.1, 0.0), ("x1", 41.7, 0.0), ("y1", 9.3, 0.0), ("y1", 33.3, 0.4)]
)
def test_a_hum_is_found_with_its_frequency_size_and_phases(channel, w, jitter):
    search, null = searched(hummed(channel, w, 3 * NOISE, jitter=jitter))
    assert null.excess > 10 * CLEAN
    where, line = humming(null)
    off = np.arctan2(line.amplitudes[:, 1], line.amplitudes[:, 0]) - PHASES[: len(line.amplitudes)]
    assert np.abs(np.exp(1j * off) - 1).max() < 0.6
    assert line.w == pytest.approx(w, abs=0.05)
    assert where == f"{channel} channel"
    (term, best), *_ = learn_hum(search, null)
    assert (term.where, term.variable, term.recurs) == (where, "t", True)
    assert best.excess < CLEAN
    model = best.model
    assert model.parameters[f"learned_{channel}_t.w"] == pytest.approx(w, rel=1e-3)
    curve = model.effects[-1].curve(np.linspace(0, 2 * np.pi / w, 200))
    assert 0.5 * np.ptp(curve) == pytest.approx(3 * NOISE, rel=0.1)
    found = np.exp(1j * np.array(best.hypothesis.phases[f"learned_{channel}_t.phi"]))
    turned = found / np.exp(
        1j * np.array(PHASES[: len(found)])
    )  # the same for all runs: where a turn begins is free
    assert np.abs(turned - turned[0]).max() < 0.3


def test_noise_and_a_force_are_no_hum():
    _, null = searched(make_case((), length=60.0))
    assert humming(null) is None
    forced = ss.effect("harmonic_forcing", a=0.05, w=2.3, phi=0.0)
    search, null = searched(make_case((forced,), length=60.0))
    assert null.excess > CLEAN
    assert not learn_hum(search, null) or learn_hum(search, null)[0][0].where == "block"


def test_where_nothing_else_fits_the_reading_that_hums_is_the_place():
    search, null = searched(hummed("x1", 41.7, 3 * NOISE))
    assert place_of(search, null, null) == ("x1 channel", ("t",))


def test_much_that_no_motion_is_like_is_in_a_reading():
    """Bursts in y1, each with a frequency of its own: no line, no curve, and yet not nothing."""
    rng, case = np.random.default_rng(4), make_case((), length=60.0)
    runs = []
    for run in case.runs:
        y1 = run.y1.copy()
        for at in range(0, len(y1) - 20, 20):
            part = np.arange(at, at + 20)
            y1[part] += 2.5 * NOISE * np.sin(rng.uniform(0.6, 2.8) * part + rng.uniform(0, 6))
        runs.append(replace(run, y1=y1))
    search, null = searched(replace(case, runs=tuple(runs)))
    assert null.chi2 > 1.5
    assert place_of(search, null, null) == ("y1 channel", ("t",))


CURVE = Learned("x1", "t", tuple(np.linspace(0, 1, 9).tolist()), recurs=True)
NUMBERS = {f"learned_x1_t.value_{i}": float(np.sin(i) - np.sin(0)) for i in range(1, 8)}
P = {**NUMBERS, "learned_x1_t.w": 2.7, "learned_x1_t.phi": 0.8}


def test_a_curve_that_recurs_is_the_model_s_own():
    """What the chain adds is what the tabulated term is, and it goes to a model and back."""
    t = np.linspace(0, 20, 4001)
    state = np.zeros((len(t), 9))
    term = as_terms([CURVE], P)[0]
    again = curves_of(Model(RIG, friction=PaperFriction(), effects=[term]))[0]
    assert again.recurs
    np.testing.assert_allclose(again.knots, CURVE.knots, atol=1e-12)
    made = read(t, state, no_slopes(len(t)), (), P, 0.1, 2, (CURVE,)).values[:, 0]
    np.testing.assert_allclose(made, term.curve(t), atol=1e-12)
    p = {f"{term.name}.{key}": value for key, value in term.parameters.items()}
    np.testing.assert_allclose(
        read(t, state, no_slopes(len(t)), (), p, 0.1, 2, (again,)).values[:, 0], made, atol=1e-12
    )
    rate = reading_rate(t, state, P, (CURVE,))
    np.testing.assert_allclose(rate[2:-2], np.gradient(made, t)[2:-2], atol=2e-3)


@pytest.mark.parametrize("name", [*NUMBERS, "learned_x1_t.w", "learned_x1_t.phi"])
def test_its_derivatives_are_differences(name):
    t = np.linspace(0, 20, 301)
    state = np.zeros((len(t), 9))
    slopes = {k: np.zeros((len(t), 1)) for k in range(9)}
    got = read(t, state, slopes, (name,), P, 0.1, 2, (CURVE,)).slopes[:, 0, 0]
    h = 1e-6
    ends = [
        read(t, state, no_slopes(len(t)), (), {**P, name: P[name] + s * h}, 0.1, 2, (CURVE,)).values[:, 0]
        for s in (1, -1)
    ]
    np.testing.assert_allclose(got, (ends[0] - ends[1]) / (2 * h), atol=1e-6 * max(1, np.abs(got).max()))


def test_a_forecast_finds_the_hum_s_phase_from_the_past():
    case = hummed("x1", 7.3, 6 * NOISE)
    run = prepare(case.runs)[-1]
    _, null = searched(make_case((), length=60.0))
    period = 2 * np.pi / 7.3
    turns = np.linspace(0, 1, 17)
    sine = 6 * NOISE * np.sin(2 * np.pi * turns)
    sine[-1] = sine[0]
    knots = (*(period * turns[:-1]), period)
    hum = ss.tabulated("x1 channel", "t", knots, sine, period=period)
    known = null.model
    stop = len(run.t) - 100

    def off(model: Model) -> float:
        told = Forecaster(model, run, 1, curves_of(model)).forecast(stop, run.t[stop:])
        return float(np.sqrt(np.mean((told.readings[:, 0] - run.readings[stop:, 0]) ** 2)))

    without, with_hum = off(known), off(replace(known, effects=(*known.effects, hum)))
    assert without > 3.5 * NOISE
    assert with_hum < 1.4 * NOISE


@pytest.mark.parametrize("period", [None, 0.9])
def test_a_curve_in_time_of_a_block_on_a_belt_is_undone_with_its_own_rate(period):
    """Also one that recurs, over many turns: deflections and rates come back from readings and theirs."""
    knots = np.linspace(0.0, period or 6.0, 9)
    values = 0.02 * np.sin(2 * np.pi * knots / (period or 3.0))
    values[-1] = values[0]
    phi = {} if period is None else {"phi": 0.7}
    term = ss.tabulated("x1 channel", "t", knots, values, period=period, **phi)
    reading = reading_of(
        ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(), effects=[term]), force_channel=False
    )
    t = np.linspace(0.0, 8.0, 16001)  # beyond the last knot of the one that does not recur
    x = np.sin(t)
    seen = reading.read(x, None, t)
    found, rate = reading.behind(seen, np.gradient(seen, t), t)
    np.testing.assert_allclose(found, x, atol=1e-9)
    smooth = np.abs(t - 6.0) > 0.01  # the other has a kink at its last knot
    np.testing.assert_allclose(rate[smooth][2:-2], np.cos(t)[smooth][2:-2], atol=1e-4)
