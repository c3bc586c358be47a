"""A window whose motion grows beyond all bounds has numbers all the same: it is a poor one, and ends no search."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip.likelihoods.mixed import eliminated


@pytest.mark.parametrize("grown", [1e2, 1e8, 1e10, 1e12])
def test_own_numbers_of_a_motion_that_grows_are_found(grown: float) -> None:
    rng = np.random.default_rng(0)
    column = grown ** np.linspace(0, 1, 200)
    # all columns are the one that grows, but for what rounding does not hold; so are the readings
    block = np.array([column * (1 + 1e-9 * rng.standard_normal(200)) for _ in range(6)])
    readings = 0.7 * column
    a = np.vstack([block, readings])
    root, seen = eliminated((a @ a.T)[None], 1, 2)
    own = root[0].T @ seen[0, :, 1]
    np.testing.assert_allclose(own @ block[1:], readings, rtol=1e-6, atol=1e-6 * grown)
