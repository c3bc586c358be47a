"""A forecast goes on from stick to stick as one simulation does: no event begins hidden states anew."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from recorded import recording
from stickslip.fitted.data import prepare
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.block_windows import BlockSensors
from stickslip.likelihoods.members import ComingEvents, Members
from stickslip.likelihoods.rig_windows import RigSensors
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.stretches import stretches, timed

BLOCK, SLIDES = ss.BlockOnBelt(), ss.CoulombFriction(static=1, kinetic=0.5)
TWO = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
LAG, DROOP = ss.effect("sensor_lag", tau=0.3), ss.effect("belt_load_droop", k=0.002, tau=1.0)
SLOPE = ss.tabulated("contact", "x1", knots=[-0.5, 0.2, 1.0], values=[0.1, 0.0, -0.1])
EFFECTS: dict[str, list[ss.Effect | ss.Tabulated]] = {
    "nothing": [],
    "a curve like a window's own": [SLOPE],
    "lag": [LAG],
    "droop": [DROOP],
    "memory": [ss.effect("friction_memory", tau=0.3), ss.effect("stribeck_peak", dT=0.3, v_s=0.1)],
    "aging": [ss.effect("static_aging", dT=0.3, tau=1.0)],
    "lag and droop": [LAG, DROOP],
}
END = 80.0


@pytest.mark.parametrize("rig", [BLOCK, TWO], ids=["block", "two degrees"])
@pytest.mark.parametrize("name", EFFECTS)
def test_a_member_without_scatter_is_the_simulation(
    rig: ss.BlockOnBelt | ss.Rig, name: str, tmp_path: Path
) -> None:
    block = isinstance(rig, ss.BlockOnBelt)
    model = ss.Model(rig, friction=SLIDES if block else ss.PaperFriction(), effects=EFFECTS[name])
    speed, start = (0.2, (0, 0.2)) if block else (0.1, (0.1, 0.1, 0, 0))
    t = np.arange(0, END, 0.02)
    true = ss.simulate(model, belt_speed=speed, initial=start, t_end=END, t_eval=t)
    x1 = true.hidden["m"] if "lag" in name else true.state[:, 0]
    y1 = None if block else true.state[:, 2]
    run = prepare([recording(tmp_path, rig, t, x1, y1, speed, "run", 1e-5)])[0]
    cut, sensors = stretches([run]), BlockSensors(("gain.x1",), None) if block else RigSensors()
    windows = BeltWindows(model, [run], cut, [], Declared(), sensors)
    own = np.zeros((len(cut), windows.own))
    begins = [0] if block else [0, 2, 3]
    own[:, : len(begins)] = [true.state[one.start, begins] for one in cut]
    # of the fourth stick from the end, so that four events follow one another
    k = len(cut) - 4
    tail = timed(cut, windows.motions(windows.start, own))[k]
    nothing = np.zeros((1, windows.effects))
    events = ComingEvents(np.zeros((windows.effects, 1)), nothing, nothing, np.ones(1))
    members = Members(windows, windows.start, run, events, tail.rest, np.random.default_rng(0))
    made = members.run(own[[k]], tail, len(t)).readings[0]
    expected = np.column_stack([x1] if y1 is None else [x1, y1])[tail.start :]
    off = np.abs(made - expected).max(axis=0) / np.ptp(expected, axis=0)
    assert off.max() < (
        1e-3 if "droop" in name else 2e-5
    )  # what a belt has carried before is known from readings
