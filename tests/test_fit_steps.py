"""Steps of a fit whose windows are far from what the model makes of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from discover_cases import make_case
from stickslip.declared.effect import effect
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.hypothesis import term
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.fitted.data import prepare
from stickslip.likelihoods import fit
from stickslip.likelihoods.fit import begun, fitted, null
from stickslip.likelihoods.repeating import swollen

MOST_SCATTER = 0.2  # more takes a spring for scatter


@pytest.fixture(scope="module")
def bench() -> BeltBench:
    """Runs of a rig whose spring stiffens far more than the declared one."""
    case = make_case((effect("spring_cubic_k1", k=60.0),), dt=0.04, speeds=(0.13, -0.14, 0.1))
    return bench_of(case, prepare(case.train))


def test_a_population_that_is_freed_lowers_the_deviance(bench: BeltBench) -> None:
    """It followed the linearised windows: from 14,000 to 174,000, and friction that scatters by half."""
    first = begun(bench.windows())
    before = fitted(first, bench.policy, most=bench.policy.held).deviance
    for more in (1, 5, 20):
        after = fitted(first, bench.policy, most=bench.policy.held + more)
        assert after.deviance <= before
        assert max(after.population.friction) < MOST_SCATTER
        before = after.deviance


def test_a_population_moves_though_the_windows_do_not_follow(bench: BeltBench) -> None:
    """It stayed where it began and held the windows where nothing fits; it goes no further than is usual."""
    found = fitted(begun(bench.windows()), bench.policy)
    assert max(found.population.friction) > 2 * max(bench.windows().scatter().friction)
    assert not swollen(found)


def test_a_population_that_is_far_from_the_windows_comes_back(bench: BeltBench) -> None:
    """Beside the effect that acts, friction that is taken to scatter by a tenth is found to be all but even."""
    (kind,) = [one for one in bench.kinds() if one.name == "spring_cubic_k1"]
    windows = bench.windows((term(kind, {"k": 60.0}),))
    ends = []
    for times in (1.0, 6.0):
        found = fitted(replace(begun(windows), population=windows.scatter().wider(times)), bench.policy)
        ends.append(found.deviance)
        assert max(found.population.friction) < 0.005
    assert abs(ends[0] - ends[1]) < 1.0


def test_a_search_begins_with_scatter_as_usual_where_more_would_hide_what_lacks(
    bench: BeltBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    windows = bench.windows()
    monkeypatch.setattr(fit, "beyond_shown", lambda _: True)
    usual = pytest.approx(windows.scatter().friction)
    assert null(windows, bench.policy, twice=True).population.friction == usual
    # what scatters is what is asked for where nothing is sought
    assert null(windows, bench.policy).population.friction != usual
