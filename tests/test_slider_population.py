"""The covariance of what differs from event to event, against the formula written out."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip.discovery.slider.population import FREE, Block, wander_cost

SIGMA, LENGTH, TAU = 0.3, 4.0, 0.1
RUN = np.repeat([0, 1], [7, 5])
TRAVEL = np.concatenate([np.cumsum(np.linspace(0.5, 2.0, 7)), np.cumsum(np.linspace(1.0, 3.0, 5))])
NOISE = np.linspace(0.01, 0.04, 12)


@pytest.fixture
def level():
    none = np.zeros(12)
    y = np.sin(np.arange(12.0))
    return Block(
        "level", y, NOISE, RUN, RUN, TRAVEL, TRAVEL, none, none, none, none, none, none, none,
        wander=(SIGMA, LENGTH, TAU),
    )  # fmt: skip


def covariance(free):
    """Element by element; runs have nothing in common."""
    C = np.zeros((12, 12))
    for i in range(12):
        for j in range(12):
            if RUN[i] == RUN[j]:
                C[i, j] = SIGMA**2 * np.exp(-abs(TRAVEL[i] - TRAVEL[j]) / LENGTH) + free**2
        C[i, i] += NOISE[i] + TAU**2
    return C


def test_levels_are_whitened_by_the_covariance_with_a_free_mean_of_each_run(level):
    W = level.whitened(np.eye(12))
    np.testing.assert_allclose(W.T @ W, np.linalg.inv(covariance(FREE)), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(level.whitened(level.y), W @ level.y, atol=1e-10)


def test_levels_are_drawn_with_the_covariance_of_their_noise(level):
    root = np.stack([level.drawn(_Unit(i)) for i in range(12)], axis=1)
    np.testing.assert_allclose(root @ root.T, covariance(0.0), atol=1e-9)


def test_the_likelihood_of_a_wander_is_that_of_the_normal_distribution(level):
    C = covariance(FREE)
    expected = level.y @ np.linalg.solve(C, level.y) + np.linalg.slogdet(C)[1]
    assert wander_cost(level, (SIGMA, LENGTH, TAU)) == pytest.approx(expected, rel=1e-7)


class _Unit:
    """A generator whose normal numbers are 1 at one place and 0 elsewhere."""

    def __init__(self, at):
        self.at = at

    def standard_normal(self, n):
        return np.eye(n)[self.at]
