"""Readings that stand out: singly and in twos, and those that only the fit of what was found lets one see."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from discover_cases import RIG, left_by_law, make_case
from stickslip.declared.effect import effect
from stickslip.discovery.cleaning import cleaned
from stickslip.discovery.laboratory.hypothesis import Term
from stickslip.discovery.laboratory.left import left
from stickslip.discovery.laboratory.readings import left_out, masked
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.discovery.messages import remarks
from stickslip.discovery.result import ErrorBlock
from stickslip.fitted.data import prepare, without_outliers
from stickslip.likelihoods.fit import begun, fitted

NOTHING = ErrorBlock("", 1.0, 1.0, 1.0, ())
CAUSE = effect("spring_cubic_k2", k=6.0)


@pytest.fixture(scope="module")
def case():
    return make_case((CAUSE,))


def taken_out(case, residual):
    run = prepare(case.train[:1])[0]
    return np.argwhere(without_outliers([run], [residual])[0].weight == 0).tolist()


def white(case):
    return np.random.default_rng(3).standard_normal((len(case.train[0].t), 2))


def test_white_noise_masks_nothing(case):
    assert taken_out(case, white(case)) == []


def test_what_stands_out_singly_or_in_twos_is_masked_and_nothing_beside_it(case):
    r = white(case)
    r[100, 0] += 20
    r[300:302, 1] += 15, 25
    r[500:502, 0] += 15, -15
    assert taken_out(case, r) == [[100, 0], [300, 1], [301, 1], [500, 0], [501, 0]]


def test_where_much_stands_out_it_is_motion_that_is_sampled_too_coarsely(case):
    r = white(case)
    often = np.arange(5, len(r) - 5, 15)
    r[often, 0] += 40
    assert taken_out(case, r) == []
    seldom = often[::2]
    r[often, 0] -= 40
    r[seldom, 0] += 40
    assert taken_out(case, r) == [[i, 0] for i in seldom]


@pytest.mark.parametrize("period", [25, 40, 120])
def test_a_smooth_misfit_far_above_the_noise_masks_nothing(case, period):
    n = len(case.train[0].t)
    assert taken_out(case, white(case) + 60 * np.sin(2 * np.pi * np.arange(n) / period)[:, None]) == []


def test_what_stands_out_from_a_fit_is_masked_in_its_windows(case):
    data = prepare(case.train)
    bench = bench_of(case, data)
    first = [next(w.start for w in bench.stretches if w.run == k) for k in range(2)]
    places = [np.array([at + 5, at + 6, at + 40, at + 41]) for at in first]
    for run, at in zip(data[:2], places, strict=True):
        run.readings[at, 0] += 25 * run.noise[0] * np.array([1, 1.2, -1, -1.1])
    found = fitted(begun(bench.windows((Term(CAUSE),))), bench.policy)
    many, _ = cleaned(data, left(bench, found), case.noise)
    assert masked(data, many) == 8
    for run, at in zip(many[:2], places, strict=True):
        assert np.argwhere(run.weight == 0).tolist() == [[i, 0] for i in at]


def test_what_is_left_out_is_said(case):
    data = prepare(case.train)
    many = [replace(run, weight=run.weight.copy()) for run in data]
    assert left_out(data, many) == ()
    for run, at in zip(many[:2], (200, 500), strict=True):
        run.weight[at : at + 2, 0] = 0.0
    count = sum(run.readings.size for run in data)
    (said,) = left_out(data, many)
    assert (
        said
        == f"left out of the fits: 4 readings that stand out from both sides ({400 / count:.2g} % of all)"
    )


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("chi2", "noise", "said"),
    [
        (0.8, {}, True),
        (0.8, {"x1": 1e-3}, True),
        (0.8, {"x1": 1e-3, "y1": 1e-3}, False),
        (0.97, {}, False),
        (1.2, {}, False),
    ],
)
def test_a_noise_estimated_too_large_is_said(case, chi2, noise, said):
    bench = bench_of(case, prepare(case.train))
    seen = left_by_law(make_case())
    seen = replace(seen, chi2=chi2 * (seen.readings - seen.dof))
    words = remarks(bench, [], seen, NOTHING, (), noise)
    assert any("the noise was estimated from the readings, and too large" in one for one in words) is said


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("c", "gain"), [(0.01, "11 %"), (-0.01, "-9.1 %"), (0.03, None), (0.93, None)])
def test_a_damping_that_a_gain_of_y1_would_be_like_is_told(c, gain):
    """c = eta1 e/(1 + e): y scaled by 1 + e, with J, k2, k3, c1 and c2 to match, leaves c1 x1' on the block alone."""
    case = make_case()
    bench, seen = bench_of(case, prepare(case.train)), left_by_law(case)
    found = SimpleNamespace(
        name="block_viscous_damping", parameters={"c": SimpleNamespace(value=c)}, alternatives=(), curve=None
    )
    said = [one for one in remarks(bench, [found], seen, NOTHING, (), {}) if "gain error" in one]
    assert len(said) == (gain is not None)
    if gain:
        assert f"a gain error of {gain} in it" in said[0]
        e = float(gain.split()[0]) / 100
        assert RIG.eta1 * e / (1 + e) == pytest.approx(c, rel=0.02)
