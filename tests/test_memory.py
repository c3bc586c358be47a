"""How alike neighbouring events are: against dense covariances, and recurrences that are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import toeplitz

from stickslip.likelihoods.memory import GRID, correlation, of_effects


def recurrence(n: int, like: float, rng: np.random.Generator) -> np.ndarray:
    out = rng.standard_normal(n)
    for k in range(1, n):
        out[k] = like * out[k - 1] + np.sqrt(1 - like**2) * out[k]
    return out


def test_it_is_the_restricted_likelihood_of_dense_covariances() -> None:
    rng = np.random.default_rng(0)
    runs = [rng.standard_normal(n) for n in (5, 3, 9)]

    def deviance(like: float) -> float:
        size, square = 0.0, 0.0
        for one in runs:
            inverse = np.linalg.inv(toeplitz(like ** np.arange(len(one))))
            ones = np.ones(len(one))
            off = one - (ones @ inverse @ one) / (ones @ inverse @ ones)
            size += np.log(ones @ inverse @ ones) - np.linalg.slogdet(inverse)[1]
            square += off @ inverse @ off
        return float(size + (sum(map(len, runs)) - len(runs)) * np.log(square))

    dense = np.array([deviance(like) for like in GRID])
    weight = np.exp(-0.5 * (dense - dense.min()))
    mean = weight @ GRID / weight.sum()
    spread = np.sqrt(weight @ (GRID - mean) ** 2 / weight.sum())
    assert correlation(runs) == pytest.approx((mean, spread), rel=1e-9)


@pytest.mark.parametrize("like", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("events", [6, 25])
def test_its_error_covers_what_is_true(like: float, events: int) -> None:
    """Of short runs 0.95 with an error of 0.06 was told where it was 0.3: forecasts were three times too sure."""
    rng = np.random.default_rng(events)
    told = np.array([correlation([recurrence(events, like, rng) for _ in range(6)]) for _ in range(300)])
    assert np.mean(np.abs(told[:, 0] - like) < 1.96 * told[:, 1]) > 0.92
    assert np.mean(told[:, 0]) == pytest.approx(like, abs=0.25 if like == 0 else 0.1)


def test_what_does_not_vary_remembers_nothing() -> None:
    assert correlation([np.ones(9), np.zeros(2)]) == (0.0, 0.0)


def test_each_kind_of_scatter_remembers_as_it_does_itself() -> None:
    rng = np.random.default_rng(3)
    static, kinetic, belt = (recurrence(200, like, rng) for like in (0.0, 0.8, 0.4))
    windows = SimpleNamespace(effects=4, statics=(0,), kinetics=([1, 2],), belt=3, by_run=[np.arange(200)])
    fit = SimpleNamespace(windows=windows, random=np.column_stack([static, kinetic, kinetic, belt]))
    expected, drawn = of_effects(fit, 500, rng)
    assert expected == pytest.approx([0.0, 0.8, 0.8, 0.4], abs=0.15)
    assert np.mean(drawn, axis=0) == pytest.approx(expected, abs=0.05)
    np.testing.assert_array_equal(drawn[:, 1], drawn[:, 2])
    assert abs(np.corrcoef(drawn[:, 0], drawn[:, 1])[0, 1]) < 0.2
