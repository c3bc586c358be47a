"""A comparison forecasts as `forecast` does: the same readings from the same past, whatever the rig and the model."""

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from recorded import recording
from stickslip.fitted.identify import measured
from stickslip.fitted.model_runs import runs_of
from stickslip.measured.sticks import runs

NOISE = 1e-4
BLOCK, SLIDES = ss.BlockOnBelt(), ss.CoulombFriction(static=1, kinetic=0.5)
DRAG = ss.effect("formula", called="drag", where="block", force="-c*deflection_rate**3", c=0.4)
BENT = ss.effect("formula", called="bent", where="x1", reading="1.3*reading + q*sin(t)", q=0.01)
TWO = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
MODELS = {
    "block": (BLOCK, SLIDES, [], 0.2),
    "block, the other way": (BLOCK, SLIDES, [], -0.2),
    "block, aging": (BLOCK, SLIDES, [ss.effect("static_aging", dT=0.5, tau=3.0)], 0.2),
    "block, sensor": (BLOCK, SLIDES, [ss.effect("sensor_gain", e=0.3)], 0.2),
    "block, a formula": (BLOCK, SLIDES, [DRAG], 0.2),
    "block, a formula and a lag": (BLOCK, SLIDES, [DRAG, ss.effect("sensor_lag", tau=0.1)], 0.2),
    "block, sensor by a formula": (BLOCK, SLIDES, [BENT], 0.2),
    "two degrees, a formula": (TWO, ss.PaperFriction(), [DRAG], 0.1),
    "two degrees": (TWO, ss.PaperFriction(), [], 0.1),
    "two degrees, memory": (TWO, ss.PaperFriction(), [ss.effect("friction_memory", tau=0.3)], 0.1),
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", MODELS)
def test_a_comparison_forecasts_what_forecast_does(name: str, tmp_path: Path) -> None:
    rig, law, effects, speed = MODELS[name]
    model = ss.Model(rig, friction=law, effects=effects)
    t = np.arange(0, 80, 0.02)
    start = (0, speed) if rig is BLOCK else (0.1, 0.1, 0, 0)
    true = ss.simulate(model, belt_speed=speed, initial=start, t_end=80, t_eval=t)
    noise = NOISE * np.random.default_rng(1).standard_normal((2, len(t)))
    gain = 1.3 if "sensor" in name else 1.0
    x1 = gain * (true.hidden["m"] if "lag" in name else true.state[:, 0]) + noise[0]
    x1 = x1 + 0.01 * np.sin(t) if "by a formula" in name else x1
    y1 = None if rig is BLOCK else true.state[:, 2] + noise[1]
    whole = recording(tmp_path, rig, t, x1, y1, speed, "whole", NOISE)
    run = measured(whole, rig)
    at, ahead = [one.middle for one in runs(true.mode) if one.mode == 0][-3], 400
    ours = runs_of(run, model, whole, [(0, at), (at, at + ahead)]).ahead[at : at + ahead]
    past = recording(tmp_path, rig, t[:at], x1[:at], None if y1 is None else y1[:at], speed, "past", NOISE)
    theirs = ss.forecast(model, past, belt_speed=speed, horizon=0.02 * ahead)
    np.testing.assert_allclose(ours[:, 0], theirs["x1"], atol=3 * NOISE * gain)
    assert np.sqrt(np.mean((ours[:, 0] - x1[at : at + ahead]) ** 2)) < 0.03 * np.std(x1)
