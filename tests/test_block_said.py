"""What a search says of a block's runs beside its verdict: belt speeds, cycles that are not fitted, too few windows."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

import stickslip as ss
from scattering import SPEEDS, block_case
from short_search import naming
from stickslip.discovery.laboratory.block_bench import bench_of
from stickslip.discovery.laboratory.unused import with_windows
from stickslip.likelihoods.policy import POLICY

OFF = 0.94  # true over declared speed of one belt


def test_one_belt_that_is_slower_than_declared_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sticks of one run rose at 0.94 of its set-point: the search ended with nothing, and said nothing of it."""
    path = block_case(tmp_path, seed=3, scatter=0.01)
    true = SPEEDS["run_1"]
    path.write_text(path.read_text().replace(f"belt_speed = {true}", f"belt_speed = {true / OFF:.8g}"))
    naming(monkeypatch, 1)
    found = ss.discover(ss.load_case(path), threads=1)
    (said,) = [one for one in found.messages if one.startswith("run_1: the block sticks at ")]
    assert "unlike in the other runs: check its belt_speed" in said
    rides, share = (float(x) for x in re.findall(r"at ([\d.]+) m/s, ([\d.]+) times", said)[0])
    assert abs(share - OFF) < 0.015
    assert abs(rides - true) < 0.015 * true


def test_too_few_windows_are_said(tmp_path: Path) -> None:
    """Eleven windows of one run were searched as single slips, where a twelfth would have told a damping."""
    case = ss.load_case(block_case(tmp_path, few=True, seed=5))
    first = case.train[0].name
    one = replace(case, runs=tuple(run for run in case.runs if run.role != "train" or run.name == first))
    count = len(bench_of(one)[0].stretches)
    assert count < POLICY.fewest_windows
    found = ss.discover(one, threads=1)
    assert found.messages[0] == (
        f"nothing is tried: {count} stretches from stick to stick in the train runs; 12 are needed to see how friction "
        "scatters"
    )


def test_a_run_of_which_little_is_fitted_is_said(tmp_path: Path) -> None:
    case = ss.load_case(block_case(tmp_path, few=True, seed=5))
    bench, *_ = bench_of(case)
    same, nothing = with_windows(case, bench.data, bench.stretches)
    assert same == case
    assert nothing == ()
    first = [one for one in bench.stretches if one.run == 0]
    name, cycles = bench.data[0].name, len(bench.data[0].slips) - 1
    fewer = [*first[:2], *(one for one in bench.stretches if one.run)]
    _, (said,) = with_windows(case, bench.data, fewer)
    assert said == (
        f"{name}: 2 of its {cycles} cycles are fitted: between the others the block does not clearly stick"
    )
