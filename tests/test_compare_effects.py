"""A model with effects against its own motion: the comparison must use all of it, and then finds the noise alone."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import stickslip as ss
from recorded import recording
from stickslip.fitted.readings import no_slopes, read
from stickslip.simulated.states import HIDDEN

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
NOISE = 1e-3
EFFECTS = {
    "belt_speed_ripple": {"a": 0.3, "w": 1.7, "phi": 0.4},
    "harmonic_forcing": {"a": 1.0, "w": 0.7},
    "friction_drift": {"r": 0.01},
    "belt_seam": {"a": 0.3, "L": 5.0},
    "static_aging": {"dT": 3.0, "tau": 4.0},
    "belt_load_droop": {"k": 0.005, "tau": 2.0},
    "friction_memory": {"tau": 0.3},
    "sensor_lag": {"tau": 0.3},
    "sensor_crosstalk": {"c": 0.5},
    "sensor_drift": {"r": 0.01},
    "sensor_nonlinearity": {"q": 1.0},
    "sensor_delay": {"delay": 0.3},
}


def readings(model, run, t, speed):
    """The chain of docs/effects.md, by the functions that the loop's own tests hold to it."""
    state = np.zeros((len(t), 9))
    state[:, : run.state.shape[1]] = run.state
    for i, name in enumerate(HIDDEN):
        state[:, 4 + i] = run.hidden.get(name, 0.0)
    return read(t, state, no_slopes(len(t)), (), model.parameters, speed, 2).values


@pytest.mark.sampled(3)
@pytest.mark.parametrize("kind", EFFECTS)
def test_the_exact_model_is_forecast_to_the_noise(tmp_path, kind):
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=[ss.effect(kind, **EFFECTS[kind])])
    t = np.arange(0, 120, 0.02)
    run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=120, t_eval=t)
    seen = readings(model, run, t, 0.1)
    seen += NOISE * np.random.default_rng(0).standard_normal(seen.shape)
    record = recording(tmp_path, RIG, t, seen[:, 0], seen[:, 1], 0.1, "exact", NOISE)
    elsewhere = {"phi": 2.0} if "phi" in model.effects[0].parameters else {}  # a phase is the run's own
    given = ss.Model(
        RIG, friction=ss.PaperFriction(), effects=[ss.effect(kind, **(EFFECTS[kind] | elsewhere))]
    )
    c = ss.compare(given, record)
    rms = np.sqrt(np.mean((c.simulated_readings - c.readings) ** 2, axis=0))
    np.testing.assert_allclose(rms, NOISE, rtol=0.1)
    row = c.row("forecast NRMSE")
    assert row.simulated < 3 * row.scatter
    if kind not in ("belt_load_droop", "sensor_crosstalk"):  # whose plateaus do not rise as the belt does
        assert c.row("release time error").simulated < 0.1


ONE_DEGREE = {
    "harmonic_forcing": {"a": 0.1, "w": 0.3, "phi": 0.4},
    "belt_seam": {"a": 0.3, "L": 5.0, "phi": 0.4},
    "friction_drift": {"r": 0.003},
    "static_aging": {"dT": 0.5, "tau": 3.0},
    "sensor_gain": {"e": 0.1},
    "sensor_drift": {"r": 0.005},
    "sensor_nonlinearity": {"q": 0.05},
    "sensor_lag": {"tau": 0.3},
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("kind", ONE_DEGREE)
def test_a_block_on_a_belt_keeps_the_time_and_the_sensors_of_the_run(tmp_path, kind):
    law, rig = ss.CoulombFriction(static=1, kinetic=0.5), ss.BlockOnBelt()
    model = ss.Model(rig, friction=law, effects=[ss.effect(kind, **ONE_DEGREE[kind])])
    t = np.arange(0, 100, 0.02)
    run = ss.simulate(model, belt_speed=0.2, initial=(0, 0.2), t_end=100, t_eval=t)
    seen = 1.1 * run.state[:, 0] if kind == "sensor_gain" else readings(model, run, t, 0.2)[:, 0]
    seen = seen + 1e-4 * np.random.default_rng(0).standard_normal(len(t))
    elsewhere = {"phi": 2.4} if "phi" in ONE_DEGREE[kind] else {}  # a phase is the run's own
    given = ss.Model(rig, friction=law, effects=[ss.effect(kind, **(ONE_DEGREE[kind] | elsewhere))])
    c = ss.compare(given, recording(tmp_path, rig, t, seen, None, 0.2, "exact", 1e-4))
    assert c.row("forecast NRMSE").simulated < 0.03
    if kind != "sensor_lag":  # which the readings' own sticks are late by
        assert c.row("release time error").simulated < 0.06


def test_a_curve_on_the_channel_is_read_too(tmp_path):
    law, rig = ss.CoulombFriction(static=1, kinetic=0.5), ss.BlockOnBelt()
    curve = ss.tabulated("x1 channel", "x1", [-1, -0.5, 0, 0.5, 1, 1.5], [0.02, -0.01, 0.02, -0.015, 0.02, 0])
    t = np.arange(0, 100, 0.02)
    plain = ss.simulate(ss.Model(rig, friction=law), belt_speed=0.2, initial=(0, 0.2), t_end=100, t_eval=t)
    x = plain.state[:, 0]
    seen = x + CubicSpline(curve.knots, curve.values, bc_type="natural")(np.clip(x, -1, 1.5))
    seen += 1e-4 * np.random.default_rng(0).standard_normal(len(t))
    record = recording(tmp_path, rig, t, seen, None, 0.2, "curved", 1e-4)
    right = ss.compare(ss.Model(rig, friction=law, effects=[curve]), record).row("forecast NRMSE").simulated
    wrong = ss.compare(ss.Model(rig, friction=law), record).row("forecast NRMSE").simulated
    assert right < 0.5 * wrong
    assert right < 0.03


def test_glitches_do_not_reach_the_window_fit(tmp_path):
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=[ss.effect("static_aging", dT=3.0, tau=4.0)])
    t = np.arange(0, 120, 0.02)
    run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=120, t_eval=t)
    seen = readings(model, run, t, 0.1) + NOISE * np.random.default_rng(0).standard_normal((len(t), 2))
    seen[100::397, 0] += 0.5
    row = ss.compare(model, recording(tmp_path, RIG, t, seen[:, 0], seen[:, 1], 0.1, "glitches", NOISE)).row(
        "forecast NRMSE"
    )
    assert row.simulated < 3 * row.scatter


def test_noise_makes_the_largest_speed_larger_on_both_sides(tmp_path):
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1, kinetic=0.5))
    t = np.arange(0, 150, 0.01)
    run = ss.simulate(model, belt_speed=0.2, initial=(0, 0.2), t_end=150, t_eval=t)
    x = run.state[:, 0] + 5e-3 * np.random.default_rng(3).standard_normal(len(t))
    row = ss.compare(model, recording(tmp_path, ss.BlockOnBelt(), t, x, None, 0.2, "noisy", 5e-3)).row(
        "largest slip speed"
    )
    assert abs(row.difference) < 2 * row.scatter


BLOCK = ss.BlockOnBelt(mass=1.0, stiffness=100.0, damping=0.5)
WAVE = ss.tabulated("x1 channel", "x1", [-0.06, -0.02, 0.02, 0.06], [0.004, -0.004, 0.004, -0.004])


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("sensors", "most"),
    [
        ({"sensor_nonlinearity": {"q": 2.0}}, 2),
        ({"sensor_gain": {"e": 0.02}, "sensor_nonlinearity": {"q": 2.0}, "sensor_drift": {"r": 1e-4}}, 2),
        ({"sensor_lag": {"tau": 0.01}}, 60),  # whose rounded tops make the level 0.6 % too high
        ({}, 4),
    ],
    ids=["curved", "gained, curved, drifting", "lagged", "waved"],
)
def test_one_channel_is_forecast_and_compared_as_its_sensor_reads(tmp_path, sensors, most):
    effects = [ss.effect(kind, **p) for kind, p in sensors.items()] or [WAVE]
    model = ss.Model(BLOCK, friction=ss.CoulombFriction(static=6.0, kinetic=3.0), effects=effects)
    t, noise = np.arange(0, 24, 0.004), 2e-5
    run = ss.simulate(model, belt_speed=0.05, initial=(0.03, 0.05), t_end=24, t_eval=t)
    p, x = model.parameters, run.hidden["m"] if "sensor_lag" in sensors else run.state[:, 0]
    seen = (1 + p.get("sensor_gain.e", 0)) * x + p.get("sensor_nonlinearity.q", 0) * x**2
    seen = seen + p.get("sensor_drift.r", 0) * t + (WAVE.curve(x) if not sensors else 0)
    seen += noise * np.random.default_rng(0).standard_normal(len(t))
    record = recording(tmp_path, BLOCK, t, seen, None, 0.05, "exact", noise)
    past = record.window(0.0, 22.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ss.ModelWarning)  # the sticks of a bent reading ride at another speed
        ahead = ss.forecast(model, past, belt_speed=0.05, horizon=1.5)
    off = ahead["x1"].to_numpy() - np.interp(ahead["t"], t, seen)
    assert np.sqrt(np.mean(off**2)) < most * noise
    c = ss.compare(model, record)
    assert np.sqrt(np.mean((c.simulated_readings - c.readings) ** 2)) < 1.3 * noise
    assert c.row("forecast NRMSE").simulated < 1.5 * c.row("forecast NRMSE").scatter


def test_a_curve_in_a_velocity_that_is_not_recorded_is_refused(tmp_path):
    curve = ss.tabulated("x1 channel", "x2", [-1, 0, 1], [0.01, 0, 0.01])
    model = ss.Model(BLOCK, friction=ss.CoulombFriction(static=6.0, kinetic=3.0), effects=[curve])
    t = np.arange(0, 24, 0.004)
    run = ss.simulate(model, belt_speed=0.05, initial=(0.03, 0.05), t_end=24, t_eval=t)
    record = recording(tmp_path, BLOCK, t, run.state[:, 0], None, 0.05, "curved", 2e-5)
    with pytest.raises(ss.InputError, match="learned_x1_x2: a curve of the reading in x2 cannot be undone"):
        ss.compare(model, record)
    with pytest.raises(ss.InputError, match="learned_x1_x2: a curve of the reading in x2 cannot be undone"):
        ss.forecast(model, record, belt_speed=0.05, horizon=1.0)
