"""Several effects of one sensor act in one order: crosstalk, the lag of that, its curvature, drift; in all readings."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

import stickslip as ss
from discover_cases import LAW, make_case
from stickslip import reference
from stickslip.discovery.data import prepare
from stickslip.discovery.errors import measure
from stickslip.discovery.readings import no_slopes, read, reading_velocity
from stickslip.lowering import HIDDEN

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
SENSORS = {
    "sensor_lag": {"tau": 0.15},
    "sensor_crosstalk": {"c": 0.3},
    "sensor_nonlinearity": {"q": 0.8},
    "sensor_drift": {"r": 0.01},
}


@pytest.mark.parametrize("kinds", [*combinations(SENSORS, 2), tuple(SENSORS)], ids="+".join)
def test_the_order_is_that_of_the_reference(kinds):
    effects = [ss.effect(kind, **SENSORS[kind]) for kind in kinds]
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=effects)
    start, t = (0.1, 0.1, 0, 0), np.arange(5.0, 12.0, 0.004)  # from 30 time constants on: however the lag began
    run = ss.simulate(model, belt_speed=0.1, initial=start, t_end=12, t_eval=t)
    state = np.zeros((len(t), 9))
    state[:, :4] = run.state
    for i, name in enumerate(HIDDEN):
        state[:, 4 + i] = run.hidden.get(name, 0.0)
    seen = read(t, state, no_slopes(len(t)), (), model.parameters, 0.1, 2).values
    told = reference.readings(model, reference.simulate(model, belt_speed=0.1, initial=start, t_end=12), t)
    np.testing.assert_allclose(seen, told, atol=2e-7)
    rate = reading_velocity(model, t, run.state, seen[:, 0])
    assert np.median(np.abs(rate - np.gradient(seen[:, 0], t))) < 2e-5


def test_the_portrait_of_a_forecast_has_every_sensor_effect():
    data = prepare(make_case(seed=5).validate)[0]
    effects = [ss.effect(kind, **SENSORS[kind]) for kind in SENSORS]
    found = measure(ss.Model(RIG, friction=LAW, effects=effects), data)
    assert len(found.samples) < len(data.t)  # a forecast begins after what it begins from
    assert np.isfinite(found.portrait)
    assert found.portrait > measure(ss.Model(RIG, friction=LAW), data).portrait
