"""Where a block sticks: the one finder, seen on records whose sticks are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.measured.sticks import CREEP, LONG, Track, plateau_speed, rides, rises, track

NOISE = 1e-3
DT = 0.02


def record(cycles: int, speed: float, gain: float = 1.0, seed: int = 0) -> tuple[np.ndarray, np.ndarray, int]:
    """Times and x of a block that rides the belt for 4 and swings back in half a turn of 1.5, so often."""
    rest, slip = int(4 / DT), int(1.5 / DT)
    top = 0.5 * speed * 4
    stick = np.linspace(-top, top, rest, endpoint=False)
    swing = top * np.cos(np.pi * np.arange(slip) / slip)
    x = np.tile(np.concatenate([stick, swing]), cycles + 1)[: cycles * (rest + slip) + rest]
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(x))
    return DT * np.arange(len(x)), gain * (x + noise), rest


def found(t: np.ndarray, x: np.ndarray, speed: float) -> Track:
    return track(t, x, belt_speed=speed, noise=NOISE, period=3.0)


@settings(max_examples=20, deadline=None)
@given(cycles=st.integers(3, 8), speed=st.floats(0.1, 0.6), seed=st.integers(0, 99))
def test_every_slip_has_a_stick_on_both_sides_and_its_size(cycles: int, speed: float, seed: int) -> None:
    t, x, rest = record(cycles, speed, seed=seed)
    seen = found(t, x, speed)
    assert len(seen.slips) == cycles
    for before, slip, after in seen.slips:
        assert before.stop == slip.start
        assert slip.stop == after.start
        assert abs(len(before) - rest) <= 12
        assert seen.size(slip) == pytest.approx(4 * speed, rel=0.03)
    assert [one.middle for one in seen.clear_sticks] == [(s.start + s.stop) // 2 for s in seen.sticks]


@settings(max_examples=10, deadline=None)
@given(speed=st.floats(0.1, 0.6), seed=st.integers(0, 99))
def test_a_belt_that_runs_the_other_way_gives_the_mirror_image(speed: float, seed: int) -> None:
    t, x, _ = record(5, speed, seed=seed)
    one, other = found(t, x, speed), found(t, -x, -speed)
    assert [(s.start, s.stop, s.mode) for s in one.segments] == [
        (s.start, s.stop, -s.mode) for s in other.segments
    ]
    assert len(one.slips) == len(other.slips) == 5
    np.testing.assert_allclose(rises(one, x, NOISE).speed, -rises(other, -x, NOISE).speed, rtol=1e-9)


@pytest.mark.parametrize("ratio", [0.93, 1.0, 1.08])
def test_the_plateau_is_the_speed_that_the_sticks_rise_at(ratio: float) -> None:
    t, x, _ = record(6, 0.2 * ratio)
    speed, std = plateau_speed(
        track(t, x, belt_speed=0.2, noise=NOISE, period=3.0, tolerance=CREEP), x, NOISE
    )
    assert abs(speed - 0.2 * ratio) < 5 * std < 0.01


def test_a_rise_passes_by_outliers_and_missing_readings_and_knows_its_noise() -> None:
    t, clean, _ = record(30, 0.2)
    x = clean.copy()
    x[50::97] += 0.5
    x[::13] = np.nan
    seen = rises(found(t, clean, 0.2), x, NOISE)
    assert len(seen.speed) > 25
    assert np.std((seen.speed - 0.2) / seen.std) == pytest.approx(1.0, abs=0.35)


def test_few_and_short_sticks_give_no_speed() -> None:
    t, x, _ = record(1, 0.2)
    assert np.isnan(plateau_speed(found(t, x, 0.2), x, NOISE)).all()
    short = found(t[: LONG + 20], x[: LONG + 20], 0.2)
    assert len(rises(short, x, NOISE).t) <= 1


def test_velocities_ride_within_a_quarter_of_the_belts_whichever_way_it_runs() -> None:
    v = np.array([0.74, 0.76, 1.0, 1.24, 1.26, -1.0])
    expected = [False, True, True, True, False, False]
    assert rides(v, 1.0).tolist() == expected
    assert rides(-v, -1.0).tolist() == expected
    assert rides(np.array([0.0, 1e-9]), 0.0).tolist() == [True, False]
