"""A declared constant that is wrong, held against what was found without it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from discover_cases import spring_bench
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.laboratory import search as searching
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.constants import Freed
from stickslip.discovery.laboratory.trials import Trial
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit


@pytest.fixture(scope="module")
def bench() -> BeltBench:
    return spring_bench()


@pytest.fixture(scope="module")
def fit(bench: BeltBench) -> Fit:
    return null(bench.windows(), bench.policy)


def test_a_constant_is_wrong_only_beside_a_model_of_the_windows(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fit whose friction scattered by 22 % had a mass of its own, and told that the declared one is wrong."""
    off = Freed("alpha1", 0.2, 0.01, 0.01, 900.0, bench.declared)
    monkeypatch.setattr(searching, "freed", lambda *_: [off])
    monkeypatch.setattr(searching, "with_freed", lambda _, __, trial, wrong: replace(trial, freed=wrong))
    monkeypatch.setattr(Trial, "whole", lambda one: -900.0 if one.freed else 0.0)
    known = Uncertainty(bench.model.rig, {}, {}, {})
    usual = Trial((), replace(fit, population=fit.windows.scatter()))
    lost = Trial((), replace(fit, population=replace(fit.windows.scatter(), curve=0.22)))
    assert searching.with_wrong_constant(bench, known, usual, usual).freed == off
    assert searching.with_wrong_constant(bench, known, lost, lost).freed is None


@pytest.mark.parametrize(("sds", "told"), [(0.5, False), (6.5, True)])
def test_two_constants_that_do_the_work_of_one_do_not_hide_it(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, sds: float, told: bool
) -> None:
    """A gain of 1.1 was a block and a spring each 10 % off: 6 standard uncertainties, which tails forgave."""
    off = Freed("x1", 0.1, 0.01, 0.005, 60.0, bench.declared)
    monkeypatch.setattr(searching, "freed", lambda *_: [off])
    own = fit.windows.prior.group[:2]
    at = fit.windows.prior.centre.copy()
    there = Trial((), replace(fit, at=at, population=fit.windows.scatter()))
    at = at.copy()
    at[own] += sds * fit.windows.prior.uncertainty[:2]
    both = replace(there, fit=replace(there.fit, at=at))
    worse = replace(there.fit, deviance=there.fit.deviance + 2.0)
    monkeypatch.setattr(searching, "with_freed", lambda _, __, ___, one: Trial((), worse, freed=one))
    known = Uncertainty(bench.model.rig, {}, {}, {})
    assert (searching.with_wrong_constant(bench, known, both, both).freed is not None) == told


def test_constants_are_sought_within_twice_and_half_of_what_is_declared(bench: BeltBench) -> None:
    """Masses, springs and a gain may shrink together: a fit went to a quarter of a block, and found nothing else."""
    numbers = {one.name: one for one in bench.windows().numbers}
    for name in ("alpha1", "beta3", "eta1"):
        one, declared = numbers[name], bench.model.parameters[name]
        assert [math.exp(x) for x in (one.low, one.high)] == pytest.approx([declared / 2, declared * 2])
    assert (numbers["gain.x1"].low, numbers["gain.x1"].high) == (-0.5, 0.5)
