"""A noise that is declared a little too large hides no effect: channels are looked at, and what goes on in them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from discover_cases import left_by_law, make_case
from found_by_hand import made
from stickslip.discovery.residual import LIMIT, correlation, describe, left_over, persistence
from stickslip.fitted.data import prepare, refined
from stickslip.shown.report import words

KNOTS = [-0.6, -0.3, -0.1, 0.1, 0.3, 0.6]


def curve(size: float) -> ss.Tabulated:
    """A force on the block that nothing of the catalogue is."""
    return ss.tabulated("block", "y1", KNOTS, [0.0, size, -size, size, -size, 0.0])


def said(case: ss.Case, factor: float) -> ss.Case:
    """The case with its noise declared so many times too large."""
    noise = {name: factor * size for name, size in case.noise.items()}
    return replace(case, noise=noise, runs=tuple(replace(run, noise=noise) for run in case.runs))


@pytest.mark.study
def test_an_effect_is_found_under_a_noise_declared_three_per_cent_too_large() -> None:
    """chi-squared was 1.07 in all, which noise may leave; in x1 it was 1.22, and nothing was said to be missing."""
    case = make_case((curve(0.03),), length=30.0, speeds=(0.13, -0.14, 0.1))  # too short to tell the place
    assert ss.discover(said(case, 1.03), threads=1).verdict.value == "unlisted_effect"


@pytest.mark.study
def test_an_effect_under_a_noise_declared_too_large_is_learned_to_the_noise() -> None:
    found = ss.discover(said(make_case((curve(0.02),)), 1.03), threads=1)
    assert found.verdict.value == "unlisted_effect"
    assert [one.where for one in found.effects] == ["block"]
    assert found.residual_after.clean


@pytest.mark.sampled(2)
@pytest.mark.parametrize("factor", [1.0, 1.03, 1.1])
@pytest.mark.parametrize("seed", [2, 3])
def test_noise_alone_is_called_noise(factor: float, seed: int) -> None:
    seen = describe(left_by_law(said(make_case(seed=seed), factor)))
    assert seen.clean
    assert seen.correlated == ()


def test_a_noise_that_was_read_off_the_readings_is_no_measure_for_one_channel() -> None:
    fit = left_by_law(make_case(seed=4))
    assert fit.engine.data[0].declared == (True, True)
    small = np.array([0.9, 1.1])
    again = refined(fit.engine.data, small)
    assert {run.declared for run in again} == {(False, False)}
    assert {run.declared for run in refined(again, np.ones(2))} == {(False, False)}
    bare = replace(make_case(seed=4), noise={})
    bare = replace(bare, runs=tuple(replace(run, noise={}) for run in bare.runs))
    assert {run.declared for run in prepare(bare.train)} == {(False, False)}
    assert left_over(fit) < LIMIT


def test_persistence_is_in_sampling_errors_whatever_the_size() -> None:
    generator = np.random.default_rng(5)
    white = [[generator.standard_normal(300) for _ in range(12)] for _ in range(200)]
    found = np.array([persistence(one) for one in white])
    assert np.mean(found > LIMIT) == 0
    assert 1.2 < np.median(found) < 2.4  # the largest of twenty standard normals
    slow = [one + 0.3 * np.sin(np.arange(300) / 15) for one in white[0]]
    assert persistence(slow) > LIMIT
    assert persistence([0.1 * one for one in slow]) == pytest.approx(persistence(slow))
    assert persistence([np.ones(30)]) == 0


def test_steps_of_a_coarse_converter_are_no_misfit() -> None:
    """Readings in steps above the noise go on from one to the next of themselves."""
    case = make_case(noise=2e-4)
    step = 2e-3
    runs = tuple(
        replace(run, x1=step * np.round(run.x1 / step), y1=step * np.round(run.y1 / step))
        for run in case.runs
    )
    fit = left_by_law(replace(case, runs=runs))
    assert correlation(fit) == [0.0, 0.0]


def test_the_report_does_not_call_it_noise(tmp_path: Path) -> None:
    found, _ = made(tmp_path, verdict="no_effect")
    after = replace(found.residual_after, clean=True, chi2=1.0, parts=(), correlated=("x1",))
    found = replace(found, residual_after=after)
    assert words.clean_sentence(found).startswith("Not all is white noise")
    assert "left in x1 goes on" in words.clean_sentence(found)
    assert words.headline(found).startswith("Nothing can be named")
    plain = replace(found, residual_after=replace(after, correlated=()))
    assert words.headline(plain).startswith("Nothing is missing")
