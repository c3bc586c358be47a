"""What a search says of a block's runs beside its verdict: belt speeds, cycles that are not fitted, too few windows."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from scattering import SPEEDS, block_case
from short_search import naming
from stickslip.discovery.laboratory.block_bench import bench_of
from stickslip.discovery.laboratory.unused import usable, with_windows
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
        f"nothing is tried: {count} stretches from stick to stick, or from slip to slip, in the train runs; 12 are "
        "needed to see how friction scatters"
    )


def test_runs_without_sticks_are_said(tmp_path: Path) -> None:
    case = ss.load_case(block_case(tmp_path, few=True, seed=5))
    bench, _, data, why = bench_of(case)
    assert why == {}
    same, nothing = with_windows(case, bench.data, bench.stretches, why)
    assert same == case
    assert nothing == ()
    name = bench.data[0].name
    swings = [one if one.run else replace(one, stuck=False) for one in bench.stretches]
    _, said = with_windows(case, bench.data, swings, why)
    assert said == (
        f"{name}: no stick is found in it: it is fitted from slip to slip, each from a start of its own",
    )
    less, gone = with_windows(case, data[1:2], [], {name: "not of use"})
    assert name not in {run.name for run in less.runs}
    assert gone[0] == f"{name}: not of use"


@pytest.mark.parametrize(
    ("factor", "slips", "why"),
    [(1.0, True, None), (100.0, True, "belt_speed is"), (1.0, False, "nothing in it rises at belt_speed")],
)
def test_a_run_is_of_use_if_its_set_point_may_be_right(
    factor: float, slips: bool, why: str | None, tmp_path: Path
) -> None:
    path = block_case(tmp_path, few=True, seed=5)
    data = bench_of(ss.load_case(path))[2][:2]
    second = SPEEDS[data[1].name]
    path.write_text(path.read_text().replace(f"belt_speed = {second}", f"belt_speed = {factor * second}"))
    case = ss.load_case(path)
    data[1] = replace(data[1], belt_speed=factor * data[1].belt_speed)
    if not slips:
        data[1] = replace(data[1], slips=np.zeros(0, dtype=np.int64))
    used, reasons = usable(case.train, data)
    assert [run.name for run in used] == [run.name for run in data[: 1 if why else 2]]
    assert all(text.startswith(f"no slip is used: {why}") for text in reasons.values())
    assert set(reasons) == ({data[1].name} if why else set())
