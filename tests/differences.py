"""Derivatives of windows against differences of their residuals."""

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.belt_windows import BeltWindows

STEP, NEAR = 1e-6, 1e-4


def held_against_differences(windows: BeltWindows, shared: NDArray[np.float64], name: str) -> None:
    """Ask that every column of the second window is a difference of its readings."""
    own, begins = windows.first(), windows.begins
    own[:, begins:] = 0.01 * np.random.default_rng(0).normal(size=own[:, begins:].shape)
    # a belt that wanders is seen to first order: what other numbers do to that is of the second
    own[:, begins:][:, windows.kinetic.stop : -1] = 0.0
    here = windows.blocks(shared, own)[1]
    assert here is not None
    for j in range(len(shared) + own.shape[1]):
        sides = []
        for sign in (1, -1):
            s, o = shared.copy(), own.copy()
            if j < len(shared):
                s[j] += sign * STEP
            else:
                o[:, j - len(shared)] += sign * STEP
            block = windows.blocks(s, o, shared=(), local=False)[1]
            assert block is not None
            sides.append(block[:, :, -1])
        found = -(sides[0] - sides[1]) / (2 * STEP)
        scale = max(float(np.abs(found).max()), 1.0)
        assert np.abs(found - here[:, :, j]).max() < NEAR * scale, (name, j)
