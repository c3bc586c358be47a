"""A hum in a reading: found by its line, told from a force, added to the model, and forecast."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import stickslip as ss
from discover_cases import LAW, NOISE, RIG, left_by_law, make_case
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.discovery.laboratory.hum import humming
from stickslip.fitted.block_events.sensor import reading_of
from stickslip.fitted.data import prepare
from stickslip.fitted.predict import Forecaster
from stickslip.fitted.readings import ReadingCurve, as_terms, curves_of, no_slopes, read, reading_rate
from stickslip.measured.case import Case

PHASES = (0.4, 2.0, -1.1, 2.9, 0.9)


def hummed(channel: str, w: float, size: float, *, length: float = 60.0, **other: Any) -> Case:
    case = make_case((), length=length, **other)
    runs = [
        replace(run, **{channel: getattr(run, channel) + size * np.sin(w * run.t + phase)})
        for run, phase in zip(case.runs, PHASES, strict=False)
    ]
    return replace(case, runs=tuple(runs))


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("channel", "w", "jitter"), [("x1", 41.7, 0.0), ("y1", 9.3, 0.0), ("y1", 33.3, 0.4)])
def test_a_hum_is_found_with_its_frequency_and_size(channel, w, jitter):
    found = humming(left_by_law(hummed(channel, w, 3 * NOISE, jitter=jitter)))
    assert found is not None
    assert (found.where, found.variable) == (f"{channel} channel", "t")
    assert 2 * np.pi / found.period == pytest.approx(w, abs=0.05)
    assert 0.5 * np.ptp(found.value) == pytest.approx(3 * NOISE, rel=0.1)


@pytest.mark.study
def test_it_is_the_verdict():
    case = hummed("y1", 33.3, 4 * NOISE, length=30.0, speeds=(0.13, -0.14, 0.1))
    found = ss.discover(case, threads=1)
    (one,) = found.effects
    assert (found.verdict.value, one.where, one.depends_on) == ("unlisted_effect", "y1 channel", ("t",))


@pytest.mark.study
def test_noise_and_a_force_are_no_hum():
    assert humming(left_by_law(make_case((), length=60.0))) is None
    forced = ss.effect("harmonic_forcing", a=0.05, w=2.3, phi=0.0)
    assert humming(left_by_law(make_case((forced,), length=60.0))) is None


CURVE = ReadingCurve("x1", "t", tuple(np.linspace(0, 1, 9).tolist()), recurs=True)
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
    period = 2 * np.pi / 7.3
    turns = np.linspace(0, 1, 17)
    sine = 6 * NOISE * np.sin(2 * np.pi * turns)
    sine[-1] = sine[0]
    knots = (*(period * turns[:-1]), period)
    hum = ss.tabulated("x1 channel", "t", knots, sine, period=period)
    known = Model(RIG, friction=LAW)
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
