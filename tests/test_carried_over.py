"""The error on runs never fitted, where friction scatters: forecasts as the model and its scatter let expect."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from scattering import DT, RIG, record
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.carried import error_block, likelihood
from stickslip.discovery.laboratory.hypothesis import Term
from stickslip.discovery.workers import Workers
from stickslip.fitted.data import Data, prepare
from stickslip.likelihoods.ahead import ahead
from stickslip.likelihoods.fit_state import Fit, begin
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.population import Population
from stickslip.likelihoods.rig_windows import RigSensors
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.stretches import stretches

NOISE, SCATTER = 1e-3, 0.02
DAMPED = ss.effect("block_viscous_damping", c=1.0)
FORCED = ss.effect("harmonic_forcing", a=0.12, w=1.3, phi=0.7)
WEAK = ss.effect("block_viscous_damping", c=0.15)
ABSENT = ss.effect("spring_cubic_k1", k=2.0)
PLAIN = ss.Model(ss.Rig(**RIG), friction=ss.PaperFriction())


def recorded(*effects: ss.Effect, speeds: tuple[float, ...], seed: int) -> list[ss.Recording]:
    rng, out = np.random.default_rng(seed), []
    for speed in speeds:
        t, readings = record(PLAIN.with_effects(effects), speed, 16, SCATTER, rng)
        x1, y1 = (readings + NOISE * rng.standard_normal(readings.shape)).T
        columns = {"t": t, "x1": x1, "y1": y1}
        one = ss.load_recording(columns, PLAIN.rig, belt_speed=speed, noise={"x1": NOISE, "y1": NOISE})
        out.append(replace(one, name=f"at {speed}"))
    return out


def known(data: list[Data], *effects: ss.Effect) -> tuple[Fit, ss.Model]:
    """A fit of other runs that found all numbers as they are."""
    terms = [Term(one, tuple(0.0 for _ in data) if "phi" in one.parameters else ()) for one in effects]
    bench = BeltBench(PLAIN, data, stretches(data), Declared(), POLICY, RigSensors())
    scatter = Population(level=SCATTER, curve=1e-4, length=0.4, static=1e-4, belt=1e-4)
    return replace(begin(bench.windows(terms)), population=scatter), PLAIN.with_effects(effects)


def test_a_weak_effect_is_likelier_event_by_event_where_friction_scatters_widely() -> None:
    """Forecasts of a cycle spoke against such a name by 56, where its events speak for it by 23."""
    data = prepare(recorded(WEAK, speeds=(0.1, -0.12), seed=7))
    wide = Population(level=0.04, curve=0.1, length=0.1, static=0.03, belt=0.008)
    lacking, right, more = (
        replace(known(data, *some)[0], population=wide) for some in ((), (WEAK,), (WEAK, ABSENT))
    )
    held = likelihood(right, lacking, 30.0, {}, data, Workers(1))
    assert held is not None
    assert held.forecasts > 15
    assert held.gain > 10
    assert held.chance > 0.95
    assert held.carries
    beside = likelihood(more, lacking, 30.0, {"spring_cubic_k1": (right, 5.0)}, data, Workers(1))
    assert beside is not None
    assert beside.name == "spring_cubic_k1"
    assert beside.gain < -5
    assert not beside.carries
    assert likelihood(right, None, None, {}, data, Workers(1)) is None
    assert likelihood(right, right, None, {}, data, Workers(1)) is None


@pytest.mark.study
def test_the_right_model_is_off_by_as_much_as_scatter_and_noise_leave() -> None:
    runs = recorded(DAMPED, speeds=(0.1, -0.12, 0.15), seed=1)
    data = prepare(runs)
    (lacking, before), (right, after) = known(data), known(data, DAMPED)
    block, views = error_block((lacking, right), (before, after), data, runs, Workers(1), 0)
    assert block.after == pytest.approx(block.floor, rel=0.25)
    assert block.before > 1.3 * block.after
    assert block.floor > 5 * NOISE / np.std(data[0].readings[:, 0])
    for row in block.runs:
        assert row.two_cycles["after"] > 0.8 * row.one_cycle["after"]
        assert row.rmse["x1"]["floor"] > NOISE
        assert row.transition_time["after"] < 0.1
    assert block.covered is not None
    assert 0.88 < block.covered < 0.99
    made = views[runs[0].name][1]
    assert len(made.samples) == len(made.prediction.readings) > 0.5 * len(data[0].t)


def test_it_forecasts_from_the_past_alone() -> None:
    (data,) = prepare(recorded(DAMPED, speeds=(0.1,), seed=2))
    fit, _ = known([data], DAMPED)
    first = ahead(fit, data, 1.0)
    assert len(first) > 8
    middle = first[4]
    # what is read later says nothing: but for the places of the friction curve's knots
    readings = data.readings.copy()
    readings[middle.start :] += (
        0.3 * NOISE * np.random.default_rng(0).standard_normal(readings[middle.start :].shape)
    )
    again = ahead(fit, replace(data, readings=readings), 1.0)[4]
    np.testing.assert_allclose(again.mean, middle.mean, atol=0.1 * NOISE)
    readings[: middle.start] += 20 * NOISE
    moved = ahead(fit, replace(data, readings=readings), 1.0)[4]
    assert np.abs(moved.mean - middle.mean).max() > 5 * NOISE


def test_a_phase_is_known_from_the_windows_before() -> None:
    model = PLAIN.with_effects([FORCED])
    t = np.arange(0.0, 110.0, DT)
    run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0.0, 0.0), t_end=110.0, t_eval=t)
    noisy = run.state[:, [0, 2]] + NOISE * np.random.default_rng(5).standard_normal((len(t), 2))
    columns = {"t": t, "x1": noisy[:, 0], "y1": noisy[:, 1]}
    one = ss.load_recording(columns, PLAIN.rig, belt_speed=0.1, noise={"x1": NOISE, "y1": NOISE})
    data = prepare([one])
    (plain, before), (fit, after) = known(data), known(data, FORCED)
    repeat = Population(level=1e-4, curve=1e-4, length=0.4, static=1e-4, belt=1e-4)
    fits = tuple(replace(each, population=repeat) for each in (plain, fit))
    block, _ = error_block(fits, (before, after), data, [one], Workers(1), 0)
    noise = np.sqrt(np.mean((NOISE / data[0].readings[:, :2].std(axis=0)) ** 2))
    assert block.after < 2 * noise
    assert block.before > 8 * noise
    first = ahead(fits[1], data[0], 1.0)
    turns = [one.values["harmonic_forcing.phi"] for one in first]
    off = np.mod(np.array(turns) - 0.7 + np.pi, 2 * np.pi) - np.pi
    assert np.abs(off).max() < 0.1
    assert len(set(turns)) > len(turns) / 2  # each from its own past


@pytest.mark.parametrize("shorter", [1.0, 0.9])
def test_a_forecast_begins_when_its_window_has_told_where_it_is(shorter: float) -> None:
    """From a reading or two the draws went everywhere, an error of 3,000 standard deviations; from none was a crash."""
    whole = recorded(speeds=(0.1,), seed=2)[0]
    run = prepare([whole.window(0.0, 3.6 * prepare([whole])[0].cycle)])[0]
    run = replace(run, cycle=shorter * run.cycle)
    cut = stretches([run])
    assert cut[0].start > round(run.cycle / DT) - POLICY.fewest_stuck
    fit, _ = known([run])
    told = ahead(fit, run, 2.0)
    assert told[0].start == cut[0].start + POLICY.fewest_stuck
    for one in told:
        assert one.spread.max() < 0.2 * run.readings.std()
