"""Several effects of one sensor act in one order: crosstalk, the lag of that, its curvature, drift; in all readings."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

import stickslip as ss
from discover_cases import LAW, make_case
from stickslip.discovery.errors import measure
from stickslip.errors import InputError
from stickslip.fitted.data import prepare
from stickslip.fitted.readings import curves_of, no_slopes, read, reading_rate
from stickslip.fitted.window import Window
from stickslip.fitted.windows import behind, with_hidden
from stickslip.simulated.reference import integrate as reference
from stickslip.simulated.states import HIDDEN, LAGGED

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
    start = (0.1, 0.1, 0, 0)
    t = np.arange(5.0, 9.0, 0.004)  # from 30 time constants on: however the lag began
    run = ss.simulate(model, belt_speed=0.1, initial=start, t_end=9, t_eval=t)
    state = np.zeros((len(t), 9))
    state[:, :4] = run.state
    for i, name in enumerate(HIDDEN):
        state[:, 4 + i] = run.hidden.get(name, 0.0)
    seen = read(t, state, no_slopes(len(t)), (), model.parameters, 0.1, 2).values
    slow = reference.simulate(model, belt_speed=0.1, initial=start, t_end=9)
    assert len(slow.transitions.t) == 2  # there is a slip, and rest before and after it
    told = reference.readings(model, slow, t[::10], interpolated=True)
    np.testing.assert_allclose(seen[::10], told, atol=2e-7)
    rate = reading_rate(t, state, model.parameters)
    assert np.median(np.abs(rate - np.gradient(seen[:, 0], t))) < 2e-5


KNOTS = {"x1": 0.5, "x2": 0.6, "y1": 0.4, "y2": 0.4, "t": 20.0}


@pytest.mark.parametrize("variable", [None, *KNOTS])
@pytest.mark.parametrize("q", [0.8, -2.0])  # -2: the reading folds back at x1 = 0.25
def test_the_rate_of_a_reading_is_its_derivative(variable, q):
    effects = [ss.effect(kind, **SENSORS[kind]) for kind in SENSORS if kind != "sensor_nonlinearity"]
    effects.append(ss.effect("sensor_nonlinearity", q=q))
    if variable:
        knots = (
            KNOTS[variable] * np.array([-1, -0.4, 0, 0.4, 1]) if variable != "t" else np.arange(0, 21, 5.0)
        )
        effects.append(ss.tabulated("x1 channel", variable, knots, [0.01, 0.03, 0, 0.02, -0.01]))
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=effects)
    t = np.arange(0, 20, 0.002)
    run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=20, t_eval=t)
    state = np.zeros((len(t), 9))
    state[:, :4], state[:, 4 + HIDDEN.index("m")] = run.state, run.hidden["m"]
    p, curves = model.parameters, curves_of(model)
    seen = read(t, state, no_slopes(len(t)), (), p, 0.1, 2, curves).values[:, 0]
    off = np.abs(reading_rate(t, state, p, curves) - np.gradient(seen, t))
    assert np.quantile(off, 0.98) < 2e-4
    without = np.abs(reading_rate(t, state, p) - np.gradient(seen, t))
    assert variable is None or np.quantile(without, 0.98) > 2e-3


def test_the_portrait_of_a_forecast_has_every_sensor_effect():
    data = prepare(make_case(seed=5).validate)[0]
    effects = [ss.effect(kind, **SENSORS[kind]) for kind in SENSORS]
    found = measure(ss.Model(RIG, friction=LAW, effects=effects), data)
    assert len(found.samples) < len(data.t)  # a forecast begins after what it begins from
    assert np.isfinite(found.portrait)
    assert found.portrait > measure(ss.Model(RIG, friction=LAW), data).portrait


@pytest.mark.parametrize(
    "kinds", [(), ("sensor_lag",), ("sensor_lag", "sensor_drift"), tuple(SENSORS)], ids="+".join
)
def test_a_window_starts_from_the_motion_behind_the_readings(kinds):
    effects = [ss.effect(kind, **SENSORS[kind]) for kind in kinds]
    effects += [
        ss.effect("sensor_delay", delay=0.1),
        ss.tabulated("x1 channel", "t", [0, 5, 10], [0.02, -0.02, 0.03]),
    ]
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=effects)
    t = np.arange(0, 10, 0.004)
    run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=10, t_eval=t)
    state = np.zeros((len(t), 9))
    state[:, :4] = run.state
    if "m" in run.hidden:
        state[:, 4 + HIDDEN.index("m")] = run.hidden["m"]
    p, curves = model.parameters, curves_of(model)
    seen = read(t, state, no_slopes(len(t)), (), p, 0.1, 2, curves).values
    rates = np.gradient(seen, t, axis=0)
    told = np.stack([behind(p, curves, t[i], np.ravel([seen[i], rates[i]], "F")) for i in range(len(t))])
    off = np.abs(told - run.state)[500:-2]
    worst = np.quantile(off, 0.9, axis=0) / np.ptp(run.state, axis=0)
    assert np.all(
        worst < (0.02, 0.25 if "sensor_lag" in kinds else 0.02, 0.02, 0.08)
    )  # a lag's own m'' is left out
    raw = np.abs(np.column_stack([seen[:, 0], rates[:, 0]]) - run.state[:, :2])[500:-2]
    share = np.quantile(off, 0.5, axis=0)[:2] / np.quantile(raw, 0.5, axis=0)
    assert np.all(share < (0.3, 0.9 if "sensor_lag" in kinds else 0.1))


def test_a_lag_starts_from_what_the_crosstalk_before_it_makes():
    effects = [ss.effect(kind, **SENSORS[kind]) for kind in ("sensor_lag", "sensor_crosstalk")]
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=effects)
    t = np.arange(5, 10, 0.1)
    run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=10, t_eval=t)
    data = prepare(make_case(seed=5).train)[0]
    off = []
    for state, m in zip(run.state, run.hidden["m"], strict=True):
        start = np.pad(state, (0, 5))
        window = Window(0, 0, 90, start, (0, 1, 2, 3), start, np.full(9, np.inf))
        off.append(with_hidden(window, model, data).state[LAGGED] - m)
    assert np.median(np.abs(off)) < 0.02 * np.ptp(run.hidden["m"])


def test_what_only_the_reading_has_is_refused_of_the_motion():
    bent = ss.tabulated("x1 channel", "x1", [-1, 0, 1], [0.01, 0, 0.01])
    lagged, bare = (
        ss.Model(
            RIG, friction=ss.PaperFriction(), effects=[*more, ss.effect("sensor_crosstalk", c=0.3), bent]
        )
        for more in ([ss.effect("sensor_lag", tau=0.15)], [])
    )
    run = {"belt_speed": 0.1, "initial": (0.1, 0.1, 0, 0), "t_end": 1.0}
    words = "acts on the reading, not on the motion"
    for model, name in (
        (bare, "sensor_crosstalk.c"),
        (lagged, "learned_x1_x1.value_0"),
        (bare, "sensor_drift.r"),
    ):
        with pytest.raises(InputError, match=words):
            ss.simulate(model, **run, sensitivity=[name])
    for name in ("sensor_lag.tau", "sensor_crosstalk.c", "initial.m"):
        with pytest.raises(InputError, match=words):
            ss.sweep(lagged, {name: [0.1, 0.2]}, **run)
        assert ss.simulate(lagged, **run, sensitivity=[name]).t[-1] == 1.0  # m depends on it
