"""Slips fitted one by one on a belt that runs both ways: one law, each direction from its own runs."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss

RIG = ss.BlockOnBelt(mass=0.0307, stiffness=168.0)
LAW = ss.CoulombFriction(static=0.111, kinetic=0.070, static_plus=0.100, kinetic_plus=0.080)  # N
CHANNELS = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}


def recorded(speed: float, seed: int, t_end: float = 0.8) -> ss.Recording:
    t = np.arange(0.0, t_end, 0.00125)
    run = ss.simulate(
        ss.Model(RIG, friction=LAW), belt_speed=speed, initial=(0, speed), t_end=t_end, t_eval=t
    )
    x = 1e3 * run.x1 + 1e-3 * np.random.default_rng(seed).standard_normal(t.size)
    return ss.load_recording({"t": t, "x1": x}, RIG, channels=CHANNELS, belt_speed=speed, name=f"run_{seed}")


@pytest.fixture(scope="module")
def runs() -> list[ss.Recording]:
    return [recorded(0.012, 1), recorded(-0.012, 2)]


@pytest.mark.study
def test_both_directions_are_found_as_if_each_were_alone(runs: list[ss.Recording]) -> None:
    found = ss.identify(runs, rig=RIG)
    assert found.law.kind == "coulomb"
    for name, one in found.estimates.items():
        assert one.status == "identified"
        assert one.value == pytest.approx(LAW.numbers[name], abs=2e-4)
    ahead, back = (ss.identify(run, rig=RIG) for run in runs)
    for name in ("static", "kinetic"):
        assert found.estimates[name] == ahead.estimates[name]
        assert found.estimates[f"{name}_plus"] == back.estimates[f"{name}_plus"]
    assert None not in found.covered.values()
    assert found.covariance.shape == (4, 4)
    assert found.covariance[0, 2] == 0
    assert found.events is not None
    assert set(found.events.run) == {0.0, 1.0}
    assert not any("never visited" in words for words in found.messages)
    assert [words for words in found.messages if words.startswith("T_plus: ")]


def test_a_direction_with_too_few_slips_is_said_and_counts_as_unseen(runs: list[ss.Recording]) -> None:
    found = ss.identify([recorded(-0.012, 3, t_end=0.2), runs[0]], rig=RIG)
    assert found.estimates["static"].status == "identified"
    assert found.estimates["static_plus"].status == "unidentified"
    assert any(
        words.startswith("belt speeds below 0: ") and "at least 3 are needed" in words
        for words in found.messages
    )
    assert found.events is not None
    assert set(found.events.run) == {1.0}  # its number among all runs
