"""The likelihood of windows with random effects, against dense formulas and drawn data."""

import numpy as np
import pytest

from stickslip.likelihoods.mixed import Floats, products, solve
from stickslip.likelihoods.population import curve, factor, level
from stickslip.likelihoods.score import gain
from stickslip.likelihoods.variances import estimate

SHARED, OWN, EFFECTS = 2, 2, 5
PARTS = (
    level("level", range(EFFECTS), EFFECTS),
    curve("curve", range(EFFECTS), EFFECTS, np.linspace(0.0, 1.0, EFFECTS), 0.4),
)
MEAN, PRECISION = np.array([0.1, 0.0]), np.array([4.0, 0.0])


def drawn(
    seed: int, windows: int, sd: tuple[float, float], noise: float = 1.0, readings: int = 30
) -> list[Floats]:
    """Columns [J, S, K, r] of windows whose truth is known."""
    rng = np.random.default_rng(seed)
    root = factor(PARTS, np.array(sd))
    blocks = []
    for _ in range(windows):
        columns = rng.normal(size=(readings, 2, SHARED + OWN + EFFECTS))
        truth = np.concatenate([[0.3, -0.2], rng.normal(size=OWN), root @ rng.normal(size=root.shape[1])])
        r = columns @ truth + np.sqrt(noise) * rng.normal(size=(readings, 2))
        blocks.append(np.concatenate([columns, r[:, :, None]], axis=2))
    return blocks


def dense(blocks: list[Floats], root: Floats, noise: Floats) -> tuple[float, Floats]:
    """Deviance and shared step from the covariance of all readings of each window."""
    normal, pull, total = np.diag(PRECISION), PRECISION * MEAN, PRECISION @ MEAN**2
    for block in blocks:
        flat = block.reshape(-1, block.shape[2])
        j, s = flat[:, :SHARED], flat[:, SHARED : SHARED + OWN]
        k, r = flat[:, SHARED + OWN : -1], flat[:, -1]
        v = np.diag(np.tile(noise, len(block))) + k @ root @ root.T @ k.T
        w = np.linalg.inv(v)
        free = s.T @ w @ s
        w = w - w @ s @ np.linalg.inv(free) @ s.T @ w
        normal, pull, total = normal + j.T @ w @ j, pull + j.T @ w @ r, total + r @ w @ r
        total += np.linalg.slogdet(v)[1] + np.linalg.slogdet(free)[1]
    step = np.linalg.solve(normal, pull)
    return total - pull @ step, step


@pytest.mark.parametrize("sd", [(0.3, 0.2), (0.3, 0.0), (0.0, 0.0)])
def test_the_arrow_gives_the_dense_likelihood(sd: tuple[float, float]) -> None:
    blocks, noise, root = drawn(1, 4, sd), np.array([0.8, 1.3]), factor(PARTS, np.array(sd))
    found = solve(products(blocks, SHARED, OWN), root, noise, MEAN, PRECISION)
    deviance, step = dense(blocks, root, noise)
    assert found.deviance == pytest.approx(deviance, rel=1e-9)
    assert found.shared == pytest.approx(step, rel=1e-8)


def test_no_scatter_gives_the_plain_fit() -> None:
    blocks = drawn(2, 3, (0.0, 0.0))
    found = solve(
        products(blocks, SHARED, OWN), factor(PARTS, np.zeros(2)), np.ones(2), np.zeros(2), np.zeros(2)
    )
    rows = [b.reshape(-1, b.shape[2]) for b in blocks]
    wide = np.zeros((sum(map(len, rows)), SHARED + OWN * len(rows)))
    start = 0
    for w, row in enumerate(rows):
        wide[start : start + len(row), :SHARED] = row[:, :SHARED]
        wide[start : start + len(row), SHARED + OWN * w : SHARED + OWN * (w + 1)] = row[
            :, SHARED : SHARED + OWN
        ]
        start += len(row)
    plain = np.linalg.lstsq(wide, np.concatenate([row[:, -1] for row in rows]), rcond=None)[0]
    assert found.shared == pytest.approx(plain[:SHARED], rel=1e-9)
    assert found.own.ravel() == pytest.approx(plain[SHARED:], rel=1e-8)
    assert not found.effects.any()


def test_a_known_scatter_and_noise_are_recovered() -> None:
    found = estimate(products(drawn(3, 150, (0.5, 0.3), noise=2.0), SHARED, OWN), PARTS, MEAN, PRECISION)
    assert found.sd == pytest.approx([0.5, 0.3], rel=0.2)
    assert found.noise == pytest.approx([2.0, 2.0], rel=0.1)


def test_scatter_that_is_not_there_is_about_nothing() -> None:
    found = estimate(products(drawn(4, 150, (0.5, 0.0)), SHARED, OWN), PARTS, MEAN, PRECISION)
    assert found.sd[0] == pytest.approx(0.5, rel=0.2)
    assert found.sd[1] < 0.05


def test_the_score_is_the_gain_of_a_refit() -> None:
    blocks, noise, root = drawn(5, 6, (0.3, 0.2)), np.ones(2), factor(PARTS, np.array([0.3, 0.2]))
    flat = np.zeros(SHARED)
    said = gain(products(blocks, SHARED, OWN), 1, root, noise, flat, flat)
    step = solve(products(blocks, SHARED, OWN), root, noise, flat, flat).shared
    null = [np.delete(b, 1, axis=2) for b in blocks]
    moved = [n - np.eye(n.shape[2])[-1] * step[1] * b[:, :, 1:2] for n, b in zip(null, blocks, strict=True)]
    before, after = (
        solve(products(b, 1, OWN), root, noise, flat[:1], flat[:1]).deviance for b in (null, moved)
    )
    assert said == pytest.approx(before - after, rel=1e-6)
    assert said > 0
