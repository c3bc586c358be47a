"""A curve fitted beside law, constants and scatter: a block on a curved spring, all of whose runs pull one way."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from scattering import STIFFNESS, block_case
from stickslip.discovery.laboratory import block
from stickslip.discovery.laboratory import proven as proving
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.hypothesis import Term, terms_at
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.proven import proven
from stickslip.discovery.laboratory.trials import Trial
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.scaled import ALPHA

CURVED = 25.0 * STIFFNESS  # N/m^2
FULL = 117.0  # what the curve gains, all numbers at their best


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> BeltBench:
    x = np.linspace(-0.01, 0.03, 15)
    acts = ss.tabulated("block", "x1", x, -CURVED * x**2)
    folder = tmp_path_factory.mktemp("curved")
    made = block.bench_of(ss.load_case(block_case(folder, (acts,), few=True, seed=3, scatter=0.01)))
    assert made is not None
    return made[0]


def alone(bench: BeltBench, *terms: Term) -> Trial:
    fit = null(bench.windows(terms), bench.policy, twice=True)
    return Trial(terms_at(terms, fit.windows, fit.at), fit)


def in_x1(bench: BeltBench, base: Trial) -> ScoredCurve:
    every = bench.curves(base.fit, base.terms)
    return next(one for one in every if (one.where, one.variable) == ("block", "x1"))


@pytest.fixture(scope="module")
def base(bench: BeltBench) -> Trial:
    return alone(bench)


def test_a_curve_gives_the_mass_back_what_it_had_taken(bench: BeltBench, base: Trial) -> None:
    """A mass with long tails went to 10.8 of 16, and the curve beside it rose where the true one falls."""
    assert base.fit.values()["mass"] < 0.9 * ALPHA
    found, after = proven(bench, base, in_x1(bench, base))
    assert found.gain > FULL - 5.0
    assert after.fit.values()["mass"] == pytest.approx(ALPHA, rel=0.03)
    assert (np.diff(found.value) < 0).all()


def test_a_curve_of_the_sliding_speed_is_of_that(bench: BeltBench, base: Trial) -> None:
    """Its knots were speeds of the block, the belt's left out."""
    sliding, speed = (
        next(one for one in bench.curves(base.fit) if (one.where, one.variable) == asked)
        for asked in (("contact", "v_w"), ("block", "x2"))
    )
    assert (sliding.x < 0).all()
    assert (speed.x > 0).any()


def test_names_at_a_curves_place_stay_where_they_are(bench: BeltBench) -> None:
    """A cubic spring and a curve in x1 ran away from each other, and the curve lost thousands."""
    named = alone(bench, Term(ss.effect("spring_cubic_k1", k=1.0)))
    found, after = proven(bench, named, in_x1(bench, named))
    assert found.gain > 0.0
    size = named.fit.values()["spring_cubic_k1.k"]
    assert after.fit.values()["spring_cubic_k1.k"] == pytest.approx(size, abs=1e-6)


def test_a_curve_is_fitted_from_the_declared_constants_too(
    bench: BeltBench, base: Trial, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A block that was 14 standard uncertainties too heavy held a quadratic spring's curve at nothing."""
    curve = in_x1(bench, base)
    _, after = proven(bench, base, curve)
    begun: list[float] = []

    def held(fit: Fit, *_: object, **__: object) -> Fit:
        begun.append(fit.values()["mass"])
        return replace(after.fit, deviance=1.0) if fit.values()["mass"] == pytest.approx(ALPHA) else fit

    monkeypatch.setattr(proving, "fitted", held)
    _, kept = proven(bench, base, curve)
    assert begun == pytest.approx([base.fit.values()["mass"], ALPHA])
    assert kept.fit.deviance == 1.0
