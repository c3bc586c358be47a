"""Hypotheses are held against each other with events that remember: what a fit gains by that, against dense sums."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import multivariate_normal

import stickslip as ss
from scattering import block_case
from stickslip.discovery.laboratory.block_bench import bench_of
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.population import factor
from stickslip.likelihoods.remembered import remembered

SCATTER = 0.02


@pytest.fixture(scope="module", params=[0.0, 0.9])
def fit(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[float, Fit]:
    """A block whose events remember, or do not, under its own law."""
    folder = tmp_path_factory.mktemp("remembered")
    case = ss.load_case(block_case(folder, seed=5, scatter=SCATTER, memory=request.param))
    made = bench_of(case)
    assert made is not None
    bench = made[0]
    return request.param, null(bench.windows(), bench.policy)


def dense(fit: Fit, effects: list[int]) -> float:
    """The fall of -2 log density of what the windows say of a level, its errors known, where events remember."""
    assert fit.linear is not None
    assert fit.solution is not None
    row = factor(fit.population, fit.windows.places)[fit.linear.run][:, effects].mean(axis=1)
    own = fit.solution.inverse[:, fit.linear.own :, fit.linear.own :]
    after, before = np.einsum("wi,wij,wj->w", row, own, row), (row**2).sum(axis=1)
    error = 1 / (1 / after - 1 / before)  # of the readings alone, without the scatter as a prior
    level = (row * fit.solution.white).sum(axis=1) / after * error

    def deviance(x: np.ndarray) -> float:
        out = 0.0
        for one in fit.windows.by_run:
            apart = np.abs(np.subtract.outer(one, one))
            covariance = np.exp(2 * x[0]) * x[1] ** apart + np.diag(error[one])
            out -= 2 * multivariate_normal.logpdf(level[one], cov=covariance)
        return out

    sizes, first = (np.log(1e-4), np.log(0.3)), np.log(SCATTER)
    alone = minimize(lambda x: deviance(np.array([x[0], 0.0])), [first], bounds=[sizes]).fun
    return float(alone - minimize(deviance, [first, 0.5], bounds=[sizes, (0.0, 0.95)]).fun)


def test_the_gain_is_that_of_dense_sums(fit: tuple[float, Fit]) -> None:
    _, made = fit
    every = [*made.windows.kinetics, *([one] for one in made.windows.statics)]
    assert remembered(made) == pytest.approx(sum(dense(made, list(one)) for one in every), abs=0.01)


def test_events_that_remember_gain_and_others_do_not(fit: tuple[float, Fit]) -> None:
    like, made = fit
    count = len(made.own)
    if like:  # of n events remembered by m, in the mean n log 1/(1 - m^2) for either level
        assert remembered(made) > 0.25 * count * np.log(1 / (1 - like**2))
    else:  # chi-squared of one number a level, half of it at its bound
        assert remembered(made) < 10


def test_scatter_that_is_nothing_remembers_nothing(tmp_path: Path) -> None:
    case = ss.load_case(block_case(tmp_path, few=True, seed=1, scatter=0.0))
    made = bench_of(case)
    assert made is not None
    assert remembered(null(made[0].windows(), made[0].policy)) < 6
