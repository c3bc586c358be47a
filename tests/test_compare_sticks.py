"""Where a comparison sees a block stick: not in steady sliding, under any sensor's gain, and always in numbers."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.fitted.comparison_rows import Row

RIG = ss.BlockOnBelt(mass=1.0, stiffness=1.0, damping=0.02)
LAW = ss.CoulombFriction(static=1.0, kinetic=0.6)
T = 0.05 * np.arange(1600)


def record(x: np.ndarray, speed: float, noise: float = 0.0) -> ss.Recording:
    noisy = x + noise * np.random.default_rng(0).standard_normal(len(x))
    frame = pd.DataFrame({"t": T[: len(x)], "x1": noisy})
    return ss.load_recording(frame, RIG, belt_speed=speed, name="run")


def moved(effects: list[ss.Effect], speed: float = 0.2) -> np.ndarray:
    model = ss.Model(RIG, friction=LAW, effects=effects)
    return ss.simulate(model, belt_speed=speed, initial=(0.1, 0.1), t_end=T[-1], t_eval=T).state[:, 0]


@pytest.mark.parametrize("speed", [0.2, 0.02, -0.2])
@pytest.mark.parametrize("noise", [0.0, 1e-4, 1e-2, 0.1])
def test_a_block_at_rest_on_a_sliding_belt_does_not_stick(speed: float, noise: float) -> None:
    """Noise that hides the belt's speed in single velocities made a stick of all of it."""
    c = ss.compare(ss.Model(RIG, friction=LAW), record(np.full(len(T), np.sign(speed) * 0.6), speed, noise))
    assert c.row("stick fraction").measured == 0


@pytest.mark.parametrize("speed", [0.2, -0.2])
def test_a_block_that_rides_all_along_sticks(speed: float) -> None:
    c = ss.compare(ss.Model(RIG, friction=LAW), record(speed * T, speed, 1e-2))
    assert c.row("stick fraction").measured == 1


@settings(max_examples=12, deadline=None)
@given(e=st.floats(-0.95, 30), q=st.floats(-0.2, 0.3), r=st.floats(-0.05, 0.05))
def test_sticks_are_found_whatever_the_sensor_makes_of_them(e: float, q: float, r: float) -> None:
    """A gain of 1.3 left none: sticks were looked for at the belt's speed in readings that rise 1.3 times as fast."""
    x, q = moved([]), q * (1 + e)
    effects = [
        ss.effect("sensor_gain", e=e), ss.effect("sensor_nonlinearity", q=q), ss.effect("sensor_drift", r=r)
    ]  # fmt: skip
    read = (1 + e) * x + q * x**2 + r * T
    c = ss.compare(ss.Model(RIG, friction=LAW, effects=effects), record(read, 0.2, 1e-4 * (1 + e)))
    bare = ss.compare(ss.Model(RIG, friction=LAW), record(x, 0.2, 1e-4))
    assert len(c.measured.sticks) == len(bare.measured.sticks) > 5
    for side in ("measured", "simulated"):
        ours, theirs = (getattr(one.row("stick fraction"), side) for one in (c, bare))
        assert ours == pytest.approx(theirs, abs=0.01)
    assert c.row("transitions missed").simulated == 0
    assert c.row("slip amplitude").measured == pytest.approx(
        c.row("slip amplitude").simulated, rel=0.01
    )  # as read


@settings(max_examples=25, deadline=None)
@given(
    n=st.integers(63, 400),
    speed=st.sampled_from([0.2, -0.2, 0.0, 2.0]),
    noise=st.sampled_from([0.0, 1e-4, 1e-2]),
    shape=st.sampled_from(["slides", "rests", "rides", "at zero"]),
)
@example(n=181, speed=0.2, noise=0.0, shape="slides")  # a variance below 0 by rounding
def test_every_number_of_a_comparison_is_one(n: int, speed: float, noise: float, shape: str) -> None:
    x = {"slides": moved([]), "rests": 0 * T + 0.6, "rides": speed * T, "at zero": 0 * T}[shape][:n]
    c = ss.compare(ss.Model(RIG, friction=LAW), record(x, speed, noise))
    assert "nan" not in c.table().lower()
    json.dumps(c.to_dict(), allow_nan=False)


def test_what_is_not_finite_is_not_known() -> None:
    row = Row("period", "s", float("nan"), float("inf"), float("nan"), "")
    assert (row.measured, row.simulated, row.scatter, row.difference) == (None, None, None, None)
    assert row.cells == ("-", "-", "-", "-")
