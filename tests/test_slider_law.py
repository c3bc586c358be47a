"""The law beside an effect that was found: its intervals hold what is doubtful of the effect, too."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd
import pytest

import stickslip as ss
from slider import coulomb_record
from stickslip.discovery.result import Interval
from stickslip.discovery.slider.choose import Choice, choose
from stickslip.discovery.slider.law import law_beside
from stickslip.discovery.slider.numbers import parameters
from stickslip.fitted.block_events.table import Measured, measure, prepare

RIG = ss.BlockOnBelt(mass=1, stiffness=1)
STATIC, KINETIC, GAIN = 1.0, 0.5, 0.1


def drawn(seed: int) -> list[ss.Recording]:
    """Three runs in closed form: friction scatters, set-points are 1 % off, the sensor reads 10 % too much."""
    generator, out = np.random.default_rng(seed), []
    for speed in (0.05, 0.09, 0.15):
        true = speed * (1 + 0.01 * generator.standard_normal())
        static = STATIC + 0.02 * generator.standard_normal(24)
        kinetic = KINETIC + 0.01 * generator.standard_normal(24)
        t, x, _, _ = coulomb_record(static, kinetic, true, 0.03)
        read = (1 + GAIN) * x + 5e-4 * generator.standard_normal(len(t))
        frame = pd.DataFrame({"t": t, "x1": read})
        out.append(ss.load_recording(frame, RIG, belt_speed=speed, name=f"run at {speed}"))
    return out


@cache
def chosen(seed: int) -> tuple[Choice, tuple[Measured, ...]]:
    runs = tuple(measure(prepare(one)) for one in drawn(seed))
    choice = choose(runs, 0, lambda _: None, 5)
    assert [one.candidate.name for one in choice.chosen] == ["sensor_gain"]
    return choice, runs


def half(one: Interval) -> float:
    assert one.low is not None
    assert one.high is not None
    return 0.5 * (one.high - one.low)


@pytest.mark.study
def test_a_doubtful_gain_makes_the_law_as_doubtful() -> None:
    """Forces read with a gain are its inverse times what they were: relative doubts add up in squares."""
    choice, runs = chosen(0)
    _, beside = law_beside(choice.chosen, choice, runs)
    sure = [type(one)(one.candidate, one.theta, 1e-12 * one.covariance, one.gain) for one in choice.chosen]
    _, held = law_beside(sure, choice, runs)
    e = parameters(choice.chosen[0], choice)["e"]
    share = half(e) / (1 + e.value)
    assert share > 0.005
    for name in ("static", "kinetic"):
        assert beside[name].value == held[name].value
        expected = np.hypot(half(held[name]), share * beside[name].value)
        assert half(beside[name]) == pytest.approx(expected, rel=0.02)


@pytest.mark.study
def test_the_intervals_are_as_wide_as_the_errors() -> None:
    """With the gain held they were a third as wide: of 40 intervals half held the truth."""
    z = []
    for seed in range(4):
        choice, runs = chosen(seed)
        law = law_beside(choice.chosen, choice, runs)[1]
        for name, truth in (("static", STATIC), ("kinetic", KINETIC)):
            z.append((law[name].value - truth) / (half(law[name]) / 1.96))
    assert np.mean(np.square(z)) < 2.5


def test_nothing_found_adds_nothing() -> None:
    choice, runs = chosen(0)
    law, alone = law_beside((), choice, runs)
    assert law.static == pytest.approx((1 + GAIN) * STATIC, rel=0.02)
    assert half(alone["static"]) < 0.01
