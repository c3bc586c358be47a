"""Noise behind a sensor's filter: seen as noise, and no misfit is taken for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from discover_cases import NOISE, left_by_law, make_case
from stickslip.discovery.cleaning import cleaned
from stickslip.discovery.filtered import filtered, thinned, told
from stickslip.discovery.laboratory.hypothesis import Term
from stickslip.discovery.laboratory.left import Left, left
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.discovery.residual import describe
from stickslip.fitted.data import prepare
from stickslip.likelihoods.fit import begun
from stickslip.likelihoods.fit import fitted as full_fit
from stickslip.measured.case import Case
from studies import few

TAPS = {"mean of three": np.ones(3) / 3**0.5, "first order": 0.6 ** np.arange(15) * 0.8}


def noisy(
    taps: np.ndarray, effects=(), *, known: bool = True, size: float = 3 * NOISE, length: float = 40.0
) -> Case:
    """A case whose noise has passed a filter of unit gain in power; declared as it is, or not at all."""
    rng = np.random.default_rng(9)
    case = make_case(effects, length=length, dt=0.025, noise=1e-9)

    def draw(n: int) -> np.ndarray:
        return size * np.convolve(rng.standard_normal(n + len(taps)), taps, "full")[len(taps) : n + len(taps)]

    declared_noise = {"x1": size, "y1": size} if known else {}
    runs = [
        replace(run, x1=run.x1 + draw(len(run.t)), y1=run.y1 + draw(len(run.t)), noise=declared_noise)
        for run in case.runs
    ]
    return replace(case, runs=tuple(runs), noise=declared_noise)


def fitted(case: Case, data=None) -> tuple[list, Left]:
    data = prepare(case.runs) if data is None else data
    data, _ = cleaned(data, left_by_law(case, data[: len(case.train)]), case.noise)
    return data, left_by_law(case, data[: len(case.train)])


@pytest.mark.sampled(1)
@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("name", few(TAPS, ["first order"]))
def test_a_filter_s_noise_is_taken_at_its_size_where_readings_are_independent(name, known):
    taps = TAPS[name]
    case = noisy(taps, known=known)
    data, null = fitted(case)
    assert null.per_reading > 1.2  # as it scatters from sample to sample, it is far too large
    step, size = filtered(null, data)
    correlation = np.correlate(taps, taps, "full")[len(taps) - 1 :]
    assert abs(np.append(correlation, 0.0)[min(step, len(taps))]) < 0.1
    np.testing.assert_allclose(size[:2] * data[0].noise[:2], 3 * NOISE, rtol=0.06)
    thin = thinned(data, step, size)
    assert [len(run.t) for run in thin] == [-(-len(run.t) // step) for run in data]
    again = fitted(case, thin)[1]
    assert again.per_reading < 1.3  # what the windows have of their own takes some of it
    assert filtered(again, thin) is None
    assert f"one reading in {step} is used" in told(case, thin, step)
    assert f"{thin[0].noise[0]:.3g} in x1" in told(case, thin, step)


def test_white_noise_is_left_alone():
    data, null = fitted(noisy(np.ones(1)))
    assert describe(null).clean
    assert filtered(null, data) is None


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "effect",
    [
        ss.effect("static_aging", dT=1.0, tau=1.5),
        ss.effect("belt_speed_ripple", a=0.05, w=2.2, phi=0.0),
        ss.effect("block_quadratic_damping", c=3.0),
        ss.effect("contact_compliance", k=400.0, c=1.0),
        ss.effect("harmonic_forcing", a=0.05, w=9.0, phi=0.0),
    ],
    ids=lambda one: one.name,
)
def test_a_misfit_near_the_noise_is_no_noise(effect):
    data, null = fitted(noisy(np.ones(1), (effect,), size=NOISE, length=28.0))
    assert filtered(null, data) is None


AGING = ss.effect("static_aging", dT=1.0, tau=1.5)


@pytest.mark.study
def test_an_effect_behind_it_is_not_thinned_away():
    """With the effect in the model the rest is a filter's noise."""
    case = noisy(TAPS["mean of three"], (AGING,))
    data, _ = fitted(case)
    bench = bench_of(case, data[: len(case.train)])
    found = full_fit(begun(bench.windows((Term(AGING),))), bench.policy)
    assert filtered(left(bench, found), data)[0] == 3


@pytest.mark.study
def test_a_search_thins_when_the_effect_is_found():
    case = noisy(TAPS["mean of three"], (AGING,), length=60.0)
    found = ss.discover(case, threads=1)
    assert [one.name for one in found.effects] == ["static_aging"]
    assert found.residual_after.clean
    assert any("one reading in 3 is used" in one for one in found.messages)


@pytest.mark.study
def test_nothing_is_found_in_a_filter_s_noise():
    case = noisy(TAPS["mean of three"], length=30.0)
    for run, at in zip(case.train, (300, 702, 1000), strict=False):
        run.x1[at] += 10 * 3 * NOISE  # the third is not among one in three
    found = ss.discover(case, threads=1)
    assert found.verdict.value == "no_effect"
    assert found.residual_after.clean
    assert found.gate.observed < found.gate.threshold
    assert not any("as they scatter" in one for one in found.messages)
    assert not any("left out" in one for one in found.messages)  # no more than were read as glitches already
