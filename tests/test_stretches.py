"""Where windows are cut: at sticks, and at no top of a swing that passes for one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.fitted.data import Data, prepare
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.stretches import stretches

BELT, DT, NOISE = 0.15, 0.04, 1e-3


def run(x: np.ndarray, name: str = "run", belt_speed: float = BELT) -> Data:
    """Readings of a block of natural frequency 1 as windows are cut from them."""
    t = DT * np.arange(len(x))
    x = x + NOISE * np.random.default_rng(3).standard_normal(len(x))
    one = ss.load_recording(
        {"t": t, "x1": x},
        ss.BlockOnBelt(mass=1.0, stiffness=1.0),
        belt_speed=belt_speed,
        noise={"x1": NOISE},
        name=name,
    )
    return prepare([one])[0]


def swing(top: float, cycles: int = 16) -> np.ndarray:
    """A free swing whose largest speed is a share of the belt's."""
    t = np.arange(0, 2 * math.pi * cycles, DT)
    return 0.3 + top * BELT * np.sin(t)


def stick_slip(rides: float, lasts: float, cycles: int = 16) -> np.ndarray:
    """Sticks at a share of the belt's speed, and swings down and up in between as a Coulomb block has them."""
    speed, way = rides * BELT, rides * BELT * lasts
    angle = math.atan2(speed, way / 2)
    slip = math.hypot(speed, way / 2) * np.cos(np.arange(-angle, math.pi + angle, DT))
    return 0.3 + np.tile(np.concatenate([slip, -way / 2 + speed * np.arange(0, lasts, DT)]), cycles)


@pytest.mark.parametrize("top", [0.6, 0.78, 0.85, 0.92])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_top_of_a_swing_is_no_stick(top: float, sign: int) -> None:
    """A run that rang at 0.85 of the belt's speed was cut at its tops: an effect of four times the noise was missed."""
    every = stretches([run(sign * swing(top), belt_speed=sign * BELT)])
    assert len(every) >= POLICY.fewest_windows
    assert not any(one.stuck for one in every)


@pytest.mark.parametrize("lasts", [0.5, 1.0, 2.0, 4.0])
def test_a_stick_is_cut_in_its_middle(lasts: float) -> None:
    data = run(stick_slip(1.0, lasts))
    every = [one for one in stretches([data]) if one.stuck]
    assert len(every) >= POLICY.fewest_windows
    for one in every:
        assert data.v[one.start] == pytest.approx(BELT, rel=0.15)
        assert lasts - 0.2 < one.rest < lasts + 1.1  # with what comes near the belt's speed at both ends


@pytest.mark.parametrize(("slower", "lasts"), [(0.97, 0.7), (0.94, 1.0), (0.88, 2.5)])
def test_a_stick_on_a_slower_belt_stays_one(slower: float, lasts: float) -> None:
    """A belt slows down under its load; a contact creeps: what lasts longer than a swing is a stick."""
    assert all(one.stuck for one in stretches([run(stick_slip(slower, lasts))]))


@pytest.mark.parametrize("rides", [0.6, 0.75, 1.25, 1.4])
@pytest.mark.parametrize("sign", [1, -1])
def test_sticks_are_found_whatever_the_set_point_says(rides: float, sign: int) -> None:
    """A belt that ran a fifth faster than declared left 9 windows of 37, and nothing was searched."""
    every = stretches([run(sign * stick_slip(rides, 2.0), belt_speed=sign * BELT)])
    assert len(every) >= POLICY.fewest_windows
    assert all(one.stuck and one.rest > 1.8 for one in every)


def test_a_swing_beside_runs_that_ride_elsewhere_is_no_stick() -> None:
    sticks, swings = run(stick_slip(1.3, 2.0), "sticks"), run(swing(0.9), "swings")
    assert {one.run for one in stretches([sticks, swings]) if one.stuck} == {0}


def test_what_never_sticks_is_cut_from_slip_to_slip() -> None:
    sticks, swings = run(stick_slip(1.0, 2.0), "sticks"), run(swing(0.85), "swings")
    every = stretches([sticks, swings])
    assert all(one.stuck == (one.run == 0) for one in every)
    assert [one.start for one in every if one.run == 1] == swings.slips[:-1].tolist()
    still = replace(swings, slips=np.zeros(0, dtype=np.int64))
    assert stretches([still]) == []


def uneven(tops: list[float]) -> np.ndarray:
    """Events as of `stick_slip` about a kinetic friction of 0.3, each with a breakaway of its own."""
    out = [np.array([0.3])]
    for top in tops:
        low = out[-1][-1]
        angle = math.atan2(BELT, top - 0.3)
        slip = math.hypot(BELT, top - 0.3) * np.cos(np.arange(-angle, math.pi + angle, DT))
        out += [low + BELT * np.arange(0, (top - low) / BELT, DT), 0.3 + slip]
    return np.concatenate(out)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("broken", "glitch"), [(False, 0.0), (True, 0.0), (False, 1.0)])
def test_a_window_ends_before_the_next_event_rides_higher_than_its_own_broke_away(
    sign: int, broken: bool, glitch: float
) -> None:
    """
    Its own static friction would have let go there; where a stick is broken, its longest part may be beyond.

    A glitch that nothing has found is no force that was borne.
    """
    x = uneven([1.2, 0.45] * 10)
    lows = [i for i in range(50, len(x) - 50) if x[i] == max(x[i - 50 : i + 50]) < 0.55]
    for i in lows if broken else ():
        there = i + 50 + int(np.argmax(x[i + 50 :] > 0.5))
        x[there:] -= 0.5 * DT * BELT * np.minimum(np.arange(len(x) - there), 6)  # it creeps for a while
    data = run(sign * x, belt_speed=sign * BELT)
    data.readings[np.array(lows) - 20, 0] += sign * glitch
    seen = 0
    for one in stretches([data]):
        inside = [i for i in lows if one.start <= i < one.stop]
        if inside:
            seen += 1
            assert sign * data.readings[one.stop - 1, 0] < x[inside[0]]
    assert seen > 5


def test_of_a_long_stick_the_middle_is_in_no_window() -> None:
    data = run(stick_slip(1.0, 60.0, cycles=14))
    every = stretches([data])
    assert len(every) >= POLICY.fewest_windows
    for one, other in zip(every, every[1:], strict=False):
        assert data.t[one.stop] - data.t[one.start] < 2 * 15 + 2 * math.pi
        assert data.t[other.start] - data.t[one.stop] > 60 - 2 * 15 - 2
        assert 60 - 15 - 2 < other.dwell < 60 - 15 + 2
        assert 58 < other.rest < 62
