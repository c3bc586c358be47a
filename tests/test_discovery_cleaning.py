"""Readings that stand out: singly and in twos, and those that only the fit of what was found lets one see."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from discover_cases import RIG, make_case
from stickslip.declared.effect import effect
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.discovery.loop import _cleaned, _cleaned_of_what_shows, _masked, discover
from stickslip.discovery.messages import remarks
from stickslip.discovery.result import ErrorBlock, Residual
from stickslip.discovery.rivals import Start, hypothesis
from stickslip.discovery.search import SHORT, Search
from stickslip.discovery.trace import declared
from stickslip.fitted.data import prepare, without_outliers

CAUSE = effect("spring_cubic_k2", k=6.0)


@pytest.fixture(scope="module")
def case():
    return make_case((CAUSE,))


def masked(case, residual):
    run = prepare(case.train[:1])[0]
    return np.argwhere(without_outliers([run], [residual])[0].weight == 0).tolist()


def white(case):
    return np.random.default_rng(3).standard_normal((len(case.train[0].t), 2))


def test_white_noise_masks_nothing(case):
    assert masked(case, white(case)) == []


def test_what_stands_out_singly_or_in_twos_is_masked_and_nothing_beside_it(case):
    r = white(case)
    r[100, 0] += 20
    r[300:302, 1] += 15, 25
    r[500:502, 0] += 15, -15
    assert masked(case, r) == [[100, 0], [300, 1], [301, 1], [500, 0], [501, 0]]


def test_where_much_stands_out_it_is_motion_that_is_sampled_too_coarsely(case):
    r = white(case)
    often = np.arange(5, len(r) - 5, 15)
    r[often, 0] += 40
    assert masked(case, r) == []
    seldom = often[::2]
    r[often, 0] -= 40
    r[seldom, 0] += 40
    assert masked(case, r) == [[i, 0] for i in seldom]


@pytest.mark.parametrize("period", [25, 40, 120])
def test_a_smooth_misfit_far_above_the_noise_masks_nothing(case, period):
    n = len(case.train[0].t)
    assert masked(case, white(case) + 60 * np.sin(2 * np.pi * np.arange(n) / period)[:, None]) == []


def test_what_a_misfit_hid_is_found_when_its_cause_is(case):
    data = prepare(case.train[:2])
    at = np.array([150, 151, 420, 421, 700, 701])
    for run in data:
        run.readings[at, 0] += 25 * run.noise[0] * np.array([1, 1.2, -1, -1.2, 1, -1.1])
    search = Search(data, Model(RIG, friction=PaperFriction()), 1, lambda _: None, 1e6)
    base = declared(search)
    found = search.run(hypothesis(search.model, [Start(CAUSE)]), cycles=SHORT, windows_of=base)
    few, _ = _cleaned_of_what_shows(case, data, base)
    many, _ = _cleaned_of_what_shows(case, data, found)
    assert _masked(data, few) < _masked(data, many) == 12
    for run in many:
        assert np.argwhere(run.weight == 0).tolist() == [[i, 0] for i in at]
    again = replace(search, data=many).run(found.hypothesis, cycles=SHORT)
    assert again.excess < 3 < found.excess
    same, said = _cleaned_of_what_shows(case, many, again)
    assert same is many
    assert said == ()


@pytest.mark.study
def test_what_is_left_out_is_said(case):
    runs = [replace(run, x1=run.x1.copy()) for run in case.runs]
    for run, at in zip(runs[:2], (200, 500), strict=True):
        run.x1[at : at + 2] += 0.03
    found = discover(replace(case, runs=tuple(runs)))
    assert [one.name for one in found.effects] == [CAUSE.name]
    said = [one for one in found.messages if one.startswith("left out of the fits")]
    assert said == ["left out of the fits: 4 readings that stand out from both sides (0.052 % of all)"]


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
    data = prepare(case.train)
    search = Search(data, Model(case.rig, friction=case.friction), 1, lambda _: None, 60.0)
    null = search.run(hypothesis(search.model, []), cycles=SHORT, iterations=1)
    after = Residual(chi2, 0.01, 1.0, chi2 < 1.04, (), "")
    error = ErrorBlock("", 1.0, 1.0, 1.0, ())
    words = remarks(data, null, [], after, error, (), noise)
    assert any("the noise was estimated from the readings, and too large" in one for one in words) is said


@pytest.mark.parametrize(("c", "gain"), [(0.01, "11 %"), (-0.01, "-9.1 %"), (0.03, None), (0.93, None)])
def test_a_damping_that_a_gain_of_y1_would_be_like_is_told(c, gain):
    """c = eta1 e/(1 + e): y scaled by 1 + e, with J, k2, k3, c1 and c2 to match, leaves c1 x1' on the block alone."""
    case = make_case()
    search = Search(prepare(case.train), Model(RIG, friction=PaperFriction()), 1, lambda _: None, 1e6)
    null = search.run(hypothesis(search.model, []), cycles=SHORT)
    found = SimpleNamespace(
        name="block_viscous_damping", parameters={"c": SimpleNamespace(value=c)}, alternatives=(), curve=None
    )
    after = Residual(1.0, 0.01, 1.0, True, (), "")
    said = [
        one
        for one in remarks(search.data, null, [found], after, ErrorBlock("", 1.0, 1.0, 1.0, ()), (), {})
        if "gain error" in one
    ]
    assert len(said) == (gain is not None)
    if gain:
        assert f"a gain error of {gain} in it" in said[0]
        e = float(gain.split()[0]) / 100
        assert RIG.eta1 * e / (1 + e) == pytest.approx(c, rel=0.02)


def test_on_cleaned_readings_the_law_is_fitted_on_from_where_it_was(case):
    data = prepare(case.train)
    data[0].readings[300, 0] += 25 * data[0].noise[0]
    search = Search(data, Model(RIG, friction=PaperFriction()), 1, lambda _: None, 1e6)
    out, _, known = _cleaned(case, data, search)
    assert _masked(data, out) == 1
    search = replace(search, data=out)
    afresh, on = declared(search), declared(search, known)
    assert on.fit.cost == pytest.approx(afresh.fit.cost, rel=1e-4)
    assert on.fit.readings == afresh.fit.readings
    assert on.fit.iterations < afresh.fit.iterations
