"""Windows of the rig of (2.1) from mid-stick to mid-stick, with numbers of their own."""

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from stickslip.fitted.data import Data
from stickslip.likelihoods.rig_windows import RigWindows
from stickslip.likelihoods.stretches import stretches

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
MODEL = ss.Model(RIG, friction=ss.PaperFriction(), effects=())
BELT, NOISE = 0.1, 1e-3


@pytest.fixture(scope="module")
def windows() -> RigWindows:
    """A run that the model made, without noise."""
    t = np.arange(0.0, 60.0, 0.02)
    run = ss.simulate(MODEL, belt_speed=BELT, initial=(0.1, 0.1, 0, 0), t_end=t[-1], t_eval=t)
    readings = run.state[:, [0, 2]]
    v = run.state[:, 1]
    slips = [a + int(np.argmax(np.abs(v[a:b] - BELT))) for a, b in _slipping(run.mode)]
    weight = np.full_like(readings, 1 / NOISE)
    noise, held = np.full(2, NOISE), np.zeros_like(readings, dtype=bool)
    cycle = float(np.median(np.diff(t[slips])))
    data = [Data("run", "train", BELT, t, readings, weight, noise, v, np.array(slips), cycle, held)]
    return RigWindows(MODEL, data, stretches(data), ("T_s_minus", "T_min_minus", "alpha1", "eta1"))


def _slipping(mode: NDArray[np.int8]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (mode != 0).astype(int), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def test_the_true_model_leaves_nothing(windows: RigWindows) -> None:
    assert len(windows.stretches) >= 3
    own = windows.start()
    for row, w in zip(own, windows.stretches, strict=True):
        row[:2] = windows.data[0].readings[w.start]
    for block in windows.blocks(windows.declared(), own):
        assert block is not None
        assert np.median(np.abs(block[:, :, -1])) < 3.0


def test_derivatives_are_those_of_differences(windows: RigWindows) -> None:
    shared, own, step = windows.declared(), windows.start(), 1e-6
    here = windows.blocks(shared, own)[1]
    assert here is not None
    columns = len(shared) + own.shape[1]
    for j in range(columns):
        sides = []
        for sign in (1, -1):
            s, o = shared.copy(), own.copy()
            if j < len(shared):
                s[j] += sign * step
            else:
                o[:, j - len(shared)] += sign * step
            block = windows.blocks(s, o)[1]
            assert block is not None
            sides.append(block[:, :, -1])
        found = -(sides[0] - sides[1]) / (2 * step)
        scale = max(float(np.abs(found).max()), 1.0)
        assert np.median(np.abs(found - here[:, :, j])) < 2e-3 * scale, j
