"""The sensor of x1 is one formula: of a fit's readings, of those of a block slip by slip, of their rates and back."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from stickslip.fitted.block_events.sensor import reading_of
from stickslip.fitted.readings import curves_of, no_slopes, read, reading_rate
from stickslip.simulated.states import LAGGED
from stickslip.simulated.x1_sensor import X1Sensor

T = np.linspace(0.0, 4.0, 801)
LAG = 0.05
CURVES = (
    ss.tabulated("x1 channel", "x1", (-0.5, 0.0, 0.5), (0.01, -0.02, 0.03)),
    ss.tabulated("x1 channel", "t", (0.0, 2.0, 4.0), (0.0, 0.04, 0.01)),
)


def moved() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, its rate, and x lagged, in closed form, (n,) each."""
    w = 3.0
    x, v = 0.3 * np.sin(w * T), 0.3 * w * np.cos(w * T)
    m = 0.3 * (np.sin(w * T) - w * LAG * np.cos(w * T)) / (1 + (w * LAG) ** 2)
    return x, v, m


@pytest.mark.parametrize("q", [0.0, 0.6])
@pytest.mark.parametrize("curves", [(), CURVES], ids=["plain", "curves"])
@pytest.mark.parametrize("lag", [0.0, LAG])
def test_a_fit_and_a_block_slip_by_slip_read_the_same(
    q: float, curves: tuple[ss.Tabulated, ...], lag: float
) -> None:
    effects = [ss.effect("sensor_drift", r=0.02), *curves]
    effects += [ss.effect("sensor_nonlinearity", q=q)] if q else []
    effects += [ss.effect("sensor_lag", tau=lag)] if lag else []
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1, kinetic=0.5), effects=effects)
    x, v, m = moved()
    state = np.zeros((len(T), 9))
    state[:, 0], state[:, 1], state[:, LAGGED] = x, v, m if lag else 0.0
    p, learned = model.parameters, curves_of(model)
    fitted = read(T, state, no_slopes(len(T)), (), p, 0.1, 1, learned).values[:, 0]
    sensor, seen = reading_of(model, False), m if lag else x
    np.testing.assert_allclose(fitted, sensor.read(x, seen, T), rtol=0, atol=1e-14)
    added = sum((one.curve(x if one.variable == "x1" else T) for one in curves), np.zeros(len(T)))
    np.testing.assert_allclose(fitted, seen + q * seen**2 + 0.02 * T + added, rtol=0, atol=1e-14)
    rate = reading_rate(T, state, p, learned)
    np.testing.assert_allclose(rate[2:-2], np.gradient(fitted, T)[2:-2], atol=2e-3)
    back, moves = sensor.behind(fitted, rate, T)
    # a curve is undone at the rate of what is lagged, not at that of the block
    np.testing.assert_allclose(back, seen, atol=5e-4 if lag and curves else 1e-9)
    np.testing.assert_allclose(moves, (x - m) / lag if lag else v, atol=0.03 if lag and curves else 1e-8)


def test_beyond_the_fold_it_is_the_edge() -> None:
    """2 m - m^2 has no more than 1 to read, at m = 1."""
    sensor, t = X1Sensor(gain=2.0, curvature=-1.0, drift=0.1), np.zeros(3)
    np.testing.assert_allclose(sensor.undone(np.array([0.75, 1.0, 3.0]), t), [0.5, 1.0, 3.0])
    np.testing.assert_allclose(sensor.moves(np.array([0.5, 1.0]), np.array([1.1, 1.1])), [1.0, 50.0])
