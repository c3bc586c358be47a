"""A belt that droops by a third and more under a block: where windows begin, and what is found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from recorded import recording
from stickslip.fitted.data import prepare
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.block_windows import BlockSensors
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.stretches import stretches, timed
from stickslip.simulated.states import AT

BENCH = Path(__file__).resolve().parents[1] / "bench" / "discovery"
SPEED, END, STEP = 0.2, 80.0, 0.02


@pytest.mark.parametrize(("k", "tau"), [(0.1, 1.2), (0.12, 3.0), (0.15, 1.6)])
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_a_window_begins_with_the_droop_there_is(
    k: float, tau: float, damping: float, tmp_path: Path
) -> None:
    """The load of a stick was taken to grow as fast as under an even belt: droops were off by a fifth."""
    droop = ss.effect("belt_load_droop", k=k, tau=tau)
    rig = ss.BlockOnBelt(damping=damping)
    model = ss.Model(rig, friction=ss.CoulombFriction(static=1, kinetic=0.5), effects=[droop])
    t = np.arange(0, END, STEP)
    true = ss.simulate(model, belt_speed=SPEED, initial=(0, SPEED), t_end=END, t_eval=t)
    run = prepare([recording(tmp_path, rig, t, true.state[:, 0], None, SPEED, "run", 1e-6)])[0]
    windows = BeltWindows(
        model, [run], cut := stretches([run]), [], Declared(), BlockSensors(("gain.x1",), None)
    )
    own = np.zeros((len(cut), windows.own))
    own[:, 0] = true.state[[one.start for one in cut], 0]
    for _ in range(3):  # when a stick began is told by the motion before
        motions = windows.motions(windows.start, own)
        windows = BeltWindows(model, [run], cut := timed(cut, motions), [], Declared(), windows.sensors)
    motions = windows.motions(windows.start, own)
    late = [i for i, one in enumerate(cut) if t[one.start] > 8 * tau]
    assert len(late) > 2
    found = np.array([motions[i].state[0, AT["b"]] for i in late])
    there = true.hidden["b"][[cut[i].start for i in late]]
    assert np.abs(there).max() > 0.1 * SPEED
    np.testing.assert_allclose(found, there, rtol=0.01)


@pytest.mark.study
def test_constants_that_did_a_droop_s_work_are_put_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mass was named that was 36 % off: all forces and the gain had moved together, and stayed there."""
    pytest.importorskip("numba")
    monkeypatch.syspath_prepend(str(BENCH))
    import block_draw
    import generate

    rng = np.random.default_rng(41002)
    counts = {"single": 2, "none": 0, "pairs": 0, "unlisted": 0, "odd": 0}
    _, names, conditions = generate.plan(rng, counts, (), 1.0, "block")[9]
    assert names == ["belt_load_droop"]
    drawn = block_draw.draw_case(np.random.default_rng([41002, 9]), names, conditions)
    block_draw.write_case(tmp_path / "case", drawn)
    found = ss.discover(ss.load_case(tmp_path / "case" / "rig.toml"))
    assert [one.name for one in found.effects] == ["belt_load_droop"]
    (truth,) = block_draw.answer_of("case", "single", drawn)["effects"]
    for name, size in truth["parameters"].items():
        at = found.effects[0].parameters[name]
        assert at.value == pytest.approx(size, rel=0.06)
