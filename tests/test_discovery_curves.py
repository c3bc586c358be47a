"""Curves on readings: part of the model, of its file and of its forecasts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from discover_cases import LAW, NOISE, RIG, make_case
from stickslip.declared.model import Model, load_model
from stickslip.discovery import errors
from stickslip.discovery.errors import error_block
from stickslip.discovery.workers import Workers
from stickslip.errors import InputError
from stickslip.fitted.data import prepare
from stickslip.fitted.predict import Forecaster
from stickslip.fitted.readings import as_terms, curves_of, reading_rate
from stickslip.likelihoods.forecast import forecast
from stickslip.measured.case import Case

KNOTS = tuple(np.linspace(-0.6, 0.6, 7).tolist())
CURVE = ss.tabulated("y1 channel", "y1", KNOTS, [-0.6 * k**3 for k in KNOTS])


def bent() -> Case:
    """A case whose y1 sensor adds CURVE to its readings."""
    case = make_case(length=48.0, seed=3)
    runs = []
    for run in case.runs:
        assert run.y1 is not None
        runs.append(
            replace(run, y1=run.y1 + CURVE.curve(run.y1))
        )  # of the noisy reading: 3 % more noise at most
    return replace(case, runs=tuple(runs))


@pytest.fixture
def model() -> Model:
    return Model(RIG, friction=LAW, effects=[CURVE])


def test_the_motion_does_not_feel_it(model: Model) -> None:
    both = [
        ss.simulate(one, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=30.0)
        for one in (model, Model(RIG, friction=LAW))
    ]
    np.testing.assert_array_equal(both[0].state, both[1].state)


def test_it_survives_the_file(model: Model, tmp_path) -> None:
    model.save(tmp_path / "model.toml")
    assert load_model(tmp_path / "model.toml") == model
    assert curves_of(load_model(tmp_path / "model.toml"))[0].name == CURVE.name == "learned_y1_y1"


def test_a_fit_s_curve_becomes_the_model_s(model: Model) -> None:
    (learned,) = curves_of(model)
    assert as_terms([learned], model.parameters) == (CURVE,)


@pytest.mark.filterwarnings("ignore:.*the band is noise alone")
def test_the_file_forecasts_what_the_loop_does(model: Model, tmp_path) -> None:
    model.save(tmp_path / "model.toml")
    run = bent().validate[0]
    past = run.window(0.0, 36.0)
    table = forecast(load_model(tmp_path / "model.toml"), past, belt_speed=run.belt_speed, horizon=9.0)
    (data,) = prepare([run])
    stop = len(past.t)
    inside = Forecaster(model, data, 2, curves_of(model)).forecast(stop, data.t[stop : stop + len(table)])
    ahead = table[["x1", "y1"]].to_numpy()
    np.testing.assert_allclose(ahead, inside.readings[:, :2], atol=0.3 * NOISE)
    off = ahead - np.stack([run.x1, run.y1], 1)[stop : stop + len(table)]
    assert np.sqrt(np.mean(off**2)) < 1.3 * NOISE


@pytest.mark.study
def test_it_is_what_the_error_after_counts(model: Model) -> None:
    case = bent()
    block, _ = error_block(model.with_effects([]), model, prepare(case.validate), case.validate, Workers(1))
    assert block.after < 0.5 * block.before
    assert block.after < 1.3 * block.floor
    assert block.before != block.floor
    aside, _ = error_block(model.with_effects([]), model, prepare(case.validate), case.validate, Workers(2))
    assert aside == block  # whoever makes the forecasts


def test_the_floor_is_the_mean_of_several_draws(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    case, runs = bent(), prepare(bent().validate)
    mean, _ = error_block(model, model, runs, case.validate, Workers(1), seed=4)
    monkeypatch.setattr(errors, "DRAWS", 1)
    each = [error_block(model, model, runs, case.validate, Workers(1), seed=s)[0] for s in (4, 5, 6)]
    assert len({one.floor for one in each}) == 3
    assert mean.floor == pytest.approx(np.mean([one.floor for one in each]))
    for name in ("x1", "y1"):
        rms = [one.runs[0].rmse[name]["floor"] for one in each]
        assert mean.runs[0].rmse[name]["floor"] == pytest.approx(np.mean(rms))


def test_a_model_that_stays_as_it_is_has_one_error(model: Model) -> None:
    case = bent()
    block, kept = error_block(model, model, prepare(case.validate), case.validate, Workers(1))
    assert block.before == block.after
    assert all(was is now for was, now in kept.values())


def test_the_rate_of_a_bent_reading() -> None:
    knots = np.linspace(-1, 1, 9)
    bent_x1 = ss.tabulated("x1 channel", "x1", knots, 0.2 * np.sin(2 * knots))
    t = np.linspace(0, 6, 2001)
    state = np.stack([np.sin(t), np.cos(t), 0 * t, 0 * t], 1) * 0.9
    reading = state[:, 0] + bent_x1.curve(state[:, 0])
    model = Model(RIG, friction=LAW, effects=[bent_x1])
    rate = reading_rate(t, np.pad(state, ((0, 0), (0, 5))), model.parameters, curves_of(model))
    np.testing.assert_allclose(rate[5:-5], np.gradient(reading, t)[5:-5], atol=1e-4)


def test_what_a_reading_cannot_depend_on() -> None:
    with pytest.raises(InputError, match="a curve of a reading depends on x1, x2, y1, y2 or t"):
        ss.tabulated("y1 channel", "v_w", [0.0, 0.5, 1.0], [0.0, 1.0, 0.0])
