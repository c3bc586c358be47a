"""Windows held out: predicted from the others by the same linear model, against fits that have not seen them."""

import numpy as np
import pytest

import stickslip as ss
from scattering import case
from stickslip.declared.effect import Effect
from stickslip.discovery.laboratory.hypothesis import Bench, Term
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.fitted.data import prepare
from stickslip.likelihoods.fit import fitted
from stickslip.likelihoods.fit_state import Fit, begin
from stickslip.likelihoods.held_out import held_out

DAMPING = ss.effect("block_viscous_damping", c=1.0)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    read = ss.load_case(case(tmp_path_factory.mktemp("held"), (DAMPING,), 0.015, 0.005, 11))
    return bench_of(read, prepare(read.train))


def fit_of(bench: Bench, *effects: Effect) -> Fit:
    return fitted(begin(bench.windows(tuple(Term(one) for one in effects))), bench.policy)


def error(fit: Fit, beside: Fit) -> float:
    """Error of a fit on windows held out, over that of another, at the same scatter."""
    return float(
        np.sqrt(held_out(fit, fit.population, fit.noise) / held_out(beside, fit.population, fit.noise))
    )


@pytest.mark.study
def test_an_effect_that_acts_lowers_the_error_on_windows_held_out(bench: Bench) -> None:
    """Friction of a window's own takes much of a misfit: it must cost, or the null leaves as little."""
    null = fit_of(bench)
    assert error(fit_of(bench, DAMPING), null) < 0.97
    assert error(fit_of(bench, ss.effect("spring_cubic_k2", k=0.1)), null) > 0.99


def test_windows_held_out_leave_more_than_windows_that_were_fitted(bench: Bench) -> None:
    """One shared number more than the others can tell costs where it was not fitted: n + k, not n - k."""
    fit = fit_of(bench, DAMPING)
    assert fit.solution is not None
    seen = float((fit.solution.misfit / fit.noise).sum() + (fit.solution.white**2).sum())
    numbers = len(fit.at)
    assert seen < held_out(fit, fit.population, fit.noise) < seen + 4 * numbers
