"""How likely readings are under an ensemble, against scipy's normal distribution."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from stickslip.likelihoods.foretold import deviance


def test_it_is_the_density_of_the_members_spread_and_the_noise() -> None:
    rng = np.random.default_rng(1)
    members, noise, readings = (
        rng.standard_normal((9, 20, 2)),
        np.array([0.3, 0.5]),
        rng.standard_normal((20, 2)),
    )
    read = rng.random((20, 2)) > 0.2
    flat = members[:, read]
    spread = np.cov(flat, rowvar=False) + np.diag(np.broadcast_to(noise**2, (20, 2))[read])
    exact = -2 * multivariate_normal(flat.mean(0), spread).logpdf(readings[read])
    assert deviance(members, noise, readings, read) == pytest.approx(
        exact - read.sum() * np.log(2 * np.pi), rel=1e-9
    )


def test_a_slip_that_comes_when_others_might_is_likelier_than_one_of_another_shape() -> None:
    t, rng = np.linspace(0, 1, 80)[:, None], np.random.default_rng(2)
    members = np.array([np.tanh((t - 0.5 - late) / 0.05) for late in 0.03 * rng.standard_normal(60)])
    all_read, noise = np.ones((80, 1), dtype=bool), np.array([0.02])
    late = np.tanh((t - 0.53) / 0.05)
    slow = np.tanh((t - 0.5) / 0.08)
    off = [float(((one - members.mean(0)) ** 2).sum()) for one in (late, slow)]
    assert off[0] > off[1]  # an error alone would have it the other way
    assert deviance(members, noise, late, all_read) < deviance(members, noise, slow, all_read) - 10


def test_a_forecast_that_goes_astray_counts_by_its_logarithm() -> None:
    """One of thirteen, 300,000 off, took back two names that made the others 2,000 likelier each."""
    rng = np.random.default_rng(3)
    members, noise = 0.1 * rng.standard_normal((20, 50, 1)), np.array([0.01])
    all_read = np.ones((50, 1), dtype=bool)
    near, far = members[0] + 0.01 * rng.standard_normal((50, 1)), np.full((50, 1), 20.0)
    usual, whole = (deviance(members, noise, one, all_read) for one in (near, far))
    assert deviance(members, noise, near, all_read, 4.0) == usual
    soft = deviance(members, noise, far, all_read, 4.0)
    knee = 4.0 * 50
    # volume is the same: chi-squared beyond the knee turns into the knee's logarithm
    chi = whole - usual
    assert soft - usual < knee * (1 + np.log1p(chi / knee) + 1)
    assert soft - usual < 0.01 * chi
