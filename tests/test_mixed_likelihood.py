"""The likelihood of windows with random effects, against dense formulas and drawn data."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from stickslip.likelihoods import belt_waves
from stickslip.likelihoods.mixed import Floats, beside_bounds, products, solve, taken, within
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.population import Population, factor
from stickslip.likelihoods.shared import Declared, Prior, SharedNumber
from stickslip.likelihoods.variances import Deviance, estimate

SHARED, OWN, KNOTS = 2, 2, 4
EFFECTS = 2 * KNOTS + 2
PLACES = [np.vstack([np.linspace(0.0, 1.0, KNOTS), belt_waves.root(6.0, KNOTS, (0.3, 2.5))])]
SCATTER = Population(level=0.3, curve=0.2, length=0.4, static=0.25, belt=0.1)
MEAN, PRECISION = np.array([0.1, 0.0]), np.array([[4.0, 1.0], [1.0, 2.0]])
FLAT = np.zeros((SHARED, SHARED))


def drawn(
    seed: int, windows: int, scatter: Population, noise: float = 1.0, readings: int = 30
) -> tuple[list[Floats | None], Floats]:
    """Columns [J, S, K, r] of windows whose truth is known, and where they are linearised."""
    rng = np.random.default_rng(seed)
    root = factor(scatter, PLACES)[0]
    blocks: list[Floats | None] = []
    at = 0.1 * rng.normal(size=(windows, EFFECTS))
    for w in range(windows):
        columns = rng.normal(size=(readings, 2, SHARED + OWN + EFFECTS))
        truth = np.concatenate(
            [[0.3, -0.2], rng.normal(size=OWN), root @ rng.normal(size=root.shape[1]) - at[w]]
        )
        r = columns @ truth + np.sqrt(noise) * rng.normal(size=(readings, 2))
        blocks.append(np.concatenate([columns, r[:, :, None]], axis=2))
    return blocks, at


def dense(blocks: list[Floats | None], at: Floats, root: Floats, noise: Floats) -> tuple[float, Floats]:
    """Deviance and shared step from the covariance of all readings of each window."""
    normal, pull, total = PRECISION.copy(), PRECISION @ MEAN, float(MEAN @ PRECISION @ MEAN)
    for block, here in zip(blocks, at, strict=True):
        assert block is not None
        flat = block.reshape(-1, block.shape[2])
        j, s = flat[:, :SHARED], flat[:, SHARED : SHARED + OWN]
        k = flat[:, SHARED + OWN : -1]
        r = flat[:, -1] + k @ here
        v = np.diag(np.tile(noise, len(block))) + k @ root @ root.T @ k.T
        w = np.linalg.inv(v)
        free = s.T @ w @ s
        w = w - w @ s @ np.linalg.inv(free) @ s.T @ w
        normal, pull, total = normal + j.T @ w @ j, pull + j.T @ w @ r, total + r @ w @ r
        total += np.linalg.slogdet(v)[1] + np.linalg.slogdet(free)[1]
    step = np.linalg.solve(normal, pull)
    return total - pull @ step, step


@pytest.mark.parametrize("scatter", [SCATTER, SCATTER.without()])
def test_the_arrow_gives_the_dense_likelihood(scatter: Population) -> None:
    blocks, at = drawn(1, 4, scatter)
    noise, root = np.array([0.8, 1.3]), factor(scatter, PLACES)
    found = solve(products(blocks, [0] * 4, SHARED, OWN, 2), root, noise, MEAN, PRECISION, at)
    deviance, step = dense(blocks, at, root[0], noise)
    assert found.deviance == pytest.approx(deviance, rel=1e-7)
    assert found.shared == pytest.approx(step, rel=1e-6)


def test_a_number_at_its_bound_leaves_the_others_at_their_best() -> None:
    """As if it had been held there from the start; what is clipped afterwards is worse."""
    blocks, at = drawn(1, 4, SCATTER)
    noise, root = np.array([0.8, 1.3]), factor(SCATTER, PLACES)
    windows = products(blocks, [0] * 4, SHARED, OWN, 2)
    free = solve(windows, root, noise, MEAN, PRECISION, at)
    end = np.full(SHARED, np.inf)
    low = np.array([free.shared[0] + 0.2, -np.inf])
    found = solve(windows, root, noise, MEAN, PRECISION, at, bounds=(low, end))
    assert found.shared[0] == pytest.approx(low[0])
    held = PRECISION + np.diag([1e9, 0.0])
    mean = np.linalg.solve(held, PRECISION @ MEAN + np.array([1e9 * low[0], 0.0]))
    there = solve(windows, root, noise, mean, held, at)
    assert found.shared == pytest.approx(there.shared, rel=1e-5)
    assert found.own == pytest.approx(there.own, abs=1e-5)
    assert there.covariance[1, 1] < found.covariance[1, 1] < free.covariance[1, 1]
    assert found.deviance > free.deviance
    wide = solve(windows, root, noise, MEAN, PRECISION, at, bounds=(-end, end))
    assert wide.deviance == free.deviance


@pytest.mark.parametrize("beyond", [0.0, 0.3, 1.0])
def test_beside_a_bound_the_others_are_as_uncertain_as_what_it_holds(beyond: float) -> None:
    """A Gaussian cut off at the bound, drawn: its mean squares from the best place within."""
    rng = np.random.default_rng(3)
    columns = rng.standard_normal((40, 3))
    columns[:, 2] = 0.9 * columns[:, 0] + 0.3 * columns[:, 2]
    products_ = columns.T @ columns
    middle = np.array([1.0, 2.0, -beyond])
    end = np.full(3, np.inf)
    step, held = within(products_, products_ @ middle, (np.array([-np.inf, -np.inf, 0.0]), end))
    known = beside_bounds(products_, products_ @ middle, step, held)
    draws = rng.multivariate_normal(middle, np.linalg.inv(products_), 2_000_000)
    off = draws[draws[:, 2] > 0] - step
    sizes = np.sqrt(np.diag(known))
    assert known / np.outer(sizes, sizes) == pytest.approx(
        off.T @ off / len(off) / np.outer(sizes, sizes), abs=0.02
    )


def test_a_number_that_is_driven_against_its_bound_is_there() -> None:
    normal = np.array([[2.0, 1.0], [1.0, 3.0]])
    for far in (49.0, 51.0, 1e6):  # on both sides of where the tail is taken as an exponential
        pull = np.array([0.0, -far])
        step, held = within(normal, pull, (np.array([-np.inf, 0.0]), np.full(2, np.inf)))
        known = beside_bounds(normal, pull, step, held)
        assert known[1, 1] == pytest.approx(2 / far**2, rel=0.01)
        assert known[0, 0] == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("seed", range(8))
def test_a_number_that_the_windows_explain_whole_does_not_spoil_the_others(seed: int) -> None:
    """What rounding left of its own product was less than nothing, and the search of the tutorial ended in nan."""
    blocks, at = drawn(seed, 4, SCATTER)
    for block in blocks:
        assert block is not None
        block[:, :, SHARED + OWN] *= 1e10
        block[:, :, 0] = 3.0 * block[:, :, SHARED + OWN]
    noise, root = np.ones(2), factor(SCATTER, PLACES)
    windows = products(blocks, [0] * 4, SHARED, OWN, 2)
    alone = solve(windows, root, noise, np.zeros(SHARED), np.diag([1e12, 0.0]), at)
    bounds = (np.array([-1e-3, alone.shared[1] - 0.5]), np.array([1e-3, alone.shared[1] - 0.1]))
    found = solve(windows, root, noise, np.zeros(SHARED), FLAT, at, bounds=bounds)
    assert found.shared[1] == pytest.approx(bounds[1][1])
    assert abs(found.shared[0]) <= 1e-3
    assert np.isfinite(found.deviance)


def test_what_little_the_windows_leave_of_a_number_is_not_lost_in_rounding() -> None:
    """Readings 100,000 times their noise, of which windows' own numbers explain all but the last millionth."""
    blocks, at = drawn(8, 3, SCATTER, noise=1e-10)
    for block in blocks:
        assert block is not None
        local = block[:, :, SHARED:-1]
        block[:, :, :SHARED] = local[:, :, 2:4] + local[:, :, :2] + 1e-5 * block[:, :, :SHARED]
    noise, root = np.full(2, 1e-10), factor(SCATTER, PLACES)
    windows = products(blocks, [0] * 3, SHARED, OWN, 2)
    found = solve(windows, root, noise, MEAN, PRECISION, at)
    exact = np.vectorize(Fraction, otypes=[object])
    left = exact(PRECISION)
    turn = np.eye(SHARED + OWN + EFFECTS, SHARED + OWN + root.shape[2])
    turn[SHARED + OWN :, SHARED + OWN :] = root[0]
    for gram in windows.gram.sum(axis=1):
        whole = exact(turn).T @ exact(gram[:-1, :-1]) @ exact(turn) / Fraction(1e-10)
        states, effects = range(SHARED, SHARED + OWN), range(SHARED + OWN, len(whole))
        whole[states, states] *= 1 + Fraction(1e-9)
        whole[effects, effects] += 1
        for last in reversed(range(SHARED, len(whole))):  # eliminated one by one
            whole = whole[:last, :last] - np.outer(whole[:last, last], whole[last, :last]) / whole[last, last]
        left = left + whole
    (a, b), (_, d) = left
    covariance = np.array([[d, -b], [-b, a]]) / (a * d - b * b)
    assert found.covariance == pytest.approx(covariance.astype(float), rel=1e-4)


def test_a_window_that_failed_counts_for_nothing() -> None:
    blocks, at = drawn(2, 5, SCATTER)
    noise, root = np.ones(2), factor(SCATTER, PLACES)
    less = solve(products(blocks[:4], [0] * 4, SHARED, OWN, 2), root, noise, MEAN, PRECISION, at[:4])
    failed = solve(products([*blocks[:4], None], [0] * 5, SHARED, OWN, 2), root, noise, MEAN, PRECISION, at)
    assert failed.shared == pytest.approx(less.shared, rel=1e-9)


def test_the_slopes_of_the_deviance_are_those_of_differences() -> None:
    blocks, at = drawn(3, 12, SCATTER)
    windows = products(blocks, [0] * 12, SHARED, OWN, 2)

    def deviance(x: Floats) -> float:
        scatter = SCATTER.moved(x[:5])
        return solve(windows, factor(scatter, PLACES), np.exp(x[5:]), MEAN, PRECISION, at).deviance

    x = np.concatenate([SCATTER.coordinates() + 0.2, [0.1, -0.2]])
    free = Deviance(windows, PLACES, (MEAN, PRECISION), at, SCATTER, x[:5], np.full(5, np.inf))
    value, slope = free(x)
    assert value == pytest.approx(deviance(x), rel=1e-12)
    for i in range(len(x)):
        step = np.zeros(len(x))
        step[i] = 1e-5
        said = (deviance(x + step) - deviance(x - step)) / 2e-5
        assert slope[i] == pytest.approx(said, rel=1e-4, abs=1e-4), i


def test_a_known_scatter_and_noise_are_recovered() -> None:
    scatter = Population(level=0.3, curve=0.2, length=0.4, static=0.25, belt=0.3)
    blocks, at = drawn(4, 200, scatter, noise=2.0)
    windows = products(blocks, [0] * 200, SHARED, OWN, 2)
    wild = replace(POLICY, wildest_belt=1.0)
    found = estimate(windows, PLACES, SCATTER, np.ones(2), (MEAN, PRECISION), at, wild, 100)
    assert found.population.level == pytest.approx(0.3, rel=0.25)
    assert found.population.static == pytest.approx(0.25, rel=0.25)
    assert found.population.belt == pytest.approx(0.3, rel=0.25)
    assert found.noise == pytest.approx([2.0, 2.0], rel=0.1)
    # a belt wilder than belts are is no scatter: it is left to what acts
    tame = estimate(windows, PLACES, SCATTER, np.ones(2), (MEAN, PRECISION), at, POLICY, 100)
    assert tame.population.belt == pytest.approx(POLICY.wildest_belt)


def test_scatter_that_is_not_there_is_nothing() -> None:
    blocks, at = drawn(5, 200, SCATTER.without())
    windows = products(blocks, [0] * 200, SHARED, OWN, 2)
    found = estimate(windows, PLACES, SCATTER, np.ones(2), (MEAN, PRECISION), at, POLICY, 100)
    assert max(found.population.level, found.population.static, found.population.belt) < 0.05


def test_own_numbers_take_what_they_are_worth() -> None:
    blocks, at = drawn(6, 10, SCATTER.without())
    windows = products(blocks, [0] * 10, SHARED, OWN, 2)
    root = factor(SCATTER.without(), PLACES)
    found = solve(windows, root, np.ones(2), MEAN, PRECISION, at)
    assert taken(windows, root, found, np.ones(2)).sum() == pytest.approx(10 * OWN, rel=1e-6)


def test_constants_that_follow_from_one_another_are_known_together() -> None:
    numbers = [
        SharedNumber("a", 0.0, 0.0, np.inf),
        SharedNumber("law", 0.0, 1.0, 0.5),
        SharedNumber("b", 0.0, 0.0, np.inf),
    ]
    covariance = np.array([[0.04, 0.03], [0.03, 0.09]])
    prior = Prior(numbers, Declared(("a", "b"), covariance), tail=1e9)
    away, precision = prior.at(np.zeros(3))
    assert away == pytest.approx([0.0, 1.0, 0.0])
    assert precision[np.ix_([0, 2], [0, 2])] == pytest.approx(np.linalg.inv(covariance), rel=1e-6)
    assert precision[1, 1] == pytest.approx(4.0)
    at = np.array([0.1, 0.0, -0.2])
    expected = at[[0, 2]] @ np.linalg.inv(covariance) @ at[[0, 2]] + 4.0
    assert prior.penalty(at) == pytest.approx(expected, rel=1e-5)


def test_a_long_tail_lets_a_constant_that_is_far_off_go() -> None:
    numbers = [SharedNumber("a", 0.0, 0.0, np.inf)]
    prior = Prior(numbers, Declared(("a",), np.array([[1.0]])), tail=4.0)
    near, far = (prior.at(np.array([x]))[1][0, 0] for x in (0.1, 10.0))
    assert far < 0.1 * near


def test_what_tails_forgive_is_what_a_gaussian_would_charge_beyond_them() -> None:
    numbers = [
        SharedNumber("a", 0.0, 0.0, np.inf),
        SharedNumber("law", 0.0, 1.0, 0.5),
        SharedNumber("b", 0.0, 0.0, np.inf),
    ]
    declared = Declared(("a", "b"), np.array([[0.04, 0.03], [0.03, 0.09]]))
    tails, strict = (Prior(numbers, declared, tail) for tail in (4.0, 1e9))
    for at in (np.zeros(3), np.array([0.1, 0.3, -0.2]), np.array([2.0, 0.0, -1.0])):
        assert tails.forgiven(at) == pytest.approx(strict.penalty(at) - tails.penalty(at), rel=1e-5, abs=1e-9)
