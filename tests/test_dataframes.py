"""Data frames of what a simulation and an identification give."""

from __future__ import annotations

import numpy as np
import pandas as pd

import stickslip as ss

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)


def test_a_trajectory_is_a_row_for_each_time() -> None:
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=[ss.effect("friction_memory", tau=0.3)])
    run = ss.simulate(model, belt_speed=0.1, t_end=20.0)
    table = run.to_dataframe()
    assert list(table) == ["t", "x1", "x2", "y1", "y2", "mode", "w"]
    np.testing.assert_array_equal(table[["x1", "x2", "y1", "y2"]], run.state)
    np.testing.assert_array_equal(table["w"], run.hidden["w"])
    assert set(table["mode"]) == {0, -1}
    assert len(table) == len(run.t) > 20


def test_a_block_alone_has_two_states() -> None:
    run = ss.simulate(
        ss.Model(ss.BlockOnBelt(), friction=ss.PaperFriction()),
        belt_speed=0.1,
        t_end=5.0,
        t_eval=[0.0, 1.0, 5.0],
    )
    assert list(run.to_dataframe()) == ["t", "x1", "x2", "mode"]
    assert run.to_dataframe()["t"].tolist() == [0.0, 1.0, 5.0]


def test_what_is_simulated_is_identified_without_a_file() -> None:
    rig, law = ss.BlockOnBelt(mass=1.0, stiffness=1.0), ss.CoulombFriction(static=0.4, kinetic=0.25)
    t = np.arange(0.0, 60.0, 0.05)
    table = ss.simulate(
        ss.Model(rig, friction=law), belt_speed=0.1, initial=(0.0, 0.1), t_end=60.0, t_eval=t
    ).to_dataframe()
    table["x1"] += 1e-4 * np.random.default_rng(1).standard_normal(len(t))
    start = ss.CoulombFriction(static=0.5, kinetic=0.2)
    found = ss.identify(ss.load_recording(table, rig, belt_speed=0.1), rig=rig, friction=start)
    numbers = found.to_dataframe()
    assert isinstance(numbers, pd.DataFrame)
    assert list(numbers.index) == list(found.estimates)
    for name, one in found.estimates.items():
        assert numbers.loc[name].to_dict() == vars(one)
    for name, true in (("static", 0.4), ("kinetic", 0.25)):
        assert numbers.loc[name, "low"] < true < numbers.loc[name, "high"]
