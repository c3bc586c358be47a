"""The loop end to end on small made cases, and what it refuses."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from discover_cases import FEW, LAW, RIG, make_case
from stickslip.declared.effect import effect
from stickslip.declared.model import Model
from stickslip.discovery.discover import Verdict, discover
from stickslip.discovery.laboratory.curve_words import guess
from stickslip.errors import InputError
from stickslip.likelihoods.forecast import forecast

SHORT = pytest.mark.filterwarnings("ignore:.*the band is noise alone")  # a past of two events

KEYS = {"verdict", "effects", "error", "ranking", "gate", "residual_before", "residual_after", "messages"}


@pytest.fixture(scope="module")
def clean():
    return discover(make_case(length=40.0, speeds=FEW))


@pytest.fixture(scope="module")
def crossed():
    return discover(make_case(length=20.0, dt=0.1, speeds=FEW, crosstalk=0.15, seed=2))


def test_nothing_is_found_where_nothing_is(clean):
    assert clean.verdict is Verdict.no_effect
    assert clean.effects == ()
    assert clean.scatter == {}  # every event repeats
    assert clean.residual_after.clean
    assert clean.error.after == clean.error.before
    assert clean.error.after < 1.5 * clean.error.floor  # of one short run, whose members are drawn
    assert clean.error.floor < 0.03


@pytest.mark.study
def test_a_sensor_effect_is_named_with_its_size():
    crossed = discover(make_case(length=30.0, speeds=FEW, crosstalk=0.15, seed=2))
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


def test_the_ranking_begins_with_the_best_and_knows_what_was_chosen(clean, crossed):
    for found, names in ((clean, ()), (crossed, ("sensor_crosstalk",))):
        assert [one.bic for one in found.ranking] == sorted(one.bic for one in found.ranking)
        assert found.ranking[0].bic == 0
        assert [one.names for one in found.ranking if one.chosen] == [names]
    assert crossed.ranking[0].parameters["sensor_crosstalk.c"] == pytest.approx(0.15, abs=0.01)


def test_the_report_is_json(crossed):
    report = json.loads(json.dumps(crossed.report))
    assert report.keys() >= KEYS
    assert report["verdict"] == "effect_found"
    assert report["effects"][0]["parameters"]["c"].keys() >= {"value", "low", "high"}
    assert report["error"].keys() >= {"metric", "before", "after", "floor"}


def test_the_report_is_what_is_written(crossed, tmp_path):
    crossed.write_report(tmp_path / "out")
    assert json.loads((tmp_path / "out" / "report.json").read_text()) == json.loads(
        json.dumps(crossed.report)
    )
    bare = replace(crossed, case=None).report
    assert "declared" not in bare
    assert bare["error"] == crossed.report["error"]


def test_scatter_is_said_where_nothing_scatters(crossed):
    told = crossed.report["scatter"]
    assert crossed.scatter == {}
    assert list(told) == ["static", "kinetic", "belt", "constants"]
    for name in ("static", "kinetic", "belt"):
        one = told[name]
        assert 0.0 == one["low"] <= one["value"] <= one["high"] < 0.01
    assert told["constants"].keys() <= crossed.report["declared"].keys()
    for name, off in told["constants"].items():
        row = crossed.report["declared"][name]
        assert off["value"] == pytest.approx(row["runs"]["value"] / row["value"] - 1)
    assert told["constants"]
    assert crossed.after.scatter is not None
    assert crossed.after.scatter.level < 4e-3


def test_the_runs_can_be_drawn(crossed):
    for view in crossed.runs:
        n = len(view.t)
        assert view.state_after.shape == (n, 4)
        assert view.after["x1"].shape == view.force_after.shape == view.speed_before.shape == (n,)
    train = next(view for view in crossed.runs if view.role == "train")
    r = (train.measured["x1"] - train.after["x1"]) / train.noise["x1"]
    assert np.isfinite(r).mean() > 0.3  # windows reach from the middle of the first stick to that of the last
    assert np.nanstd(r) == pytest.approx(1.0, abs=0.15)  # they have numbers of their own


def test_the_model_after_survives_its_file(crossed, tmp_path):
    from stickslip.declared.model import load_model

    crossed.after.save(tmp_path / "model_after.toml")
    assert load_model(tmp_path / "model_after.toml") == crossed.after


@SHORT
def test_a_forecast_of_the_true_model_leaves_the_noise_alone():
    case = make_case(length=40.0, crosstalk=0.15, seed=2)
    run = case.validate[0]
    past, future = run.window(0.0, 30.0), run.window(30.0, 40.0)
    model = Model(RIG, friction=LAW, effects=[effect("sensor_crosstalk", c=0.15)])
    table = forecast(model, past, belt_speed=run.belt_speed, horizon=9.0)
    assert list(table.columns) == ["t", "x1", "y1", "x1_low", "x1_high", "y1_low", "y1_high"]
    np.testing.assert_allclose(table["t"], future.t[: len(table)], atol=1e-9)
    for channel in ("x1", "y1"):
        off = table[channel].to_numpy() - getattr(future, channel)[: len(table)]
        assert np.sqrt(np.mean(off**2)) < 1.2e-3


@SHORT
def test_a_forecast_finds_the_phase_from_the_past():
    term = effect("harmonic_forcing", a=0.4, w=2.3, phi=0.0)
    case = make_case((term,), seed=4)
    run = case.runs[0]
    model = Model(RIG, friction=LAW, effects=[term])
    table = forecast(model, run.window(0.0, 36.0), belt_speed=run.belt_speed, horizon=8.0)
    off = table["x1"].to_numpy() - run.window(36.0, 48.0).x1[: len(table)]
    assert np.sqrt(np.mean(off**2)) < 4e-3


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"seed": -1}, "seed = -1: must be at least 0"),
        ({"seed": "a"}, "seed = 'a': not a number"),
        ({"threads": 0}, "threads = 0: must be at least 1"),
        ({"threads": 1.5}, "threads = 1.5: must be a whole number"),
        ({"progress": 3}, "progress: must be a function"),
    ],
)
def test_an_argument_that_cannot_be_is_refused_before_the_search(given, said):
    with pytest.raises(InputError, match=re.escape(said)):
        discover(make_case(length=30.0), **given)


def test_a_horizon_below_a_sample_is_refused():
    run = make_case(length=30.0).runs[0]
    with pytest.raises(InputError, match="horizon"):
        forecast(Model(RIG, friction=LAW), run, belt_speed=run.belt_speed, horizon=0.01)


def test_a_channel_in_the_wrong_unit_is_said():
    case = make_case(length=40.0)
    runs = tuple(replace(run, y1=1000.0 * run.y1) for run in case.runs)
    with pytest.raises(InputError, match="y1"):
        discover(replace(case, runs=runs))


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


@SHORT
@pytest.mark.parametrize(("interval", "digits"), [(0.0399871234, 5), (1 / 60, 3), (1 / 40, 2), (1 / 128, 3)])
@pytest.mark.parametrize("dropped", [False, True])
def test_rounded_times_cost_a_forecast_no_sample(interval, digits, dropped):
    """A file's times end somewhere: a horizon of so many samples has as many rows."""
    run, count = make_case(length=40.0).validate[0], int(30.0 / interval)
    t = np.round(interval * np.arange(count), digits)
    seen = np.delete(t, [400, 401, 700]) if dropped else t
    past = replace(run, t=seen, x1=np.interp(seen, run.t, run.x1), y1=np.interp(seen, run.t, run.y1))
    table = forecast(Model(RIG, friction=LAW), past, belt_speed=run.belt_speed, horizon=227 * interval)
    assert len(table) == 227
    expected = t[-1] + interval * np.arange(1, 228)
    np.testing.assert_allclose(table["t"], expected, atol=2 * 10**-digits)


@SHORT
def test_a_forecast_has_a_row_for_each_sample_of_its_horizon():
    run = make_case(length=40.0).validate[0]
    interval, model = 0.0399871234, Model(RIG, friction=LAW)
    t = np.round(interval * np.arange(600), 5)
    past = replace(run, t=t, x1=np.interp(t, run.t, run.x1), y1=np.interp(t, run.t, run.y1))
    for steps in (1, 227):
        table = forecast(model, past, belt_speed=run.belt_speed, horizon=steps * interval)
        np.testing.assert_allclose(table["t"], t[-1] + interval * np.arange(1, steps + 1), atol=2e-5)
