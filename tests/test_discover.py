"""The loop end to end on small made cases, and what it refuses."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from discover_cases import LAW, RIG, make_case
from stickslip.discover import Verdict, discover
from stickslip.discovery.unlisted import guess
from stickslip.effects import effect
from stickslip.errors import InputError
from stickslip.forecast import forecast
from stickslip.model import Model

KEYS = {"verdict", "effects", "error", "ranking", "gate", "residual_before", "residual_after", "messages"}


@pytest.fixture(scope="module")
def clean():
    return discover(make_case(length=40.0), budget=60)


@pytest.fixture(scope="module")
def crossed():
    return discover(make_case(length=40.0, crosstalk=0.15, seed=2), budget=60)


def test_nothing_is_found_where_nothing_is(clean):
    assert clean.verdict is Verdict.no_effect
    assert clean.effects == ()
    assert clean.residual_after.clean
    assert clean.error.after == clean.error.before
    assert clean.error.after < 1.2 * clean.error.floor


def test_a_sensor_effect_is_named_with_its_size(crossed):
    assert crossed.verdict is Verdict.effect_found
    (found,) = crossed.effects
    assert (found.name, found.where) == ("sensor_crosstalk", "x1 channel")
    c = found.parameters["c"]
    assert c.low < 0.15 < c.high
    assert c.high - c.low < 0.01
    assert crossed.residual_after.clean
    assert crossed.error.after < 0.3 * crossed.error.before
    assert found.evidence.delta_chi2 > 10 * found.evidence.threshold
    assert found.evidence.control < found.evidence.delta_chi2


def test_the_report_is_json(crossed):
    report = json.loads(json.dumps(crossed.report))
    assert report.keys() >= KEYS
    assert report["verdict"] == "effect_found"
    assert report["effects"][0]["parameters"]["c"].keys() == {"value", "low", "high"}
    assert report["error"].keys() >= {"metric", "before", "after", "floor"}


def test_the_runs_can_be_drawn(crossed):
    for view in crossed.runs:
        n = len(view.t)
        assert view.state_after.shape == (n, 4)
        assert view.after["x1"].shape == view.force_after.shape == view.speed_before.shape == (n,)
    train = next(view for view in crossed.runs if view.role == "train")
    r = (train.measured["x1"] - train.after["x1"]) / train.noise["x1"]
    assert np.isfinite(r).mean() > 0.8
    assert np.nanstd(r) == pytest.approx(1.0, abs=0.1)


def test_the_model_after_survives_its_file(crossed, tmp_path):
    from stickslip.model import load_model

    crossed.after.save(tmp_path / "model_after.toml")
    assert load_model(tmp_path / "model_after.toml") == crossed.after


def test_a_forecast_of_the_true_model_leaves_the_noise_alone():
    case = make_case(length=40.0, crosstalk=0.15, seed=2)
    run = case.validate[0]
    past, future = run.window(0.0, 30.0), run.window(30.0, 40.0)
    model = Model(RIG, friction=LAW, effects=[effect("sensor_crosstalk", c=0.15)])
    table = forecast(model, past, belt_speed=run.belt_speed, horizon=9.0)
    assert list(table.columns) == ["t", "x1", "y1"]
    np.testing.assert_allclose(table["t"], future.t[: len(table)], atol=1e-9)
    for channel in ("x1", "y1"):
        off = table[channel].to_numpy() - getattr(future, channel)[: len(table)]
        assert np.sqrt(np.mean(off**2)) < 1.2e-3


def test_a_forecast_finds_the_phase_from_the_past():
    term = effect("harmonic_forcing", a=0.4, w=2.3, phi=0.0)
    case = make_case((term,), seed=4)
    run = case.runs[0]
    model = Model(RIG, friction=LAW, effects=[term])
    table = forecast(model, run.window(0.0, 36.0), belt_speed=run.belt_speed, horizon=8.0)
    off = table["x1"].to_numpy() - run.window(36.0, 48.0).x1[: len(table)]
    assert np.sqrt(np.mean(off**2)) < 4e-3


def test_a_horizon_below_a_sample_is_refused():
    run = make_case(length=30.0).runs[0]
    with pytest.raises(InputError, match="horizon"):
        forecast(Model(RIG, friction=LAW), run, belt_speed=run.belt_speed, horizon=0.01)


def test_a_channel_in_the_wrong_unit_is_said():
    case = make_case(length=40.0)
    runs = tuple(replace(run, y1=1000.0 * run.y1) for run in case.runs)
    with pytest.raises(InputError, match="y1"):
        discover(replace(case, runs=runs), budget=30)


@pytest.mark.parametrize(
    ("f", "words"),
    [(lambda x: -3 * x**2, "-3 x1^2"), (lambda x: 0.5 * np.abs(x), "+0.5 |x1|"), (lambda x: x**3, "+1 x1^3")],
)
def test_a_plain_curve_is_recognised(f, words):
    x = np.linspace(-1, 1, 101)
    assert words in str(guess(x, f(x), np.full(101, 0.05), "x1"))


def test_a_curve_that_is_not_plain_gets_no_formula():
    x = np.linspace(-1, 1, 101)
    assert guess(x, np.sin(9 * x), np.full(101, 0.02), "x1") is None
